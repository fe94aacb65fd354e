"""The asynchronous Python client in the scenarios of README.md."""

import asyncio
import json
import sys
from collections.abc import Awaitable
from typing import Any

import numpy as np

import piad
from python import Json, summary


async def new(client: piad.AsyncClient, request: Json) -> piad.AsyncJob:
    """The JSON of a job for a request."""
    [shape] = [request[kind] for kind in ("curve", "surface") if kind in request]
    return await client.create(shape["points"], **request.get("stop", {}))


async def levels(job: piad.AsyncJob, pause: float = 0.0, ready: bool = False) -> Json:
    numbers, points = [], []
    async for iteration in job.iterations(view="control_points"):
        numbers.append(iteration.number)
        points = [*points[:1], np.asarray(iteration.geometry.control_points).ravel()]
        if ready and iteration.number == 5:
            print("ready", flush=True)
        await asyncio.sleep(pause)
    return {"numbers": numbers, "first": points[0].tolist(), "last": points[-1].tolist(), "state": job.status.state}


async def fit(client: piad.AsyncClient, request: Json) -> Json:
    return summary(await (await new(client, request)).result())


async def watch(client: piad.AsyncClient, request: Json) -> Json:
    return await levels(await new(client, request))


async def resume(client: piad.AsyncClient, request: Json) -> Json:
    return await levels(await new(client, request), ready=True)


async def cancel(client: piad.AsyncClient, request: Json) -> Json:
    job = await new(client, request)
    async for _ in job.iterations(view="errors"):
        break
    state = (await job.cancel()).state
    return {"state": state, "again": (await job.cancel()).state}


async def edit(client: piad.AsyncClient, request: Json) -> Json:
    job = await new(client, request["job"])
    await job.wait()
    change = await job.edit({move["index"]: move["point"] for move in request["edit"]["points"]})
    result = summary(await change.result())
    parent = change.status.parent or {}
    return {**result, "parent": job.id, "is_parent": parent.get("id") == job.id}


async def errors(client: piad.AsyncClient, request: Json) -> Json:
    problem = (await refused(new(client, request))).problem
    return {"status": problem.status, "type": problem.type, "pointers": list(problem.pointers), "detail": problem.detail}


async def tokens(client: piad.AsyncClient, request: Json) -> Json:
    async with piad.AsyncClient(sys.argv[2]) as anonymous:
        without = (await refused(new(anonymous, request))).problem.type
    return {"without": without, "with": (await (await new(client, request)).wait()).state}


async def large(client: piad.AsyncClient, request: Json) -> Json:
    found = await levels(await new(client, request))
    return {"numbers": found["numbers"], "count": len(found["last"]), "sum": sum(found["last"])}


async def differences(client: piad.AsyncClient, request: Json) -> Json:
    job = await new(client, request)
    numbers, points = [], []
    async for iteration in job.iterations(encoding="delta"):
        numbers.append(iteration.number)
        points.append(np.asarray(iteration.control_points).ravel().tolist())
    return {"numbers": numbers, "points": points, "state": job.status.state}


async def slow(client: piad.AsyncClient, request: Json) -> Json:
    return await levels(await new(client, request), pause=0.02)


async def refused(call: Awaitable[Any]) -> piad.ApiError:
    try:
        await call
    except piad.ApiError as error:
        return error
    raise SystemExit("it was not refused")


SCENARIOS = {it.__name__: it for it in (fit, watch, resume, cancel, edit, errors, tokens, large, differences, slow)}


async def main(name: str, url: str, token: str) -> None:
    async with piad.AsyncClient(url, token=token) as client:
        print(json.dumps(await SCENARIOS[name](client, json.load(sys.stdin))))


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))

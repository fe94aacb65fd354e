"""The Python client in the scenarios of README.md."""

import itertools
import json
import sys
import time
from typing import Any

import numpy as np

import piad

Json = dict[str, Any]


def new(client: piad.Client, request: Json) -> piad.Job:
    """The JSON of a job for a request."""
    [(kind, shape)] = [(kind, request[kind]) for kind in ("curve", "surface") if kind in request]
    stop = request.get("stop", {})
    assert kind == "surface" or isinstance(shape["points"][0][0], (int, float))
    return client.create(shape["points"], **stop)


def summary(result: Any) -> Json:
    geometry = result.geometry
    points = np.asarray(geometry.control_points)
    bases = [geometry.basis] if hasattr(geometry, "basis") else [geometry.bases[0]]
    return {
        "state": result.state,
        "iteration": result.iteration,
        "error": result.error.max,
        "control_points": points.ravel().tolist(),
        "knots": np.asarray(bases[0].knots).tolist() if bases[0].knots is not None else None,
    }


def levels(job: piad.Job, pause: float = 0.0, ready: bool = False) -> Json:
    numbers, points = [], []
    for iteration in job.iterations(view="control_points"):
        numbers.append(iteration.number)
        points = [*points[:1], np.asarray(iteration.geometry.control_points).ravel()]
        if ready and iteration.number == 5:
            print("ready", flush=True)
        time.sleep(pause)
    return {"numbers": numbers, "first": points[0].tolist(), "last": points[-1].tolist(), "state": job.status.state}


def fit(client: piad.Client, request: Json) -> Json:
    return summary(new(client, request).result())


def watch(client: piad.Client, request: Json) -> Json:
    return levels(new(client, request))


def resume(client: piad.Client, request: Json) -> Json:
    return levels(new(client, request), ready=True)


def cancel(client: piad.Client, request: Json) -> Json:
    job = new(client, request)
    next(iter(job.iterations(view="errors")))
    state = job.cancel().state
    return {"state": state, "again": job.cancel().state}


def edit(client: piad.Client, request: Json) -> Json:
    job = new(client, request["job"])
    job.wait()
    change = job.edit({move["index"]: move["point"] for move in request["edit"]["points"]})
    result = summary(change.result())
    parent = change.status.parent or {}
    return {**result, "parent": job.id, "is_parent": parent.get("id") == job.id}


def errors(client: piad.Client, request: Json) -> Json:
    problem = refused(lambda: new(client, request)).problem
    return {"status": problem.status, "type": problem.type, "pointers": list(problem.pointers), "detail": problem.detail}


def tokens(client: piad.Client, request: Json) -> Json:
    with piad.Client(sys.argv[2]) as anonymous:
        without = refused(lambda: new(anonymous, request)).problem.type
    return {"without": without, "with": new(client, request).wait().state}


def large(client: piad.Client, request: Json) -> Json:
    summary = levels(new(client, request))
    return {"numbers": summary["numbers"], "count": len(summary["last"]), "sum": sum(summary["last"])}


def differences(client: piad.Client, request: Json) -> Json:
    job = new(client, request)
    all = [(it.number, np.asarray(it.control_points).ravel().tolist()) for it in job.iterations(encoding="delta")]
    numbers, points = map(list, zip(*all))
    return {"numbers": numbers, "points": points, "state": job.status.state}


def slow(client: piad.Client, request: Json) -> Json:
    return levels(new(client, request), pause=0.02)


def refused(call: Any) -> piad.ApiError:
    try:
        call()
    except piad.ApiError as error:
        return error
    raise SystemExit("it was not refused")


SCENARIOS = [fit, watch, resume, cancel, edit, errors, tokens, large, differences, slow]

if __name__ == "__main__":
    _, name, url, token = sys.argv
    [scenario] = itertools.islice((it for it in SCENARIOS if it.__name__ == name), 1)
    with piad.Client(url, token=token) as client:
        print(json.dumps(scenario(client, json.load(sys.stdin))))

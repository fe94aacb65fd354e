"""Ephemeral edits, as while a point is dragged."""

from __future__ import annotations

import asyncio
import math
from typing import Any

import numpy as np
import pytest
from conftest import Server
from shapes import CURVE, FITS
from test_jobs import MANY, SLOW

import piad

MOVED = [1.0, 2.0, 3.0]
SLOW_PREVIEW: Any = {name: SLOW[name] for name in ("relative_tolerance", "max_iterations")}


@pytest.mark.parametrize("name", ["curve", "homogeneous", "fixed", "closed"])
@pytest.mark.parametrize("with_start", [False, True])
def test_previews_are_what_edits_would_be(client: piad.Client, name: str, with_start: bool) -> None:
    job = client.create(**FITS[name])
    job.wait()
    before = len(list(client.jobs()))
    start = job.iteration() if with_start else None
    levels = list(job.preview({3: MOVED}, start=start))
    assert len(list(client.jobs())) == before
    edit = list(job.edit({3: MOVED}).iterations(encoding="json"))
    assert [level.number for level in levels] == [level.number for level in edit]
    for level, expected in zip(levels, edit):
        assert np.array_equal(level.control_points, expected.control_points)  # type: ignore[arg-type]
        assert level.geometry.knots == expected.geometry.knots
    assert np.array_equal(levels[-1].geometry.as_bspline().weights, edit[-1].geometry.as_bspline().weights)  # type: ignore[arg-type]


def test_previews_of_surfaces_from_an_iteration(client: piad.Client) -> None:
    job = client.create(**FITS["surface"])
    job.wait()
    start = job.iteration(2)
    method: Any = {"kind": "local", "indices": [[1, 2]]}
    levels = list(job.preview({(1, 2): np.array([1.0, 2.0, 0.5])}, start=start, method=method, max_iterations=5))
    edit = job.edit({(1, 2): [1.0, 2.0, 0.5]}, iteration=2, method=method, max_iterations=5)
    for level, expected in zip(levels, list(edit.iterations())):
        assert np.array_equal(level.control_points, expected.control_points)  # type: ignore[arg-type]
    assert [level.number for level in levels] == list(range(6))
    (last,) = job.preview({(1, 2): [1.0, 2.0, 0.5]}, start=start, method=method, max_iterations=5, every=1_000_000)
    assert np.array_equal(last.control_points, levels[-1].control_points)  # type: ignore[arg-type]
    *_, last = job.preview({(1, 2): [1.0, 2.0, 0.5]}, start=start, method=method, max_iterations=5, pace="latest")
    assert np.array_equal(last.control_points, levels[-1].control_points)  # type: ignore[arg-type]


def test_previews_start_from_iterations_without_control_points(client: piad.Client) -> None:
    job = client.create(CURVE)
    *_, start = job.iterations(view="errors")
    assert [level.control_points is not None for level in job.preview({3: MOVED}, start=start, max_iterations=2)] == [True] * 3


def test_errors_in_previews(client: piad.Client) -> None:
    job = client.create(CURVE)
    job.wait()
    with pytest.raises(piad.ApiError) as refused:
        list(job.preview({30: MOVED}))
    assert refused.value.problem.pointers == ("/points/0/index",)
    with pytest.raises(ValueError, match="must be finite"):
        list(job.preview({3: [0.0, 1.0, float("inf")]}))


def test_failed_previews_say_why(client: piad.Client) -> None:
    points = [[i, math.sin(i)] for i in range(900)]
    job = client.create(points, parameters="uniform", basis="bernstein", max_iterations=1)
    job.wait()
    with pytest.raises(piad.JobFailed) as failed:
        list(job.preview({3: [3.0, 9.0]}, method={"kind": "extended"}, max_iterations=1000))
    assert failed.value.problem is not None and failed.value.problem.type == "/problems/overflow"


def test_newer_positions_replace_older_ones(server: Server) -> None:
    async def main() -> None:
        async with piad.AsyncClient(server.url) as client:
            job = await client.create(MANY, basis="bernstein", max_iterations=3)
            await job.wait()
            older = job.preview({3: [3.0, 9.0]}, session="drag", **SLOW_PREVIEW)
            assert (await older.__anext__()).number == 0
            newer = job.preview({3: [3.0, 10.0]}, session="drag", **SLOW_PREVIEW)
            assert (await newer.__anext__()).number == 0
            count = 0
            async for _ in older:
                count += 1
            assert count < SLOW["max_iterations"]
            await newer.aclose()

    asyncio.run(asyncio.wait_for(main(), 60))


def test_previews_do_not_go_on_elsewhere(durable_server: Server) -> None:
    with piad.Client(durable_server.url) as client:
        job = client.create(MANY, basis="bernstein", max_iterations=3)
        job.wait()
        levels = job.preview({3: [3.0, 9.0]}, **SLOW_PREVIEW)
        next(levels)
        durable_server.kill()
        with pytest.raises(piad.ConnectionLost):
            for _ in levels:
                pass
        durable_server.start()
        assert next(job.preview({3: [3.0, 9.0]}, max_iterations=2)).number == 0

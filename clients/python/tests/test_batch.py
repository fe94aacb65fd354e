"""Many fits in one request."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import AsyncIterator, Iterator
from typing import Any

import httpx
import numpy as np
import pytest
from conftest import Server
from shapes import CURVE, SURFACE

import piad


def wave(number: int, count: int = 50) -> np.ndarray[Any, Any]:
    x = np.linspace(0, 7, count)
    return np.column_stack([x, np.sin(x + number)])


def test_items_are_what_fits_of_their_own_are(client: piad.Client) -> None:
    batch = client.batch([CURVE, SURFACE, {"name": "third", "curve": {"points": wave(3), "closed": False}}])
    items = list(batch)
    assert [item.index for item in items] == [0, 1, 2]
    for item, points in zip(items, [CURVE, SURFACE, wave(3)]):
        alone = client.fit(points)
        assert item.converged and item.problem is None and item.result is not None
        assert item.error == alone.error and item.iteration == alone.iteration
        assert np.array_equal(item.result.geometry.control_points, alone.geometry.control_points)
        assert item.result.geometry.knots == alone.geometry.knots
        for own, other in zip(item.result.parameters, alone.parameters):
            assert np.array_equal(own, other)
    assert items[2].name == "third" and "converged" in repr(items[2])
    assert items[0].curve.degree == 3 and items[1].surface.degrees == (3, 3)
    with pytest.raises(TypeError, match="curve, not a surface"):
        items[0].surface
    assert (batch.totals.items, batch.totals.converged, batch.totals.failed) == (3, 3, 0)
    assert list(batch) == []


def test_thousands_of_items_from_a_generator(client: piad.Client) -> None:
    """More items than fit in one request; indices in errors are those of the batch."""
    taken = 0

    def items() -> Iterator[Any]:
        nonlocal taken
        for number in range(2000):
            taken += 1
            yield wave(number) if number != 1500 else [[0, 0], [1, 1], [1, 1]]

    batch = client.batch(items(), tolerance=0.01, control_points="auto")
    first = next(iter(batch))
    assert first.index == 0 and taken < 2000, "items are taken as they are needed"
    rest = list(batch)
    assert [item.index for item in rest] == list(range(1, 2000))
    wrong = rest[1499]
    assert wrong.state == "failed" and wrong.problem is not None and wrong.result is None
    assert wrong.problem.pointers == ("/items/1500/curve/points/2",)
    assert wrong.problem.detail.startswith("/items/1500/curve/points/2: ")
    with pytest.raises(piad.ApiError, match="/items/1500"):
        wrong.curve
    assert batch.totals == piad.BatchTotals(2000, 1999, 1)
    assert len(rest[0].curve.control_points) < 30


def test_defaults_hold_for_items_that_do_not_say_it(client: piad.Client) -> None:
    items = [wave(1), {"curve": {"points": wave(1), "degree": 5}, "stop": {"max_iterations": 1}}, SURFACE]
    defaults = {"stop": {"max_iterations": 2}, "method": {"kind": "weighted", "omega": np.float64(0.9)}}
    fitted = list(client.batch(items, defaults, degree=2, tolerance=1e-12))
    assert [item.state for item in fitted] == ["exhausted", "exhausted", "exhausted"]
    assert [item.iteration for item in fitted] == [2, 1, 2]
    # The result has the achieved distance and the reason of the failure.
    assert fitted[0].curve.degree == 2 and fitted[1].curve.degree == 5 and fitted[2].surface.degrees == (2, 2)
    assert fitted[0].problem is not None and fitted[0].problem.type == "/problems/not-converged"
    with pytest.raises(piad.ApiError, match="/defaults/tolerance"):
        list(client.batch([wave(1)], {"tolerance": 1}))
    assert list(client.batch([])) == []


def test_items_that_are_no_fits_fail_alone(client: piad.Client) -> None:
    broken = wave(2)
    broken[3, 1] = math.nan
    items = list(client.batch([wave(1), broken, {"curves": 1}, wave(3)]))
    assert [item.state for item in items] == ["converged", "failed", "failed", "converged"]
    assert items[1].problem is not None and items[1].problem.pointers[0].startswith("/items/1/curve/points/3")
    with pytest.raises(ValueError, match="1 dimensions"):
        list(client.batch([[1, 2, 3]]))


def test_a_batch_that_is_left_ends(client: piad.Client) -> None:
    batch = client.batch(wave(number) for number in range(500))
    items = iter(batch)
    assert next(items).index == 0
    items.close()
    assert batch.totals.items == 1
    assert client.fit(CURVE).state == "converged"


def test_what_has_no_answer_is_sent_again(durable_server: Server) -> None:
    """A server that is killed in the middle and started again."""
    with piad.Client(durable_server.url) as client:
        seen = []
        for item in client.batch(wave(number) for number in range(1000)):
            seen.append(item.index)
            if item.index == 300:
                durable_server.kill()
                durable_server.start()
        assert seen == list(range(1000))


def test_a_server_without_room_is_asked_again() -> None:
    asked = 0

    def answer(request: httpx.Request) -> httpx.Response:
        nonlocal asked
        asked += 1
        if asked == 1:
            problem = {"type": "/problems/queue-full", "title": "full", "status": 503, "detail": "full"}
            headers = {"content-type": "application/problem+json", "retry-after": "0"}
            return httpx.Response(503, json=problem, headers=headers)
        count = request.content.count(b"\n")
        lines = [f'{{"index": {index}, "state": "failed", "problem": {{"detail": "/items/{index}: no"}}}}\n' for index in range(count)]
        if asked == 2:
            # The connection breaks after the first item.
            return httpx.Response(200, text=lines[0])
        return httpx.Response(200, text="".join(lines) + '{"totals": {}}\n')

    with piad.Client(transport=httpx.MockTransport(answer)) as client:
        items = list(client.batch([wave(0), wave(1), wave(2)]))
    assert [item.index for item in items] == [0, 1, 2]
    assert [item.problem.detail for item in items if item.problem] == ["/items/0: no", "/items/1: no", "/items/2: no"]
    assert asked == 3


def test_event_loops(server: Server) -> None:
    async def slow() -> AsyncIterator[Any]:
        for number in range(8):
            await asyncio.sleep(0.2)
            yield wave(number)

    async def main() -> None:
        async with piad.AsyncClient(server.url) as client:
            batch = client.batch(slow())
            came = [(item.index, time.monotonic()) async for item in batch]
            assert [index for index, _ in came] == list(range(8))
            assert came[0][1] < came[-1][1] - 0.2, "items that come slowly are not held back"
            assert batch.totals.converged == 8
            states = [item.state async for item in client.batch(wave(number) for number in range(300))]
            assert states == ["converged"] * 300

    asyncio.run(main())


def test_items_say_what_was_chosen(client: piad.Client) -> None:
    x, y = np.meshgrid(np.linspace(0, 3, 12), np.linspace(0, 2, 11))
    points = np.column_stack([x.ravel(), y.ravel(), np.sin(x.ravel())])
    method = {"kind": "least_squares", "variant": "direct", "control_points": 5}
    first, second = client.batch([{"surface": {"scattered": points}, "method": method}, wave(1)])
    assert len(first.notices) == 1 and first.notices[0].startswith("the parameters of the points are")
    assert second.notices == ()

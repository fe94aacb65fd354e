"""Each iteration once and in order, even if connections break."""

from __future__ import annotations

import re
import time
from typing import Any

import httpx
import numpy as np
import pytest
from conftest import Server
from shapes import CURVE, FITS
from test_jobs import MANY

import piad
from piad import _sse


@pytest.mark.parametrize("name", FITS)
@pytest.mark.parametrize("encoding", ["json", "base64"])
def test_iterations_come_in_order(client: piad.Client, name: str, encoding: Any) -> None:
    job = client.create(**FITS[name])
    levels = list(job.iterations(encoding=encoding))
    assert [level.number for level in levels] == list(range(len(levels)))
    assert job.status.ended
    result = job.result()
    assert result.iteration == levels[-1].number
    assert levels[-1].geometry.knots == result.geometry.knots
    assert np.array_equal(levels[-1].control_points, result.geometry.control_points)  # type: ignore[arg-type]
    assert np.array_equal(levels[0].control_points, job.iteration(0).control_points)  # type: ignore[arg-type]


def test_views_and_choices(client: piad.Client) -> None:
    job = client.create(CURVE)
    job.wait()
    last = job.status.iteration
    assert all(level.control_points is None for level in job.iterations(view="errors"))
    sampled = next(job.iterations(view="samples", samples=11)).samples
    assert sampled is not None and sampled.points.shape == (11, 3)
    assert [level.number for level in job.iterations(every=5)] == [*range(0, last or 0, 5), last]
    reached = [level.milestone for level in job.iterations(milestones=[1e-1, 1e-2, 1e-3])]
    assert reached[-2:] == [1e-3, None]
    assert [level.number for level in job.iterations(after=3)][0] == 4
    assert list(job.iterations(pace="latest"))[-1].number == last
    assert len(list(job.iterations(digits="auto"))) == (last or 0) + 1
    single = next(job.iterations(encoding="base64_f32")).control_points
    assert np.allclose(single, job.iteration(0).control_points, rtol=1e-6)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["curve", "homogeneous", "closed", "surface"])
def test_changes_are_applied(client: piad.Client, name: str) -> None:
    index: Any = [[2, 2]] if name == "surface" else [2]
    job = client.create(**FITS[name], **{"method": {"kind": "local", "indices": index}})
    for level, full in zip(job.iterations(changed=True), job.iterations()):
        assert np.array_equal(level.control_points, full.control_points)  # type: ignore[arg-type]
        assert (level.weights is None) == (full.weights is None)
        assert level.weights is None or np.array_equal(level.weights, full.weights)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", FITS)
@pytest.mark.parametrize("view", ["control_points", "samples"])
def test_differences_are_applied(client: piad.Client, name: str, view: Any) -> None:
    job = client.create(**FITS[name])
    job.wait()
    exact = list(job.iterations(view=view, encoding="base64"))
    near = list(job.iterations(view=view, encoding="delta"))
    assert [level.number for level in near] == [level.number for level in exact]
    for level, full in zip(near, exact):
        for array, expected in zip(_arrays(level), _arrays(full)):
            assert array.shape == expected.shape
            bound = (full.error.max or 0) / 64 + 1e-14 * np.abs(expected).max()
            assert np.abs(array - expected).max() <= bound
    for array, expected in zip(_arrays(near[-1]), _arrays(exact[-1])):
        assert np.array_equal(array, expected)


def _arrays(level: piad.Iteration) -> list[Any]:
    if level.samples is not None:
        return [level.samples.points]
    return [array for array in (level.control_points, level.weights) if array is not None]


def test_streams_of_the_job_itself(client: piad.Client) -> None:
    job = client.create(CURVE, stream={"view": "errors", "every": 2, "describe": "none", "on_disconnect": "cancel"})
    assert job.shape().bases[0].degree == 3
    assert job.wait().state == "converged"
    assert all(level.control_points is None for level in job.iterations())


@pytest.mark.parametrize("changed", [False, True])
def test_streams_survive_kills(durable_server: Server, changed: bool) -> None:
    """Kills the server twice in mid-stream and restarts it with the same data and port."""
    with piad.Client(durable_server.url) as client:
        job = client.create(MANY, basis="bernstein", relative_tolerance=1e-15, max_iterations=3000)
        numbers: list[int] = []
        for level in job.iterations(changed=changed):
            numbers.append(level.number)
            if level.number in (200, 1000):
                durable_server.kill()
                durable_server.start()
        assert numbers == list(range(3001))
        assert job.status.state == "exhausted"
        fresh = job.iteration(2999).control_points
        assert fresh is not None and np.isfinite(fresh).all()


def test_streams_give_up(durable_server: Server) -> None:
    with piad.Client(durable_server.url, attempts=2) as client:
        job = client.create(MANY, basis="bernstein", relative_tolerance=1e-15, max_iterations=100_000)
        levels = job.iterations(view="control_points")
        next(levels)
        durable_server.kill()
        with pytest.raises(piad.ConnectionLost):
            for _ in levels:
                pass
        with pytest.raises(piad.ConnectionLost):
            job.refresh()


class Flaky(httpx.BaseTransport):
    """Serves responses from a list first, then real ones; an exception is a connection that breaks after the request
    arrived.
    """

    def __init__(self, *answers: httpx.Response | httpx.TransportError):
        self._real, self._answers = httpx.HTTPTransport(), list(answers)
        self.requests = 0

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        self.requests += 1
        if not self._answers:
            return self._real.handle_request(request)
        answer = self._answers.pop(0)
        if isinstance(answer, httpx.Response):
            return answer
        self._real.handle_request(request).read()
        raise answer


def test_lost_answers_make_one_job(server: Server) -> None:
    transport = Flaky(httpx.ReadError("lost"), httpx.RemoteProtocolError("lost"))
    with piad.Client(server.url, transport=transport) as client, piad.Client(server.url) as other:
        before = len(list(other.jobs()))
        client.create(CURVE)
        assert transport.requests == 3
        assert len(list(other.jobs())) == before + 1


def test_lost_answers_to_deletions(server: Server) -> None:
    with piad.Client(server.url) as client:
        id = client.create(CURVE).id
    transport = Flaky()
    with piad.Client(server.url, transport=transport) as client:
        job = client.job(id)
        transport._answers.append(httpx.ReadError("lost"))
        job.delete()


def test_retry_after_is_waited_for(server: Server) -> None:
    transport = Flaky(httpx.Response(503, headers={"Retry-After": "1"}), httpx.Response(429, headers={"Retry-After": "0"}))
    with piad.Client(server.url, transport=transport) as client:
        started = time.monotonic()
        client.create(CURVE)
        assert time.monotonic() - started >= 1
        assert transport.requests == 3


def test_attempts_are_bounded(server: Server) -> None:
    answers = [httpx.Response(503, headers={"Retry-After": "0"}) for _ in range(5)]
    transport = Flaky(*answers)
    with piad.Client(server.url, attempts=3, transport=transport) as client:
        with pytest.raises(piad.ApiError) as refused:
            client.capabilities()
        assert (refused.value.status, refused.value.retry_after, transport.requests) == (503, 0.0, 3)


def test_iterations_of_another_version_come_again(server: Server) -> None:
    with piad.Client(server.url) as client:
        job = client.create(CURVE)
        job.wait()
        text = httpx.get(f"{server.url}/v1/jobs/{job.id}/events?view=errors").text
    cut = text[: text.index("event: iteration\nid: 3\n")]
    again = text.replace("data: {", 'data: {"resumed":"restarted",', 1)
    again = re.sub(r"^id: (\d+)$", r"id: \1@2", again, flags=re.MULTILINE)
    answers = [httpx.Response(200, text=body, headers={"Content-Type": "text/event-stream"}) for body in (cut, again)]
    transport = Flaky()
    with piad.Client(server.url, transport=transport) as client:
        job = client.job(job.id)
        transport._answers.extend(answers)
        numbers = [level.number for level in job.iterations(view="errors")]
    assert numbers == [0, 1, 2, *range(len(numbers) - 3)] and len(numbers) > 6


def test_events_in_pieces() -> None:
    text = b": hello\r\nretry: 1500\r\n\r\nevent: a\nid: 7\ndata: x\ndata: y\n\ndata:z\n\nevent: cut\ndata: off\n"
    for size in (1, 2, 7, len(text)):
        parser = _sse.Parser()
        chunks = [text[i : i + size] for i in range(0, len(text), size)]
        assert [event for chunk in chunks for event in parser.feed(chunk)] == [
            _sse.Retry(1.5),
            _sse.Event("a", "x\ny", "7"),
            _sse.Event("message", "z", ""),
        ]

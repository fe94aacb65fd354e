"""The asynchronous client behaves like the blocking one; cancelled tasks leave nothing open."""

from __future__ import annotations

import asyncio
import inspect
import ssl
import subprocess
import time
import warnings
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from conftest import Server
from shapes import CURVE, FITS, SURFACE
from test_jobs import MANY, SLOW

import piad

ENDLESS = {**SLOW, "max_iterations": 1_000_000}


def with_client(server: Server, work: Callable[[piad.AsyncClient], Awaitable[Any]], **arguments: Any) -> Any:
    async def main() -> Any:
        async with piad.AsyncClient(server.url, **arguments) as client:
            return await asyncio.wait_for(work(client), 60)

    return asyncio.run(main())


def open_streams(server: Server) -> int:
    metrics = httpx.get(f"{server.url}/metrics").text
    return next(int(line.split()[1]) for line in metrics.splitlines() if line.startswith("piad_streams_open "))


async def until_no_stream_is_open(server: Server) -> None:
    started = time.monotonic()
    while await asyncio.to_thread(open_streams, server):
        assert time.monotonic() - started < 5, "a stream is still open"
        await asyncio.sleep(0.01)


def test_both_clients_have_the_same_methods() -> None:
    for blocking, waiting in ((piad.Client, piad.AsyncClient), (piad.Job, piad.AsyncJob)):
        names = [{name for name in dir(it) if not name.startswith("_")} - {"status"} for it in (blocking, waiting)]
        assert names[0] == names[1]
        for name in names[0]:
            one, other = (getattr(it, name) for it in (blocking, waiting))
            if callable(one):
                assert inspect.signature(one).parameters == inspect.signature(other).parameters
                assert one.__doc__ == other.__doc__ and not inspect.iscoroutinefunction(one)


@pytest.mark.parametrize("name", FITS)
def test_results_are_those_of_the_other_client(server: Server, client: piad.Client, name: str) -> None:
    async def work(waiting: piad.AsyncClient) -> tuple[piad.Result, list[piad.Iteration]]:
        job = await waiting.create(**FITS[name])
        levels = [level async for level in job.iterations()]
        assert job.status.ended
        return await job.result(), levels

    result, levels = with_client(server, work)
    expected = client.fit(**FITS[name])
    assert [level.number for level in levels] == list(range(result.iteration + 1))
    for geometry in (result.geometry, levels[-1].geometry):
        assert np.array_equal(geometry.control_points, expected.geometry.control_points)
        assert geometry.knots == expected.geometry.knots


def test_all_methods(server: Server, tmp_path: Path) -> None:
    async def work(client: piad.AsyncClient) -> None:
        assert "version" in await client.capabilities()
        wing = await client.read_points("NACA\n1 0.0013\n0.5 0.04\n0 0\n0.5 -0.03\n")
        result = await client.fit(wing.points, name=wing.name, tolerance=1e-9, timeout=30)
        assert (result.state, result.name) == ("converged", "NACA")
        job = await client.job(result.id)
        assert (await job.refresh()).ended and (await job.wait(5)).ended
        assert (await job.shape()).bases[0].degree == 3
        assert (await job.iteration(1)).number == 1
        assert (await job.samples(9)).points.shape == (9, 2)
        assert (await job.deviation(distances=True)).distances.shape == (4,)
        assert (await job.input())["name"] == "NACA"
        path = await job.download("step", tmp_path / "wing.step")
        assert path.read_bytes().startswith(b"ISO-10303-21")
        edit = await job.edit({1: [0.5, 0.05]}, idempotency_key="once")
        assert (await job.edit({1: [0.5, 0.05]}, idempotency_key="once")).id == edit.id
        assert (await edit.result()).id == edit.id
        listed = [it.id async for it in client.jobs("converged", page=2)]
        assert listed.index(edit.id) < listed.index(job.id)
        endless = await client.create(MANY, **ENDLESS)
        assert (await endless.cancel()).state == "cancelled"
        await edit.delete()
        with pytest.raises(piad.ApiError) as refused:
            await edit.refresh()
        assert refused.value.status == 404

    with_client(server, work)


def test_errors_are_the_same(server: Server) -> None:
    async def work(client: piad.AsyncClient) -> None:
        with pytest.raises(piad.ApiError) as refused:
            await client.create([[0, 0], [1, 1], [1, 1], [2, 0]])
        assert refused.value.problem.pointers == ("/curve/points/2",)
        with pytest.raises(ValueError, match=r"curve.points\[1\]\[0\] is nan"):
            await client.fit([[0.0, 0.0], [float("nan"), 1.0]])
        with pytest.raises(piad.ApiError):
            await client.job("nothing")
        with pytest.raises(piad.ApiError) as wrong:
            [_ async for _ in (await client.create(CURVE)).iterations(every=-1)]
        assert wrong.value.problem.errors[0].parameter == "every"
        with pytest.raises(piad.WaitTimeout):
            await (await client.create(MANY, **ENDLESS)).wait(0.05)
        # The warning refers to the line that requests the fit.
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            await client.fit(MANY, basis="bernstein", max_iterations=2)
        assert [(it.category, it.filename) for it in caught] == [(piad.NotConverged, __file__)]
        # Also in a task of its own, which has no caller.
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            task = asyncio.create_task(client.fit(MANY, basis="bernstein", max_iterations=2))
            line = inspect.currentframe().f_lineno - 1  # type: ignore[union-attr]
            await asyncio.gather(task, asyncio.wait_for(client.fit(MANY, basis="bernstein", max_iterations=3), 30))
        # Either may end first.
        assert sorted((it.filename, it.lineno) for it in caught) == [(__file__, line), (__file__, line + 2)]

    with_client(server, work)
    with pytest.raises(ValueError, match="one attempt"):
        piad.AsyncClient(attempts=0)
    with pytest.raises(ValueError, match="http://localhost"):
        piad.AsyncClient("localhost")


def test_where_nobody_listens_is_known_soon() -> None:
    async def main() -> None:
        async with piad.AsyncClient("http://127.0.0.1:1") as client:
            with pytest.raises(piad.ConnectionLost, match="cannot reach"):
                await client.fit(CURVE)

    started = time.monotonic()
    asyncio.run(main())
    assert time.monotonic() - started < 2


class Flaky(httpx.AsyncBaseTransport):
    """Serves responses from a list first, then real ones; an exception is a connection that breaks after the request
    arrived.
    """

    def __init__(self, *answers: httpx.Response | httpx.TransportError):
        self._real, self._answers = httpx.AsyncHTTPTransport(), list(answers)
        self.requests = 0

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        self.requests += 1
        if not self._answers:
            return await self._real.handle_async_request(request)
        answer = self._answers.pop(0)
        if isinstance(answer, httpx.Response):
            return answer
        await (await self._real.handle_async_request(request)).aread()
        raise answer


def test_lost_answers_make_one_job(server: Server, client: piad.Client) -> None:
    async def work(waiting: piad.AsyncClient) -> None:
        await waiting.create(CURVE)

    before = len(list(client.jobs()))
    lost = Flaky(httpx.ReadError("lost"), httpx.Response(503, headers={"Retry-After": "1"}))
    started = time.monotonic()
    with_client(server, work, transport=lost)
    assert lost.requests == 3 and time.monotonic() - started >= 1
    assert len(list(client.jobs())) == before + 1


@pytest.mark.parametrize("changed", [False, True])
def test_streams_survive_kills(durable_server: Server, changed: bool) -> None:
    """Kills the server twice in mid-stream while another task waits for the job."""

    async def work(client: piad.AsyncClient) -> None:
        job = await client.create(MANY, basis="bernstein", relative_tolerance=1e-15, max_iterations=3000)
        waiting = asyncio.create_task((await client.job(job.id)).wait())
        numbers: list[int] = []
        async for level in job.iterations(changed=changed):
            numbers.append(level.number)
            if level.number in (200, 1000):
                durable_server.kill()
                await asyncio.sleep(0.3)
                await asyncio.to_thread(durable_server.start)
        assert numbers == list(range(3001))
        assert job.status.state == (await waiting).state == "exhausted"

    with_client(durable_server, work)


def test_streams_give_up(durable_server: Server) -> None:
    async def work(client: piad.AsyncClient) -> None:
        job = await client.create(MANY, **ENDLESS)
        levels = job.iterations(view="errors")
        await levels.__anext__()
        durable_server.kill()
        with pytest.raises(piad.ConnectionLost):
            async for _ in levels:
                pass

    with_client(durable_server, work, attempts=2)


async def read(job: piad.AsyncJob, pause: float) -> None:
    async for _ in job.iterations():
        await asyncio.sleep(pause)


async def preview(job: piad.AsyncJob) -> None:
    async for _ in job.preview({3: [3.0, 9.0]}, max_iterations=1_000_000):
        pass


WAITING: dict[str, Callable[[piad.AsyncJob], Any]] = {
    "for an iteration": lambda job: read(job, 0.0),
    "in the body of the loop": lambda job: read(job, 60.0),
    "for a preview": preview,
    "for the end": lambda job: job.wait(),
    "for the result": lambda job: job.result(),
}


@pytest.mark.parametrize("waiting", WAITING)
def test_cancelled_tasks_close_their_connections(server: Server, waiting: str) -> None:
    async def work(client: piad.AsyncClient) -> None:
        job = await client.create(MANY, **ENDLESS)
        await job.iteration(0)
        task = asyncio.create_task(WAITING[waiting](job))
        await asyncio.sleep(0.2)
        assert await asyncio.to_thread(open_streams, server) == 1
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        await until_no_stream_is_open(server)
        # The client still works, and so does the job.
        assert (await job.refresh()).state == "running"
        assert (await job.cancel()).state == "cancelled"

    with_client(server, work)


def test_cancelled_tasks_try_no_longer(durable_server: Server) -> None:
    async def work(client: piad.AsyncClient) -> None:
        await client.capabilities()
        durable_server.kill()
        task = asyncio.create_task(client.fit(CURVE))
        await asyncio.sleep(0.2)
        assert not task.done()
        task.cancel()
        started = time.monotonic()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert time.monotonic() - started < 0.1

    with_client(durable_server, work)


def test_loops_that_are_left_close_their_connections(server: Server) -> None:
    async def work(client: piad.AsyncClient) -> None:
        job = await client.create(MANY, **ENDLESS)
        async for level in job.iterations():
            if level.number == 3:
                break
        await until_no_stream_is_open(server)
        levels = job.iterations()
        await levels.__anext__()
        await levels.aclose()
        await until_no_stream_is_open(server)
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(job.wait(), 0.1)
        await until_no_stream_is_open(server)
        await job.cancel()

    with_client(server, work)


def test_slow_readers_hold_the_server_back(server: Server) -> None:
    """100,000 iterations of 200 points are half a gigabyte; a connection buffers a fraction of it."""
    sent: list[int] = []

    class Counting(httpx.AsyncHTTPTransport):
        async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
            response = await super().handle_async_request(request)
            stream = response.stream
            assert isinstance(stream, httpx.AsyncByteStream)

            async def counted() -> AsyncIterator[bytes]:
                async for chunk in stream:
                    sent.append(len(chunk))
                    yield chunk

            return httpx.Response(response.status_code, headers=response.headers, content=counted())

    async def work(client: piad.AsyncClient) -> None:
        job = await client.create(MANY, basis="bernstein", relative_tolerance=1e-15, max_iterations=100_000)
        levels = job.iterations()
        numbers = [(await levels.__anext__()).number for _ in range(3)]
        read = sum(sent)
        await asyncio.sleep(0.5)
        assert sum(sent) == read < 1_000_000
        numbers += [(await levels.__anext__()).number for _ in range(500)]
        assert numbers == list(range(503))
        await levels.aclose()
        await job.cancel()

    with_client(server, work, transport=Counting())


def test_a_hundred_fits_at_once(server: Server) -> None:
    async def fit(client: piad.AsyncClient, number: int) -> tuple[int, float]:
        points = np.array(CURVE) * (1 + number)
        job = await client.create(points, tolerance=1e-6, name=str(number))
        numbers = [level.number async for level in job.iterations()]
        assert numbers == list(range(len(numbers)))
        result = await job.result()
        assert (result.state, result.name) == ("converged", str(number))
        return number, float(np.abs(result.curve.evaluate(result.curve.domain[1]) - points[-1]).max())

    async def work(client: piad.AsyncClient) -> None:
        done = await asyncio.gather(*(fit(client, number) for number in range(100)))
        assert [number for number, _ in done] == list(range(100))
        assert max(distance for _, distance in done) < 2e-6
        results = await asyncio.gather(*(client.fit(SURFACE, name=str(number)) for number in range(100)))
        assert [result.name for result in results] == [str(number) for number in range(100)]
        await until_no_stream_is_open(server)

    with_client(server, work)


def test_more_streams_than_a_pool_of_httpx_holds(server: Server) -> None:
    async def work(client: piad.AsyncClient) -> None:
        job = await client.create(MANY, **ENDLESS)
        streams = [job.iterations(view="errors") for _ in range(120)]
        assert [(await levels.__anext__()).number for levels in streams] == [0] * 120
        await asyncio.gather(*(levels.aclose() for levels in streams))
        await until_no_stream_is_open(server)
        await job.cancel()

    with_client(server, work)


def test_sockets_and_certificates(tmp_path: Path) -> None:
    key, certificate, socket = (tmp_path / name for name in ("key.pem", "certificate.pem", "piad.sock"))
    command = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    names = ["-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1"]
    subprocess.run([*command, *names, "-keyout", key, "-out", certificate], check=True, capture_output=True)
    context = ssl.create_default_context(cafile=str(certificate))

    async def fit(url: str, transport: httpx.AsyncBaseTransport, **arguments: Any) -> str:
        async with piad.AsyncClient(url, transport=transport, **arguments) as client:
            job = await client.create(CURVE)
            assert [level.number async for level in job.iterations()][0] == 0
            return job.status.state

    token = f"piad_{'0123456789abcdef' * 4}"
    secured = Server(":memory:", "--tls-cert", str(certificate), "--tls-key", str(key), token=token)
    try:
        url = f"https://{secured.address}"
        assert asyncio.run(fit(url, httpx.AsyncHTTPTransport(verify=context), token=token)) == "converged"
        with pytest.raises(piad.ApiError) as refused:
            asyncio.run(fit(url, httpx.AsyncHTTPTransport(verify=context)))
        assert refused.value.problem.type == "/problems/unauthenticated"
    finally:
        secured.kill()
    local = Server(":memory:", "--listen", f"unix:{socket}")
    try:
        assert asyncio.run(fit("http://localhost", httpx.AsyncHTTPTransport(uds=str(socket)))) == "converged"
    finally:
        local.kill()


def test_the_other_client_works_inside_of_an_event_loop(server: Server) -> None:
    """As in notebooks: it blocks the event loop and needs none."""

    async def main() -> None:
        with piad.Client(server.url) as client:
            job = client.create(CURVE)
            first = next(iter(job.iterations()))
            assert first.number == 0 and job.result().state == "converged"

    asyncio.run(main())

"""Errors of the client: no server, invalid URLs, numbers that are not finite."""

from __future__ import annotations

import math
import re
import socket
import time
from types import ModuleType
from typing import Any

import httpx
import numpy as np
import pytest
from conftest import Server
from shapes import CURVE, SURFACE

import piad


def free_port() -> int:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        port: int = taken.getsockname()[1]
        return port


def test_where_nobody_listens() -> None:
    url = f"http://127.0.0.1:{free_port()}"
    started = time.monotonic()
    with piad.Client(url) as client, pytest.raises(piad.ConnectionLost, match=f"cannot reach {url}.*refused"):
        client.fit(CURVE)
    assert time.monotonic() - started < 2


def test_where_nobody_answers() -> None:
    """A host that neither accepts nor refuses connections."""
    with socket.create_server(("127.0.0.1", 0), backlog=0) as silent:
        address = silent.getsockname()
        # These fill the queue of connections.
        queue = [socket.socket() for _ in range(4)]
        for waiting in queue:
            waiting.setblocking(False)
            waiting.connect_ex(address)
        url = f"http://127.0.0.1:{address[1]}"
        started = time.monotonic()
        with piad.Client(url) as client, pytest.raises(piad.ConnectionLost, match=f"cannot reach {url}"):
            client.capabilities()
        assert time.monotonic() - started < 2
        for waiting in queue:
            waiting.close()


def test_servers_that_come_late(durable_server: Server) -> None:
    """A server that has responded before may be restarting: the client waits for it."""
    with piad.Client(durable_server.url) as client:
        client.capabilities()
        durable_server.kill()
        with pytest.raises(piad.ConnectionLost, match=durable_server.url):
            with piad.Client(durable_server.url) as stranger:
                stranger.capabilities()
        durable_server.start()
        client.capabilities()


@pytest.mark.parametrize(
    ("url", "hint"),
    [
        ("127.0.0.1:8080", '"http://127.0.0.1:8080"?'),
        ("localhost:8080", '"http://localhost:8080"?'),
        ("localhost", '"http://localhost"?'),
        ("ftp://localhost:8080", '"http://localhost:8080"?'),
        ("", "http://"),
        ("http://", "no such host"),
        ("http://localhost:99999999", "no such port"),
    ],
)
def test_wrong_addresses_are_told_at_once(url: str, hint: str) -> None:
    with pytest.raises(ValueError) as refused:
        piad.Client(url)
    assert repr(url) in str(refused.value) and hint in str(refused.value)


def test_broken_headers_are_not_sent_again(server: Server) -> None:
    started = time.monotonic()
    with piad.Client(server.url, headers={"X-Key": "a\nb"}) as client, pytest.raises(piad.ConnectionLost) as broken:
        client.capabilities()
    assert isinstance(broken.value.__cause__, httpx.LocalProtocolError)
    assert time.monotonic() - started < 1


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_named(client: piad.Client, number: float) -> None:
    def refused(expected: str, points: Any, **arguments: Any) -> None:
        with pytest.raises(ValueError) as error:
            client.create(points, **arguments)
        assert str(error.value) == f"{expected} is {number}: numbers must be finite"

    curve, surface = np.array(CURVE), np.array(SURFACE)
    curve[3, 1] = surface[2, 1, 2] = number
    refused("curve.points[3][1]", curve)
    refused("curve.points[3][1]", curve.astype("f4"))
    refused("curve.points[3][1]", curve.tolist())
    refused("curve.points[3][1]", [tuple(point) for point in curve])
    refused("surface.points[2][1][2]", surface)
    weights = np.ones(len(CURVE))
    weights[2] = number
    refused("curve.weights[2]", CURVE, weights=weights)
    refused("curve.parameters[2]", CURVE, parameters=weights)
    along = {"u": np.ones(len(SURFACE)), "v": np.full(len(SURFACE[0]), number)}
    refused("surface.weights.v[0]", SURFACE, weights=along, rational="fixed")
    refused("method.indices[0]", CURVE, method={"kind": "local", "indices": [number]})
    refused("stop.tolerance", CURVE, tolerance=number)
    job = client.create(CURVE)
    with pytest.raises(ValueError, match=r"^points\[0\]\.point\[2\] is "):
        job.edit({1: [0.0, 1.0, number]})


def test_calls_that_are_wrong_name_what_was_called(client: piad.Client) -> None:
    unasked: Any = {"degre": 3}
    job = client.create(CURVE)
    for call, name in (
        (lambda: client.fit(CURVE, **unasked), "Client.fit"),
        (lambda: client.create(CURVE, **unasked), "Client.create"),
        (lambda: job.wait(**unasked), "Job.wait"),
        (lambda: job.preview(**unasked), "Job.preview"),
        (lambda: job.edit(**unasked), "Job.edit"),
    ):
        with pytest.raises(TypeError, match=re.escape(f"{name}() got an unexpected keyword argument 'degre'")):
            call()
    asynchronous: Any = piad.AsyncClient.fit
    with pytest.raises(TypeError, match=r"AsyncClient\.fit\(\) missing 1 required positional argument: 'points'"):
        asynchronous(object())


def test_control_points_beside_a_method_are_those_of_least_squares(client: piad.Client) -> None:
    points = [[i, (i % 20) ** 2] for i in range(60)]
    assert len(client.fit(points, control_points=9).curve.control_points) == 9
    fitted = client.fit(points, control_points="auto", tolerance=20)
    expected = client.fit(points, method={"kind": "least_squares", "control_points": "auto"}, tolerance=20)
    assert len(fitted.curve.control_points) == len(expected.curve.control_points) < 60
    surface = client.fit(SURFACE, control_points={"u": 4, "v": 4}, degree=2).surface
    assert surface.control_points.shape[:2] == (4, 4)
    with pytest.raises(ValueError, match="given twice"):
        client.fit(points, control_points=9, method={"kind": "least_squares", "control_points": 8})


def test_what_is_printed_is_short(client: piad.Client) -> None:
    points = [[i, (i % 20) ** 2] for i in range(400)]
    job = client.create(points)
    result, iteration = job.result(), job.iteration()
    surface = client.fit([[[i, j, i * j % 7] for j in range(30)] for i in range(30)], max_iterations=1000).surface
    wing = client.read_points("NACA 2412\n1 0.0013\n0.5 0.0724\n0 0\n0.5 -0.0334\n1 -0.0013\n")
    things = [job, result, iteration, iteration.shape, job.samples(500), job.deviation(distances=True), job.curvature(), job.status]
    things += [result.curve, result.curve.basis, surface, surface.boundary("u_end"), wing]
    for thing in things:
        assert repr(thing).startswith("<piad.") and len(repr(thing)) < 120, repr(thing)
    assert repr(result.curve) == "<piad.Curve of degree 3, control points 402 × 2>"
    assert repr(wing) == "<piad.FilePoints 'NACA 2412': 5 × 2>"


def test_names_of_others_are_not_in_the_package() -> None:
    public = {name for name in vars(piad) if not name.startswith("_")}
    modules = {name for name in public if isinstance(getattr(piad, name), ModuleType)}
    assert public - modules <= set(piad.__all__), public - modules

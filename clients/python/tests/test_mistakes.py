"""What goes wrong on this side: no server, wrong addresses, numbers that JSON does not have."""

from __future__ import annotations

import math
import socket
import time
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
    """A machine that takes no connection and refuses none."""
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
    """One that has answered may be starting again: it is waited for."""
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

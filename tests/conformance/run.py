"""Checks that all clients do the same with the same server and get the same numbers.

    run.py PROGRAM [CLIENT …]       # PROGRAM is target/debug/piad; default: all clients

A client is a program, `CLIENT SCENARIO URL TOKEN`: it reads a request from standard input, runs the
scenario of README.md through its library, and prints the result as JSON. The expected output is
requested here over plain HTTP. The resulting table is in docs/reference/clients.md.
"""

import base64
import json
import math
import os
import re
import struct
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable
from typing import Any

from packed import moved

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.normpath(os.path.join(HERE, "..", ".."))
TOKEN = "piad_" + "0123456789abcdef" * 4
TIMEOUT = 120

Json = dict[str, Any]


def node() -> str:
    """The Node of the TypeScript tests, if it is installed there."""
    own = os.path.join(ROOT, "target/node/node_modules/node/bin/node")
    return own if os.path.exists(own) else "node"


CLIENTS: dict[str, list[str]] = {
    "Python": [sys.executable, os.path.join(HERE, "python.py")],
    "Python, async": [sys.executable, os.path.join(HERE, "async_python.py")],
    "TypeScript": [node(), os.path.join(ROOT, "clients/typescript/build/conformance.js")],
    "C#": ["mono", os.path.join(ROOT, "target/csharp/conformance.exe")],
    "C++": [os.path.join(ROOT, "target/cpp/build/piad_conformance")],
    "gRPC": [sys.executable, os.path.join(HERE, "plain_grpc.py")],
}


class Server:
    """A server that can be killed and restarted with the same data at the same address."""

    def __init__(self, program: str, store: str) -> None:
        self.program, self.store, self.address = program, store, "127.0.0.1:0"
        self.start()

    def start(self) -> None:
        command = [self.program, "--listen", self.address, "--store", self.store, "--log-format", "json", "--max-iterations", "1000000000"]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env={**os.environ, "PIAD_TOKEN": TOKEN})
        assert self.process.stderr is not None
        for line in self.process.stderr:
            if found := re.search(r"listening on http://([^\s\"]+)", line):
                self.address = found[1]
                # A full pipe would block the server.
                threading.Thread(target=self.process.stderr.read, daemon=True).start()
                return
        raise SystemExit(f"{self.program} has not started")

    @property
    def url(self) -> str:
        return f"http://{self.address}"

    def kill(self) -> None:
        """Sends SIGKILL: connections are not closed cleanly."""
        self.process.kill()
        self.process.wait()

    def ask(self, path: str, body: Json | None = None) -> Json:
        content = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json", "Prefer": "wait=60", "Authorization": f"Bearer {TOKEN}"}
        request = urllib.request.Request(self.url + path, content, headers)
        try:
            with urllib.request.urlopen(request, timeout=TIMEOUT) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as refusal:
            return json.load(refusal)


def wave(count: int) -> list[list[int]]:
    """Integer points, which all parsers read exactly: Mono sometimes errs in the last bit of
    others."""
    angles = [2 * math.pi * i / count for i in range(count)]
    polar = [(2e6 + 3e5 * math.sin(5 * a), a) for a in angles]
    return [[round(r * math.cos(a)), round(r * math.sin(a))] for r, a in polar]


def curve(count: int, **stop: float) -> Json:
    return {"curve": {"points": wave(count)}, "stop": stop}


def flat(value: Any) -> list[float]:
    return [number for part in value for number in flat(part)] if isinstance(value, list) else [value]


def result(server: Server, job: Json) -> Json:
    """The output of a client for the result of a job."""
    found = server.ask(f"/v1/jobs/{job['id']}/result")
    knots = found.get("knots")
    return {
        "state": found["state"],
        "iteration": found["iteration"],
        "error": found["error"]["max"],
        "control_points": flat(found["control_points"]),
        "knots": knots["u"] if isinstance(knots, dict) else knots,
    }


def levels(server: Server, job: Json) -> Json:
    """The output of a client for the stream of a job."""
    last = server.ask(f"/v1/jobs/{job['id']}")
    path = f"/v1/jobs/{job['id']}/iterations"
    points = [flat(server.ask(f"{path}/{k}")["control_points"]) for k in (0, last["iteration"])]
    numbers = list(range(last["iteration"] + 1))
    return {"numbers": numbers, "first": points[0], "last": points[1], "state": last["state"]}


def differences_of(server: Server, job: Json) -> Json:
    """The output of a client for a stream of differences."""
    request = urllib.request.Request(
        f"{server.url}/v1/jobs/{job['id']}/events?encoding=delta",
        headers={"Accept": "application/x-ndjson", "Authorization": f"Bearer {TOKEN}"},
    )
    points: list[list[float]] = []
    with urllib.request.urlopen(request, timeout=TIMEOUT) as stream:
        events = [json.loads(line) for line in stream]
    levels = [event["data"] for event in events if event["event"] == "iteration"]
    for level in levels:
        numbers = base64.b64decode(level["control_points"])
        if level["encoding"] == "delta":
            points.append(moved(points[-1], level["step"], numbers, level["shape"][-1]))
        else:
            points.append([x for (x,) in struct.iter_unpack("<d" if level["encoding"] == "base64" else "<f", numbers)])
    assert sum(level["encoding"] == "delta" for level in levels) > len(levels) // 2
    return {"numbers": [level["iteration"] for level in levels], "points": points, "state": events[-1]["data"]["state"]}


class Run:
    """A client in a scenario."""

    def __init__(self, client: str, scenario: str, server: Server, request: Json) -> None:
        command = [*CLIENTS[client], scenario, server.url, TOKEN]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(json.dumps(request))
        self.process.stdin.close()

    def line(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().strip()

    def answer(self) -> Json:
        timer = threading.Timer(TIMEOUT, self.process.kill)
        timer.start()
        said = self.line()
        assert self.process.wait() == 0, f"it has ended with {self.process.returncode}: {said}"
        timer.cancel()
        return json.loads(said)


def compare(found: Json, expected: Json) -> None:
    """Numbers are equal to the bit: nothing is computed in between."""
    for name, value in expected.items():
        assert name in found, f"{name} is missing: {list(found)}"
        assert found[name] == value, f"{name}: {str(found[name])[:200]} instead of {str(value)[:200]}"


def fit(server: Server, client: str) -> None:
    rows = [[[x, y, x * y] for y in range(4)] for x in range(5)]
    surface = {"surface": {"points": rows}, "stop": {"max_iterations": 7}}
    for request in (curve(30, relative_tolerance=1e-9), surface):
        expected = result(server, server.ask("/v1/jobs", request))
        compare(Run(client, "fit", server, request).answer(), expected)


def watch(server: Server, client: str) -> None:
    request = curve(40, relative_tolerance=1e-9)
    expected = levels(server, server.ask("/v1/jobs", request))
    compare(Run(client, "watch", server, request).answer(), expected)


def resume(server: Server, client: str) -> None:
    request = curve(5000, tolerance=0, max_iterations=300)
    expected = levels(server, server.ask("/v1/jobs", request))
    run = Run(client, "resume", server, request)
    assert run.line() == "ready"
    server.kill()
    time.sleep(0.5)
    server.start()
    compare(run.answer(), expected)


def cancel(server: Server, client: str) -> None:
    request = curve(100, tolerance=0, max_iterations=1_000_000_000)
    expected = {"state": "cancelled", "again": "cancelled"}
    compare(Run(client, "cancel", server, request).answer(), expected)


def edit(server: Server, client: str) -> None:
    job, change = curve(30, relative_tolerance=1e-9), {"points": [{"index": 3, "point": [1_500_000, 1_250_000]}]}
    parent = server.ask("/v1/jobs", job)
    expected = result(server, server.ask(f"/v1/jobs/{parent['id']}/edits", change))
    found = Run(client, "edit", server, {"job": job, "edit": change}).answer()
    assert server.ask(f"/v1/jobs/{found['parent']}")["state"] == "converged"
    compare(found, {**expected, "is_parent": True})


def errors(server: Server, client: str) -> None:
    request: Json = {"curve": {"points": [[0, 0], [1, 1], [1, 1], [2, 0]]}}
    problem = server.ask("/v1/jobs", request)
    expected: Json = {
        "status": problem["status"],
        "type": problem["type"],
        "pointers": [error["pointer"] for error in problem["errors"]],
        "detail": problem["detail"],
    }
    assert expected["pointers"] == ["/curve/points/2"]
    if client == "gRPC":
        # Its errors have locations in the message: the coordinates of all points are in one list.
        expected = {"type": problem["type"], "fields": ["input.curve.points[4]"]}
    compare(Run(client, "errors", server, request).answer(), expected)


def tokens(server: Server, client: str) -> None:
    request = curve(20, relative_tolerance=1e-6)
    expected = {"without": "/problems/unauthenticated", "with": "converged"}
    compare(Run(client, "tokens", server, request).answer(), expected)


def large(server: Server, client: str) -> None:
    request = curve(20_000, tolerance=0, max_iterations=20)
    job = server.ask("/v1/jobs", request)
    last = levels(server, job)["last"]
    found = Run(client, "large", server, request).answer()
    compare(found, {"numbers": list(range(21)), "count": len(last)})
    # Summed in any order.
    assert math.isclose(found["sum"], math.fsum(last), rel_tol=1e-9, abs_tol=1e-2), found["sum"]


def differences(server: Server, client: str) -> None:
    rows = [[[1000 * x, 1000 * y, (x - 7) ** 2 * (y - 9) ** 2 - 90 * x * y] for y in range(20)] for x in range(15)]
    surface = {"surface": {"points": rows}, "stop": {"tolerance": 0, "max_iterations": 9}}
    for request in (curve(600, tolerance=0, max_iterations=12), surface):
        job = server.ask("/v1/jobs", request)
        expected = differences_of(server, job)
        found = Run(client, "differences", server, request).answer()
        if client != "gRPC":
            compare(found, expected)
        # First messages have 64-bit numbers, so later ones differ.
        compare(found, {"numbers": expected["numbers"], "state": expected["state"]})
        for k, points in enumerate(found["points"]):
            level = server.ask(f"/v1/jobs/{job['id']}/iterations/{k}")
            far = max(abs(x - y) for x, y in zip(points, flat(level["control_points"]), strict=True))
            near = level["error"]["max"] / 128 + 1e-9
            assert far <= (near if k < len(found["points"]) - 1 else 0), f"iteration {k}: {far}"


def slow(server: Server, client: str) -> None:
    request = curve(2000, tolerance=0, max_iterations=150)
    compare(Run(client, "slow", server, request).answer(), {"numbers": list(range(151)), "state": "exhausted"})


SCENARIOS: list[Callable[[Server, str], None]] = [fit, watch, resume, cancel, edit, errors, tokens, large, differences, slow]


def outcome(scenario: Callable[[Server, str], None], server: Server, client: str) -> str:
    try:
        scenario(server, client)
    except (AssertionError, OSError, ValueError, KeyError) as error:
        print(f"{client}, {scenario.__name__}: {type(error).__name__}: {error}", file=sys.stderr)
        return "no"
    return "yes"


def main(program: str, *names: str) -> int:
    clients = list(names) or list(CLIENTS)
    titles = [scenario.__name__ for scenario in SCENARIOS]
    print(f"| client | {' | '.join(titles)} |\n|---|{'---|' * len(titles)}")
    failed = False
    with tempfile.TemporaryDirectory() as store:
        server = Server(program, store)
        try:
            for client in clients:
                row = [outcome(scenario, server, client) for scenario in SCENARIOS]
                failed |= "no" in row
                print(f"| {client} | {' | '.join(row)} |", flush=True)
        finally:
            server.kill()
    return int(failed)


if __name__ == "__main__":
    raise SystemExit(main(*sys.argv[1:]))

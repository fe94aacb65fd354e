"""Measures the effect of one tenant on another: the time of a small fit, alone and while the other
has a long queue.

    tenants.py PROGRAM [--jobs N] [--points N] [--rounds N]      # PROGRAM is target/release/piad
"""

import argparse
import contextlib
import http.client
import json
import math
import os
import re
import statistics
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator

SMALL = 100
WARM = 50


def curve(points: int, **stop: float) -> bytes:
    data = [[math.cos(0.06 * i), math.sin(0.06 * i), 0.01 * i] for i in range(points)]
    return json.dumps({"curve": {"points": data}, "stop": stop}).encode()


def token(program: str, file: str, tenant: str) -> str:
    command = [program, "token", "create", "--tokens", file, "--tenant", tenant]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


@contextlib.contextmanager
def started(program: str, folder: str, tokens: str) -> Iterator[str]:
    """The address of a server that requires tokens."""
    command = [program, "--listen", "127.0.0.1:0", "--store", folder, "--tokens", tokens]
    server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert server.stderr is not None
    address = next(found[1] for line in server.stderr if (found := re.search(r"listening on http://(\S+)", line)))
    # A full pipe would block the server.
    threading.Thread(target=server.stderr.read, daemon=True).start()
    try:
        yield address
    finally:
        server.terminate()
        server.wait()


class Client:
    """A connection of a tenant."""

    def __init__(self, address: str, token: str) -> None:
        self.connection = http.client.HTTPConnection(address)
        self.headers = {"Content-Type": "application/json", "Authorization": f"Bearer {token}"}

    def post(self, path: str, body: bytes) -> int:
        self.connection.request("POST", path, body, self.headers)
        answer = self.connection.getresponse()
        answer.read()
        return answer.status

    def queued(self) -> int:
        self.connection.request("GET", "/v1/jobs?state=queued&limit=1000", headers=self.headers)
        return len(json.load(self.connection.getresponse())["jobs"])


def times(client: Client, rounds: int) -> list[float]:
    body, seconds = curve(SMALL, relative_tolerance=1e-6), []
    for round_ in range(rounds + WARM):
        begin = time.perf_counter()
        status = client.post("/v1/fit", body)
        assert status == 200, status
        if round_ >= WARM:
            seconds.append(time.perf_counter() - begin)
    return seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--jobs", type=int, default=1000)
    parser.add_argument("--points", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=500)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "tokens.toml")
        tokens = [token(arguments.program, file, tenant) for tenant in ("large", "small")]
        with started(arguments.program, folder, file) as address:
            measure(Client(address, tokens[0]), Client(address, tokens[1]), arguments)


def measure(large: Client, small: Client, arguments: argparse.Namespace) -> None:
    rows = {"alone": times(small, arguments.rounds)}
    # Each runs for seconds: the queue is as long at the end.
    body = curve(arguments.points, tolerance=0, max_iterations=10_000)
    for _ in range(arguments.jobs):
        assert large.post("/v1/jobs", body) == 201
    before = large.queued()
    rows[f"beside {before} jobs of {arguments.points} points"] = times(small, arguments.rounds)
    print(f"{before} jobs of the other tenant were queued before, {large.queued()} after.\n")
    print(f"| a fit of {SMALL} points | p50 | p99 |\n|---|---|---|")
    for name, seconds in rows.items():
        cuts = statistics.quantiles(seconds, n=100)
        print(f"| {name} | {1e3 * cuts[49]:.2f} ms | {1e3 * cuts[98]:.2f} ms |")


if __name__ == "__main__":
    main()

"""Measures the effect of one client on others: a small job and a probe, alone and beside loads from
another address.

    neighbours.py PROGRAM        # PROGRAM is target/release/piad

The small job has four points and comes from 127.0.0.2; the load comes from 127.0.0.1. Medians and the largest of
twenty each, in milliseconds: from the request to the end of the job, and from GET /livez to its
response.
"""

import argparse
import contextlib
import http.client
import json
import math
import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "python"))
from over_http import server

ROUNDS = 20
SMALL = json.dumps({"curve": {"points": [[0, 0], [1, 2], [2, 0], [3, 1]]}}).encode()


def spiral(count: int) -> list:
    return [[i / 40 * math.cos(i / 40), i / 40 * math.sin(i / 40)] for i in range(count)]


ENDLESS = {"tolerance": 0, "max_iterations": 1_000_000}
TRANSPOSE = {"curve": {"points": spiral(400)}, "method": {"kind": "transpose"}, "stop": ENDLESS}
LARGE = {"curve": {"points": spiral(1_000_000)}, "method": {"kind": "weighted", "omega": 0.01}, "stop": ENDLESS}
DENSE = {"curve": {"points": spiral(700), "basis": {"kind": "bspline", "degree": 233}}, "stop": {"max_iterations": 2}}
LOADS = {
    "alone": (0, {}),
    "a curve of 1e6 points": (1, LARGE),
    "8 dense set-ups": (8, DENSE),
    "64 jobs of 400 points": (64, TRANSPOSE),
    "256 jobs of 400 points": (256, TRANSPOSE),
    "5000 jobs of 400 points": (5000, TRANSPOSE),
}


def ask(address: tuple[str, int], source: str, method: str, path: str, body: bytes | None = None) -> tuple[float, bytes]:
    connection = http.client.HTTPConnection(*address, source_address=(source, 0))
    begin = time.perf_counter()
    connection.request(method, path, body, {"Content-Type": "application/json", "Prefer": "wait=60"})
    text = connection.getresponse().read()
    seconds = time.perf_counter() - begin
    connection.close()
    return seconds, text


def post(address: tuple[str, int], count: int, job: dict) -> None:
    """Posts the load, without waiting for its end."""
    body = json.dumps(job).encode()
    for _ in range(count):
        connection = http.client.HTTPConnection(*address, source_address=("127.0.0.1", 0))
        connection.request("POST", "/v1/jobs", body, {"Content-Type": "application/json"})
        with contextlib.suppress(OSError):
            connection.getresponse().read()
        connection.close()


def summary(seconds: list[float]) -> str:
    return f"{1000 * statistics.median(seconds):8.2f} {1000 * max(seconds):9.2f}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    program = parser.parse_args().program
    print(f"{'beside':26} {'small job':>18} {'GET /livez':>18}\n{'':26} {'median':>8} {'largest':>9} {'median':>8} {'largest':>9}")
    for name, (count, job) in LOADS.items():
        # Separate servers, so that loads do not add up.
        with server(program) as base:
            host, port = base.removeprefix("http://").split(":")
            address = (host, int(port))
            post(address, count, job)
            jobs, probes = [], []
            for _ in range(ROUNDS):
                seconds, text = ask(address, "127.0.0.2", "POST", "/v1/jobs", SMALL)
                assert json.loads(text)["state"] == "converged", text
                jobs.append(seconds)
                probes.append(ask(address, "127.0.0.2", "GET", "/livez")[0])
            print(f"{name:26} {summary(jobs)} {summary(probes)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

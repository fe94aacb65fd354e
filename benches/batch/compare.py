"""Many small curves: compares a batch with single requests and scipy, and measures memory and the
effect on other clients.

    compare.py PROGRAM [--items N] [--many N] [--rounds N] [--only rates memory neighbour gone]

PROGRAM is target/release/piad. Curves have 50 points in the plane and different shapes. *Rates* are
curves per second, from the first byte of a request to the last one of its response, with prepared
and unparsed bodies: `POST /v1/batch` in one request; `POST /v1/fit` one after another over 16
connections by wrk; scipy's cubic splines from points to control points, in a loop of one process
and of two at the same time. Medians of interleaved rounds. *Memory* is the peak of a server that
responds while a batch arrives. *Neighbour* is the time of a fit of 100 points from another address.
*Gone* is how long a server computes after the client of a batch has disconnected. Needs wrk, and
the packages of ../requirements.txt.
"""

import argparse
import http.client
import itertools
import json
import math
import multiprocessing
import os
import re
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator

import numpy as np
from scipy.interpolate import make_interp_spline, make_lsq_spline

POINTS = 50
METHODS = {
    "global": {"stop": {"relative_tolerance": 1e-6}},
    "direct": {"method": {"kind": "direct"}},
    "least squares": {"method": {"kind": "least_squares", "variant": "direct", "control_points": 20}},
}
CONNECTIONS = 16
SLICE = 0.02
# Seconds of wrk.
SINGLES = 3


def curve(k: int) -> np.ndarray:
    t = np.linspace(0, 1, POINTS)
    y = (1 + k % 7 / 3) * np.sin((4 + 2 * (k % 5)) * t + k)
    return np.stack([8 * t, y], axis=1).round(6)


# Shapes are serialized once: only the server is measured.
SHAPES = [json.dumps({"curve": {"points": curve(k).tolist()}}) for k in range(1000)]


def body(count: int, method: str) -> Iterator[bytes]:
    """A batch in chunks of 1000 items."""
    yield f'{{"defaults": {json.dumps(METHODS[method])}, "items": ['.encode()
    for start in range(0, count, len(SHAPES)):
        part = ", ".join(SHAPES[: count - start])
        yield (part if start == 0 else f", {part}").encode()
    yield b"]}"


class Server:
    """A server on a free port."""

    def __init__(self, program: str):
        command = [program, "--listen", "127.0.0.1:0", "--store", ":memory:", "--log", "info"]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        lines = (re.search(r"listening on http://([\d.]+):(\d+)", line) for line in self.process.stderr)
        found = next(line for line in lines if line)
        self.address = (found[1], int(found[2]))
        # A full pipe would block the server.
        threading.Thread(target=self.process.stderr.read, daemon=True).start()

    def __enter__(self) -> "Server":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait()

    def peak(self) -> int:
        """The largest resident size so far."""
        with open(f"/proc/{self.process.pid}/status") as status:
            return int(re.search(r"VmHWM:\s+(\d+)", status.read())[1]) * 1024

    def busy(self) -> float:
        """CPU seconds so far."""
        with open(f"/proc/{self.process.pid}/stat") as stat:
            fields = stat.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def send(server: Server, pieces: list[bytes]) -> tuple[socket.socket, threading.Thread]:
    """Posts a batch from a thread of its own."""
    connection = socket.create_connection(server.address)
    head = f"POST /v1/batch HTTP/1.0\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {sum(map(len, pieces))}\r\n\r\n"

    def write() -> None:
        try:
            connection.sendall(head.encode())
            for piece in pieces:
                connection.sendall(piece)
        except OSError:  # It was closed.
            return

    thread = threading.Thread(target=write, daemon=True)
    thread.start()
    return connection, thread


def batch(server: Server, pieces: list[bytes], count: int) -> tuple[float, int]:
    """Seconds of a whole batch, and the size of its response, of which only the end is kept."""
    begin = time.perf_counter()
    connection, thread = send(server, pieces)
    end, size = b"", 0
    while received := connection.recv(1 << 18):
        end, size = (end + received)[-400:], size + len(received)
    seconds = time.perf_counter() - begin
    thread.join()
    connection.close()
    totals = json.loads(end.splitlines()[-1])["totals"]
    assert totals["converged"] == count, totals
    return seconds, size


def singles(server: Server, method: str, seconds: int) -> float:
    """Requests per second of wrk, which posts the shapes in turn."""
    jobs = [json.dumps(json.loads(shape) | METHODS[method]) for shape in SHAPES[:100]]
    with tempfile.NamedTemporaryFile("w", suffix=".lua") as script:
        script.write('wrk.method = "POST"\nwrk.path = "/v1/fit"\nwrk.headers["Content-Type"] = "application/json"\n')
        script.write("bodies = {" + ", ".join(f"[==[{job}]==]" for job in jobs) + "}\nat = 0\n")
        script.write("request = function() at = at % #bodies + 1 return wrk.format(nil, nil, nil, bodies[at]) end\n")
        script.flush()
        url = "http://{}:{}/v1/fit".format(*server.address)
        command = ["wrk", "-t1", f"-c{CONNECTIONS}", f"-d{seconds}s", "--timeout", "30s", "-s", script.name, url]
        output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "Non-2xx" not in output, output
    return float(re.search(r"Requests/sec:\s+([\d.]+)", output)[1])


def splines(method: str, curves: list[np.ndarray]) -> None:
    """The same with scipy: chord length, not-a-knot, or 20 control points."""
    for points in curves:
        parameters = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        if method == "least squares":
            inner = np.quantile(parameters, np.linspace(0, 1, 18)[1:-1])
            make_lsq_spline(parameters, points, np.r_[(parameters[0],) * 4, inner, (parameters[-1],) * 4], k=3)
        else:
            make_interp_spline(parameters, points, k=3)


def scipy(method: str, processes: int, count: int = 4000) -> float:
    curves = [curve(k) for k in range(count)]
    begin = time.perf_counter()
    others = [multiprocessing.Process(target=splines, args=(method, curves)) for _ in range(processes - 1)]
    for process in others:
        process.start()
    splines(method, curves)
    for process in others:
        process.join()
    return processes * count / (time.perf_counter() - begin)


def spent(server: Server, action) -> tuple[float, float]:
    """Curves per second, returned by an action, and the CPU seconds of the server meanwhile."""
    before = server.busy()
    return action(), server.busy() - before


def rates(program: str, items: int, rounds: int) -> None:
    print(f"curves of {POINTS} points per second, {items} in a batch, medians of {rounds} and the least and the largest;")
    print("processor time of the server for each, in microseconds\n")
    print("| method | batch | /v1/fit, 16 connections | scipy, one process | two | batch : /v1/fit : scipy, two | batch, µs | /v1/fit, µs |")
    print("|---|---|---|---|---|---|---|---|")
    for method in METHODS:
        pieces = list(body(items, method))
        found: list[list[float]] = [[], [], [], []]
        times: list[list[float]] = [[], []]
        with Server(program) as server:
            batch(server, pieces, items)
            for _ in range(rounds):
                rate, seconds = spent(server, lambda: items / batch(server, pieces, items)[0])
                found[0].append(rate)
                times[0].append(1e6 * seconds / items)
                rate, seconds = spent(server, lambda: singles(server, method, SINGLES))
                found[1].append(rate)
                times[1].append(1e6 * seconds / (rate * SINGLES))
                found[2].append(scipy(method, 1))
                found[3].append(scipy(method, 2))
        cells = [f"{statistics.median(each):,.0f} ({min(each):,.0f}–{max(each):,.0f})" for each in found]
        ofs = [statistics.median(each) for each in found]
        cells.append(f"{ofs[0] / ofs[1]:.1f} : 1 : {ofs[3] / ofs[1]:.1f}")
        cells += [f"{statistics.median(each):.0f}" for each in times]
        print(f"| {method} | {' | '.join(cells)} |", flush=True)


def memory(program: str, many: int) -> None:
    print("\npeak resident memory of a server\n\n| | MiB | request, MiB | answer, MiB | s |\n|---|---|---|---|---|")
    for count in (0, 1000, many // 10, many):
        with Server(program) as server:
            pieces = list(body(count, "global"))
            seconds, size = batch(server, pieces, count) if count else (0.0, 0)
            sent = sum(map(len, pieces)) / 2**20
            print(f"| {count:,} curves | {server.peak() / 2**20:.0f} | {sent:.1f} | {size / 2**20:.1f} | {seconds:.1f} |", flush=True)


def fits(server: Server, until: threading.Event | None, most: int) -> list[float]:
    """Seconds of fits of 100 points from another address, one after another, 20 ms apart."""
    data = [[math.cos(0.06 * i), math.sin(0.06 * i), 0.01 * i] for i in range(100)]
    job = json.dumps({"curve": {"points": data}, "stop": {"relative_tolerance": 1e-6}}).encode()
    connection = http.client.HTTPConnection(*server.address, source_address=("127.0.0.2", 0))
    seconds = []
    for _ in itertools.repeat(None, most):
        begin = time.perf_counter()
        connection.request("POST", "/v1/fit", job, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        answer.read()
        assert answer.status == 200, answer.status
        seconds.append(time.perf_counter() - begin)
        if until is not None and until.is_set():
            break
        time.sleep(SLICE)
    return seconds


def neighbour(program: str, many: int) -> None:
    print("\na fit of 100 points of another address, ms\n\n| | fits | median | 99 % | largest |\n|---|---|---|---|---|")
    with Server(program) as server:
        fits(server, None, 50)
        rows = {"alone": fits(server, None, 200)}
        pieces, over = list(body(many, "global")), threading.Event()
        thread = threading.Thread(target=lambda: (batch(server, pieces, many), over.set()))
        thread.start()
        time.sleep(0.2)
        rows[f"beside a batch of {many:,}"] = fits(server, over, 10_000)
        thread.join()
    for name, seconds in rows.items():
        cuts = statistics.quantiles(seconds, n=100)
        print(f"| {name} | {len(seconds)} | {1e3 * cuts[49]:.1f} | {1e3 * cuts[98]:.1f} | {1e3 * max(seconds):.1f} |", flush=True)


def gone(program: str, many: int) -> None:
    """A client that disconnects after a second."""
    with Server(program) as server:
        connection, _ = send(server, list(body(many, "global")))
        begin = time.perf_counter()
        while time.perf_counter() < begin + 1:
            connection.recv(1 << 18)
        before = server.busy()
        connection.shutdown(socket.SHUT_RDWR)
        connection.close()
        begin = time.perf_counter()
        last, steps = before, []
        while time.perf_counter() < begin + 2:
            time.sleep(0.1)
            now = server.busy()
            steps.append(now - last)
            last = now
        idle = next(i for i in range(len(steps)) if sum(steps[i:]) <= 0.02)
        print(f"\nafter a client of {many:,} curves disconnects: idle after {0.1 * idle:.1f} s, {1e3 * (last - before):.0f} ms of processor time")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program", type=os.path.abspath)
    parser.add_argument("--items", type=int, default=20_000)
    parser.add_argument("--many", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", nargs="+", default=["rates", "memory", "neighbour", "gone"])
    given = parser.parse_args()
    if "rates" in given.only:
        rates(given.program, given.items, given.rounds)
    for name, part in {"memory": memory, "neighbour": neighbour, "gone": gone}.items():
        if name in given.only:
            part(given.program, given.many)


if __name__ == "__main__":
    sys.exit(main())

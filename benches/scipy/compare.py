"""Cubic interpolation: compares piad with scipy's make_interp_spline in one run.

    compare.py PROGRAM [--counts 1000000 …]   # PROGRAM is target/release/piad

Points of a rippled spiral in space, chord length, not-a-knot. In process: from points to control points, with
the method `direct` and with `chebyshev` to the accuracy that scipy reaches. Over HTTP: posted as JSON or as
protobuf, fitted with `direct`, and the control points read in base64, from an array to an array.
Medians of interleaved runs. Needs ../requirements.txt.
"""

import argparse
import json
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request

import numpy as np
import orjson
import pybase64
from scipy.interpolate import make_interp_spline

HERE = os.path.dirname(os.path.abspath(__file__))
INTERPOLATE = ["cargo", "bench", "--quiet", "--locked", "--bench", "interpolate", "--"]
PORT = 18481
ROUNDS = 5


def spiral(count: int) -> np.ndarray:
    t = 60.0 * np.arange(count) / count
    r = 1.0 + t / 10.0 + 0.05 * np.sin(20.0 * t)
    return np.stack([r * np.cos(t), r * np.sin(t), 0.3 * t], axis=1)


def scipy(points: np.ndarray) -> tuple[float, np.ndarray, float]:
    """Seconds, control points, and the largest distance."""
    begin = time.perf_counter()
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    parameters = np.concatenate([[0.0], np.cumsum(steps)])
    spline = make_interp_spline(parameters, points, k=3)
    seconds = time.perf_counter() - begin
    distance = np.linalg.norm(spline(parameters) - points, axis=1).max()
    return seconds, spline.c, float(distance)


def library(points: np.ndarray, method: str, tolerance: float) -> tuple[float, np.ndarray, int, float]:
    """Seconds of `benches/interpolate.rs`, control points, iterations, and the largest distance."""
    with tempfile.TemporaryDirectory() as directory:
        given, result = (os.path.join(directory, name) for name in ("points", "result"))
        points.astype("<f8").tofile(given)
        command = [*INTERPOLATE, given, method, str(tolerance), result, "--runs", "9"]
        answer = json.loads(subprocess.run(command, cwd=HERE, check=True, stdout=subprocess.PIPE).stdout)
        return answer["seconds"], np.fromfile(result, "<f8").reshape(-1, 3), answer["iterations"], answer["max"]


def as_json(points: np.ndarray) -> bytes:
    basis = {"kind": "bspline", "degree": 3, "knots": "averaged"}
    job = {"curve": {"points": points, "basis": basis}, "method": {"kind": "direct"}}
    return orjson.dumps(job, option=orjson.OPT_SERIALIZE_NUMPY)


def as_protobuf(points: np.ndarray) -> bytes:
    """The message JobInput, which contains the bytes of the array."""
    def varint(number: int) -> bytes:
        high, low = divmod(number, 128)
        return bytes([low | 128]) + varint(high) if high else bytes([low])

    def field(number: int, *content: bytes | memoryview) -> list[bytes | memoryview]:
        return [varint(number << 3 | 2), varint(sum(map(len, content))), *content]

    numbers = memoryview(np.ascontiguousarray(points, "<f8")).cast("B")
    dimension, averaged = b"\x08\x03", b"\x18\x02"
    curve = [dimension, *field(2, numbers), *field(3, averaged)]
    return b"".join([*field(2, *curve), *field(5, *field(9))])


POSTS = {"application/json": as_json, "application/x-protobuf": as_protobuf}


def over_http(points: np.ndarray, language: str) -> tuple[float, np.ndarray]:
    """From array to array: serialized, posted, fitted, and the result parsed."""
    begin = time.perf_counter()
    body = POSTS[language](points)
    headers = {"Content-Type": language, "Accept": "application/json", "Prefer": "wait=100"}
    base = f"http://127.0.0.1:{PORT}"
    with urllib.request.urlopen(urllib.request.Request(f"{base}/v1/jobs", body, headers)) as answer:
        links = json.load(answer)["links"]
    with urllib.request.urlopen(f"{base}{links['result']}?encoding=base64") as answer:
        result = orjson.loads(answer.read())
    found = np.frombuffer(pybase64.b64decode(result["control_points"], validate=True), "<f8").reshape(result["shape"])
    return time.perf_counter() - begin, found


def start(program: str) -> subprocess.Popen:
    command = [os.path.abspath(program), "--listen", f"127.0.0.1:{PORT}", "--store", ":memory:", "--log", "warn", "--retain-jobs", "2"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    for _ in range(100):
        try:
            socket.create_connection(("127.0.0.1", PORT), 0.1).close()
            return process
        except OSError:
            time.sleep(0.1)
    raise SystemExit("the server has not started")


def line(count: int) -> None:
    points = spiral(count)
    taken: dict[str, list[float]] = {name: [] for name in ("scipy", "direct", "chebyshev", *POSTS)}
    for _ in range(ROUNDS):
        seconds, expected, distance = scipy(points)
        taken["scipy"].append(seconds)
        scale = np.abs(points).max()
        seconds, found, _, direct = library(points, "direct", 1e-12 * scale)
        taken["direct"].append(seconds)
        assert np.abs(found - expected).max() < 1e-9 * scale, "other control points"
        # The rounding error of both.
        accuracy = max(distance, direct, 1e-14 * scale)
        seconds, _, iterations, reached = library(points, "chebyshev", accuracy)
        assert reached <= accuracy, (reached, accuracy)
        taken["chebyshev"].append(seconds)
        for language in POSTS:
            seconds, _ = over_http(points, language)
            taken[language].append(seconds)
    medians = {name: statistics.median(seconds) for name, seconds in taken.items()}
    cells = [f"{1e3 * medians[name]:.1f} | {medians['scipy'] / medians[name]:.1f}×" for name in ("direct", "chebyshev", *POSTS)]
    print(f"| {count} | {1e3 * medians['scipy']:.1f} | {cells[0]} | {cells[1]} ({iterations} iterations) | {cells[2]} | {cells[3]} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--counts", type=int, nargs="+", default=[1000, 10_000, 100_000, 1_000_000])
    given = parser.parse_args()
    server = start(given.program)
    try:
        print("| points | scipy, ms | direct, ms | faster | chebyshev, ms | faster | JSON over HTTP, ms | faster | protobuf over HTTP, ms | faster |")
        print("|---|---|---|---|---|---|---|---|---|---|")
        for count in given.counts:
            line(count)
    finally:
        server.terminate()
        server.wait()


if __name__ == "__main__":
    sys.exit(main())

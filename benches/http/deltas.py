"""Measures whole streams in each encoding: bytes, and seconds until the last event, directly and
through a slow network.

    deltas.py PROGRAM [--points 1000 10000 100000 1000000]        # PROGRAM is target/release/piad

Curves with these numbers of points, and a surface of 300 x 333 points, with 50 iterations each;
`errors` is the fit without geometry. Direct times are medians of five, interleaved. The slow
network is a proxy of 100 or 10 Mbit/s. Exits with code 1 if differences take more than a tenth of
the bytes of JSON or a fifth of those of 64-bit base64. Takes six minutes and 2 GB.
"""

import argparse
import asyncio
import json
import math
import statistics
import sys
import threading
import time
import urllib.request
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "python"))
from over_http import server

ITERATIONS = 50
ENCODINGS = {
    "errors": "view=errors",
    "json": "encoding=json",
    "base64": "encoding=base64",
    "base64_f32": "encoding=base64_f32",
    "delta": "encoding=delta",
}
TURNS = 5
# Mbit/s. Streams that would take longer than this many seconds are skipped.
RATES = [100, 10]
LONGEST = 30
PART = 16_384
# Seconds that a proxy may be behind its rate and catch up.
BEHIND = 0.05


def curve(count: int) -> dict:
    def point(i: int) -> list[float]:
        t = 60.0 * i / count
        r = 1.0 + t / 10.0 + 0.05 * math.sin(20.0 * t)
        return [r * math.cos(t), r * math.sin(t), 0.3 * t]

    return {"curve": {"points": [point(i) for i in range(count)]}}


def surface(rows: int, columns: int) -> dict:
    def point(i: int, j: int) -> list[float]:
        return [i, j, 20.0 * math.sin(0.05 * i) * math.cos(0.07 * j) + math.sin(0.9 * i + 0.4 * j)]

    return {"surface": {"points": [[point(i, j) for j in range(columns)] for i in range(rows)]}}


class Proxy:
    """Forwards bytes, those of responses no faster than a rate."""

    def __init__(self, port: int, megabits: float):
        self.port, self.rate = port, megabits * 1e6 / 8
        self.loop = asyncio.new_event_loop()
        started = threading.Event()
        threading.Thread(target=self.run, args=(started,), daemon=True).start()
        started.wait()

    def run(self, started: threading.Event) -> None:
        asyncio.set_event_loop(self.loop)
        listening = self.loop.run_until_complete(asyncio.start_server(self.connect, "127.0.0.1", 0))
        self.address = "http://127.0.0.1:%d" % listening.sockets[0].getsockname()[1]
        started.set()
        self.loop.run_forever()

    async def connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        onward, back = await asyncio.open_connection("127.0.0.1", self.port)
        await asyncio.gather(self.copy(reader, back, math.inf), self.copy(onward, writer, self.rate))

    async def copy(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, rate: float) -> None:
        free = time.perf_counter()
        while part := await reader.read(PART):
            free = max(free, time.perf_counter() - BEHIND) + len(part) / rate
            await asyncio.sleep(free - time.perf_counter())
            writer.write(part)
            await writer.drain()
        writer.close()


def read(base: str, body: bytes, query: str) -> tuple[int, float]:
    """The bytes of a stream, and the seconds until its end."""
    headers = {"Content-Type": "application/json", "Accept": "text/event-stream"}
    start = time.perf_counter()
    request = urllib.request.Request(f"{base}/v1/jobs?{query}", body, headers)
    size = 0
    with urllib.request.urlopen(request) as answer:
        while part := answer.read1(1 << 20):
            size += len(part)
    return size, time.perf_counter() - start


def row(*cells: object) -> None:
    print("|", " | ".join(map(str, cells)), "|", flush=True)


def compare(name: str, job: dict, base: str, proxies: dict[int, Proxy]) -> dict[str, int]:
    body = json.dumps(job | {"stop": {"tolerance": 0, "max_iterations": ITERATIONS}}).encode()
    sizes: dict[str, int] = {}
    seconds: dict[str, list[float]] = {encoding: [] for encoding in ENCODINGS}
    for _ in range(TURNS):
        for encoding, query in ENCODINGS.items():
            sizes[encoding], alone = read(base, body, query)
            seconds[encoding].append(alone)
    for encoding, query in ENCODINGS.items():
        times = [f"{statistics.median(seconds[encoding]):.3f}"]
        for megabits, proxy in proxies.items():
            is_short = sizes[encoding] * 8e-6 / megabits < LONGEST
            times.append(f"{read(proxy.address, body, query)[1]:.2f}" if is_short else "–")
        row(name, encoding, f"{sizes[encoding] / 1e6:.2f} MB", f"{sizes['json'] / sizes[encoding]:.1f}", *times)
    return sizes


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--points", type=int, nargs="*", default=[1_000, 10_000, 100_000, 1_000_000])
    given = parser.parse_args()
    wrong = []
    with server(given.program) as base:
        proxies = {rate: Proxy(int(base.rsplit(":", 1)[1]), rate) for rate in RATES}
        row("points", "encoding", "stream", "times fewer bytes", "seconds", *(f"at {rate} Mbit/s" for rate in RATES))
        row(*["---"] * (5 + len(proxies)))
        jobs = {f"{count:,}": curve(count) for count in given.points} | {"300 × 333": surface(300, 333)}
        for name, job in jobs.items():
            sizes = compare(name, job, base, proxies)
            if 10 * sizes["delta"] > sizes["json"] or 5 * sizes["delta"] > sizes["base64"]:
                wrong.append(f"{name}: {sizes}")
    print("\n".join(wrong) or "ok: differences take few bytes")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

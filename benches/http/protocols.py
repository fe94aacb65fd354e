"""The same jobs over HTTP/1.1, HTTP/2 and gRPC, in one run: 100 points, 50 iterations streamed.

    protocols.py PROGRAM        # PROGRAM is target/release/piad

Needs h2load (Debian: nghttp2-client), which speaks all three, and grpcio-tools (tests/python/requirements.txt).
"""

import json
import os
import re
import statistics
import struct
import subprocess
import sys
import tempfile

from compare import EVENTS, ITERATIONS, job, servers, start, stop

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../tests/python"))
from messages import generate  # noqa: E402

SECONDS = 4
# The control points of all iterations, in 64 bits; in decimal digits they are longer.
LEAST = (ITERATIONS + 1) * 100 * 3 * 8
SSE = {"content-type": "application/json", "accept": "text/event-stream"}
PROTOBUF = {"content-type": "application/x-protobuf", "accept": "application/x-protobuf"}
GRPC = {"content-type": "application/grpc", "te": "trailers"}


def bodies() -> dict[str, bytes]:
    """The job as JSON, as a message, and as the message of a call."""
    messages, _ = generate()
    points = json.loads(job(100))["curve"]["points"]
    curve = messages.Curve(dimension=3, points=[x for point in points for x in point])
    rules = messages.StopRules(tolerance=0, max_iterations=ITERATIONS)
    given = messages.JobInput(curve=curve, stop=rules)
    call = messages.FitRequest(input=given).SerializeToString()
    return {
        "json": job(100),
        "protobuf": given.SerializeToString(),
        "grpc": struct.pack(">BI", 0, len(call)) + call,
    }


def load(port: int, path: str, body: bytes, headers: dict[str, str], http1: bool, connections: int) -> float:
    """Jobs per second; checks that all responses are complete."""
    with tempfile.NamedTemporaryFile() as file:
        file.write(body)
        file.flush()
        command = ["h2load", "-t1", f"-c{connections}", "-m1", f"-D{SECONDS}", f"-d{file.name}", *(["--h1"] if http1 else [])]
        command += [f"-H{name}: {value}" for name, value in headers.items()]
        output = subprocess.run([*command, f"http://127.0.0.1:{port}{path}"], capture_output=True, text=True, check=True).stdout
    done, failed, errored = map(int, re.search(r"(\d+) done, \d+ succeeded, (\d+) failed, (\d+) errored", output).groups())
    # h2load counts a rejected gRPC call as success.
    data = int(re.search(r"\((\d+)\) data", output)[1])
    assert (failed, errored) == (0, 0) and data >= done * LEAST, output
    return float(re.search(r"([\d.]+) req/s", output)[1])


def main() -> None:
    command, port, path = servers(sys.argv[1])["piad"]
    given = bodies()
    ways = {
        "HTTP/1.1, JSON": (path, given["json"], SSE, True),
        "HTTP/2, JSON": (path, given["json"], SSE, False),
        "HTTP/1.1, protobuf": (f"{path}/stream", given["protobuf"], PROTOBUF, True),
        "HTTP/2, protobuf": (f"{path}/stream", given["protobuf"], PROTOBUF, False),
        "gRPC": ("/piad.v1.FittingService/Fit", given["grpc"], GRPC, False),
    }
    process = start(command, port)
    print("| connections | | jobs/s | events/s |\n|---|---|---|---|")
    for connections in (1, 16):
        rates = {way: [] for way in ways}
        for _ in range(3):
            for way, what in ways.items():
                rates[way].append(load(port, *what, connections))
        for way, jobs in rates.items():
            jobs = statistics.median(jobs)
            print(f"| {connections} | {way} | {jobs:.0f} | {jobs * EVENTS:.0f} |", flush=True)
    stop(process)


if __name__ == "__main__":
    main()

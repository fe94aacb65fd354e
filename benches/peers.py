"""How long a small job of one address takes while another address has many jobs.

    python3 benches/peers.py target/release/piad [jobs ...]
"""

import http.client
import json
import math
import statistics
import subprocess
import sys
import threading
import time

FIRST, OTHER = ("127.0.0.1", 0), ("127.0.0.2", 0)
# After so many seconds the small job is given up.
PATIENCE = 60


def points(count):
    turn = [2 * math.pi * i / count for i in range(count)]
    return [[math.cos(a) * (2 + 0.3 * math.sin(5 * a)), math.sin(a)] for a in turn]


LONG = {
    "curve": {"points": points(400)},
    "method": {"kind": "transpose"},
    "stop": {"tolerance": 0, "max_iterations": 1_000_000},
}
SMALL = {"curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3]]}}


def connect(port, source):
    return http.client.HTTPConnection("127.0.0.1", port, PATIENCE, source)


def post(connection, job, headers=()):
    headers = {"content-type": "application/json", **dict(headers)}
    connection.request("POST", "/v1/jobs", json.dumps(job), headers)
    answer = json.loads(connection.getresponse().read())
    return answer.get("state", answer)


def small(port):
    """Seconds until a small job of the other address has ended, or what it is then."""
    connection = connect(port, OTHER)
    begin = time.monotonic()
    state = post(connection, SMALL, {"prefer": f"wait={PATIENCE // 2}"})
    return time.monotonic() - begin if state == "converged" else math.inf


def measure(program, jobs):
    command = [program, "--listen", "127.0.0.1:0", "--data-dir", ":memory:"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        line = next(line for line in server.stderr if "listening on" in line)
        port = int(line.strip().rsplit(":", 1)[1])
        # A pipe that nobody reads would fill up.
        threading.Thread(target=server.stderr.read, daemon=True).start()
        try:
            small(port)
            alone = statistics.median(small(port) for _ in range(9))
            connection = connect(port, FIRST)
            for _ in range(jobs):
                post(connection, LONG)
            beside = statistics.median(small(port) for _ in range(3))
            print(f"| {jobs} | {alone * 1e3:.1f} | {beside * 1e3:.1f} |", flush=True)
        finally:
            server.kill()


if __name__ == "__main__":
    print("| jobs of the first | small job alone, ms | beside them, ms |\n|---|---|---|")
    for count in map(int, sys.argv[2:] or ["64", "256", "5000"]):
        measure(sys.argv[1], count)

"""Measures the cost of exporting traces for small requests: servers without a collector, with a
good one, with one that responds after five seconds, with a missing one and with one that never
responds, in one run.

    traces.py PROGRAM [--rounds N]      # PROGRAM is target/release/piad

Requests to the servers are interleaved, over one connection each, so that other load affects all of
them. Needs grpcio.
"""

import argparse
import http.client
import json
import math
import multiprocessing
import os
import re
import signal
import socket
import statistics
import subprocess
import threading
import time
from multiprocessing.connection import Connection

import grpc

SERVICE = "opentelemetry.proto.collector.trace.v1.TraceService"
WARM = 200
JOB = json.dumps({
    "curve": {"points": [[math.cos(0.06 * i), math.sin(0.06 * i), 0.01 * i] for i in range(100)]},
    "stop": {"relative_tolerance": 1e-6},
})
REQUESTS = {
    "GET /livez": ("GET", "/livez", None),
    "POST /v1/fit, 100 points": ("POST", "/v1/fit", JOB),
}


def collect(pipe: Connection, pause: float) -> None:
    """A collector that accepts everything after this many seconds, and counts the bytes."""
    from concurrent.futures import ThreadPoolExecutor

    taken = multiprocessing.Value("q", 0)

    def export(request: bytes, _context: grpc.ServicerContext) -> bytes:
        time.sleep(pause)
        taken.value += len(request)
        return b""

    server = grpc.server(ThreadPoolExecutor(1))
    calls = {"Export": grpc.unary_unary_rpc_method_handler(export)}
    server.add_generic_rpc_handlers([grpc.method_handlers_generic_handler(SERVICE, calls)])
    pipe.send(server.add_insecure_port("127.0.0.1:0"))
    server.start()
    pipe.recv()
    pipe.send(taken.value)


class Server:
    """A server, a connection to it, and its response times."""

    def __init__(self, program: str, collector: str | None) -> None:
        command = [program, "--listen", "127.0.0.1:0", "--store", ":memory:"]
        if collector is not None:
            command += ["--otlp-endpoint", collector]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        assert self.process.stderr is not None
        for line in self.process.stderr:
            if found := re.search(r"listening on http://(\S+)", line):
                break
        else:
            raise SystemExit(f"{command} has not started")
        # A full pipe would block the server.
        threading.Thread(target=self.process.stderr.read, daemon=True).start()
        self.connection = http.client.HTTPConnection(found[1])
        self.times: dict[str, list[float]] = {name: [] for name in REQUESTS}

    def ask(self, name: str) -> None:
        method, path, body = REQUESTS[name]
        headers = {} if body is None else {"Content-Type": "application/json"}
        begin = time.perf_counter()
        self.connection.request(method, path, body, headers)
        response = self.connection.getresponse()
        response.read()
        self.times[name].append(time.perf_counter() - begin)
        if response.status != 200:
            raise SystemExit(f"{name}: {response.status}")

    def processor(self) -> float:
        """CPU seconds so far."""
        with open(f"/proc/{self.process.pid}/stat") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def stop(self) -> float:
        """Stops it and returns the seconds that this takes."""
        begin = time.perf_counter()
        self.connection.close()
        self.process.send_signal(signal.SIGTERM)
        self.process.wait()
        return time.perf_counter() - begin


def collector(pause: float) -> tuple[Connection, str]:
    """Starts a collector: the connection with it, and its URL."""
    ours, theirs = multiprocessing.Pipe()
    multiprocessing.Process(target=collect, args=(theirs, pause), daemon=True).start()
    return ours, f"http://127.0.0.1:{ours.recv()}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--rounds", type=int, default=5000)
    arguments = parser.parse_args()

    ours, good = collector(0)
    _, slow = collector(5)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        gone = f"http://127.0.0.1:{listener.getsockname()[1]}"
    # The operating system accepts connections that are never read.
    hanging = socket.create_server(("127.0.0.1", 0))
    hangs = f"http://127.0.0.1:{hanging.getsockname()[1]}"

    collectors = {"none": None, "good": good, "slow": slow, "gone": gone, "hanging": hangs}
    servers = {name: Server(arguments.program, url) for name, url in collectors.items()}
    for name in REQUESTS:
        for round_ in range(arguments.rounds + WARM):
            if round_ == WARM:
                for server in servers.values():
                    server.times[name].clear()
            for server in servers.values():
                server.ask(name)

    print("| request | collector | p50 | p99 |\n|---|---|---|---|")
    for name in REQUESTS:
        for kind, server in servers.items():
            cuts = statistics.quantiles(server.times[name], n=100)
            print(f"| {name} | {kind} | {1e6 * cuts[49]:.0f} µs | {1e6 * cuts[98]:.0f} µs |")
    print("\n| collector | processor time of the server | end after SIGTERM |\n|---|---|---|")
    for kind, server in servers.items():
        spent = server.processor()
        print(f"| {kind} | {spent:.2f} s | {server.stop():.2f} s |")
    ours.send(None)
    print(f"\nThe good collector has taken {ours.recv() / 1e6:.1f} MB of spans.")


if __name__ == "__main__":
    main()

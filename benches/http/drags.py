"""Drags one of 1e5 points: the time of an ephemeral edit end to end, and its remaining memory.

    drags.py PROGRAM        # PROGRAM is target/release/piad

A curve of 1e5 points is fitted; then one point is moved, a little further each time, and 25 control points
follow. Times and bytes are those of whole responses: of 100 drags over a persistent connection, and
of 100 by curl, with a new connection each. Finally 1,000 drags: the memory of the process, the
store and the list of jobs before and after. Needs curl.
"""

import argparse
import http.client
import json
import math
import os
import re
import socket
import statistics
import subprocess
import tempfile
import time
import urllib.request

PORT = 18481
COUNT, INDEX, AROUND = 100_000, 50_000, 12
QUERIES = {
    "samples, the last iteration": "view=samples&samples=1000&encoding=base64_f32&every=1000000&describe=none",
    "changes, all iterations": "changed=true&describe=none",
}


def point(i: int) -> list[float]:
    """A rippled spiral in space."""
    t = 60.0 * i / COUNT
    r = 1.0 + t / 10.0 + 0.05 * math.sin(20.0 * t)
    return [r * math.cos(t), r * math.sin(t), 0.3 * t]


def edit(k: int, ephemeral: bool = True) -> bytes:
    x, y, z = point(INDEX)
    request = {
        "points": [{"index": INDEX, "point": [x, y, z + 1e-5 * k]}],
        "method": {"kind": "local", "indices": list(range(INDEX - AROUND, INDEX + AROUND + 1))},
    }
    if ephemeral:
        request |= {"ephemeral": True, "session": "drag"}
    return json.dumps(request).encode()


def metric(name: str) -> float:
    text = urllib.request.urlopen(f"http://127.0.0.1:{PORT}/metrics").read().decode()
    return float(re.search(rf"^{name} (\S+)", text, re.MULTILINE).group(1))


def resident(process: subprocess.Popen) -> float:
    """Megabytes of the process."""
    with open(f"/proc/{process.pid}/status") as status:
        return int(re.search(r"VmRSS:\s+(\d+)", status.read()).group(1)) / 1024


def report(name: str, seconds: list[float], sizes: list[int]) -> None:
    times = sorted(1000 * it for it in seconds)
    ninth = times[len(times) * 9 // 10]
    print(f"{name:55} median {statistics.median(times):6.2f} ms, 90 % within {ninth:6.2f} ms, {statistics.median(sizes) / 1000:6.1f} kB")


def drags(path: str, count: int) -> tuple[list[float], list[int]]:
    connection = http.client.HTTPConnection("127.0.0.1", PORT)
    connection.connect()
    connection.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    seconds, sizes = [], []
    for k in range(count):
        body = edit(k)
        begin = time.perf_counter()
        connection.request("POST", path, body, {"Content-Type": "application/json"})
        answer = connection.getresponse()
        text = answer.read()
        seconds.append(time.perf_counter() - begin)
        sizes.append(len(text))
        assert answer.status == 200 and b'"converged"' in text, text[-500:]
    return seconds, sizes


def by_curl(path: str, count: int) -> tuple[list[float], list[int]]:
    seconds, sizes = [], []
    for k in range(count):
        with tempfile.NamedTemporaryFile() as body:
            body.write(edit(k))
            body.flush()
            url = f"http://127.0.0.1:{PORT}{path}"
            arguments = ["-s", "-o", os.devnull, "-w", "%{time_total} %{size_download}", "-H", "Content-Type: application/json"]
            command = ["curl", *arguments, "--data-binary", f"@{body.name}", url]
            time_total, size = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
        seconds.append(float(time_total))
        sizes.append(int(size))
    return seconds, sizes


def start(program: str, directory: str) -> subprocess.Popen:
    command = [os.path.abspath(program), "--listen", f"127.0.0.1:{PORT}", "--store", directory, "--log", "warn"]
    process = subprocess.Popen(command)
    for _ in range(200):
        try:
            socket.create_connection(("127.0.0.1", PORT), 0.1).close()
            return process
        except OSError:
            time.sleep(0.05)
    raise SystemExit("the program has not started")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    program = parser.parse_args().program
    with tempfile.TemporaryDirectory() as directory:
        process = start(program, directory)
        try:
            body = json.dumps({"curve": {"points": [point(i) for i in range(COUNT)]}}).encode()
            request = urllib.request.Request(f"http://127.0.0.1:{PORT}/v1/jobs", body, {"Content-Type": "application/json", "Prefer": "wait=60"})
            path = json.load(urllib.request.urlopen(request))["links"]["edits"] + "/stream"
            for name, query in QUERIES.items():
                drags(f"{path}?{query}", 10)
                report(f"{name}", *drags(f"{path}?{query}", 100))
                report(f"{name}, by curl", *by_curl(f"{path}?{query}", 100))
            # After a restart the parent is not in memory.
            process.terminate()
            process.wait()
            process = start(program, directory)
            query = QUERIES["samples, the last iteration"]
            report("after a restart, the first", *drags(f"{path}?{query}", 1))
            report("after a restart, 100 more", *drags(f"{path}?{query}", 100))
            before, writes = resident(process), metric("piad_store_writes_total")
            report("1,000", *drags(f"{path}?{query}", 1000))
            after, jobs = resident(process), json.load(urllib.request.urlopen(f"http://127.0.0.1:{PORT}/v1/jobs"))["jobs"]
            print(f"memory {before:.1f} MB before, {after:.1f} MB after; {len(jobs)} job listed; {metric('piad_store_writes_total') - writes:.0f} writes of the store")
        finally:
            process.terminate()
            process.wait()


if __name__ == "__main__":
    main()

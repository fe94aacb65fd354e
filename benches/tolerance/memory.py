"""Compares the memory of fits with automatic knots: admitted by the server, and at the peak of its
process.

    memory.py PROGRAM       # PROGRAM is target/release/piad

Each fit has its own server, with jobs in memory. *Admitted* is `piad_memory_used_bytes` at the
start of the fit, which is the estimate; *peak* is the largest resident size of the process during
the fit, including the stored job and the program. Exits with code 1 if the peak exceeds the
estimate plus the memory of an idle server. Linux only; needs requirements.txt, and some minutes.
"""

import re
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

import numpy as np
import orjson

import shapes

MIB = 1 << 20
# The memory of an idle server (docs/evidence/reliability.md).
OWN = 110 * MIB


def peaks(noise: float) -> np.ndarray:
    """300 × 300 points of MATLAB's function."""
    x, y = np.meshgrid(np.linspace(-3, 3, 300), np.linspace(-3, 3, 300), indexing="ij")
    z = (
        3 * (1 - x) ** 2 * np.exp(-(x**2) - (y + 1) ** 2)
        - 10 * (x / 5 - x**3 - y**5) * np.exp(-(x**2) - y**2)
        - np.exp(-((x + 1) ** 2) - y**2) / 3
    )
    return np.stack([x, y, z + noise * np.random.default_rng(3).standard_normal(x.shape)], axis=2)


def curve(count: int, noise: float) -> dict:
    return {"curve": {"points": shapes.spiral(count, noise)}}


def scattered() -> dict:
    return {"surface": {"scattered": shapes.terrain(), "parameters": {"project": "xy"}}}


# Name, data, tolerance.
CASES = [
    ("curve, 100,000 points", lambda: curve(100_000, 0), 1e-3),
    ("the same with noise", lambda: curve(100_000, 1e-3), 2e-3),
    ("curve, 1,000,000 points", lambda: curve(1_000_000, 0), 1e-3),
    ("the same with noise", lambda: curve(1_000_000, 1e-3), 3e-3),
    ("grid, 300 × 300 points", lambda: {"surface": {"points": peaks(0)}}, 1e-4),
    ("the same with noise", lambda: {"surface": {"points": peaks(1e-2)}}, 1e-2),
    ("100,000 scattered points, 100 m", scattered, 100),
    ("the same, 20 m", scattered, 20),
]


def read(url: str, body: bytes | None = None) -> bytes:
    request = urllib.request.Request(url, body, {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as answer:
        return answer.read()


def resident(process: subprocess.Popen, field: str) -> int:
    status = Path(f"/proc/{process.pid}/status").read_text()
    return 1024 * int(re.search(rf"^{field}:\s+(\d+) kB", status, re.MULTILINE).group(1))


def measure(process: subprocess.Popen, base: str, geometry: dict, tolerance: float) -> tuple[int, int, int, str]:
    """Bytes of the idle server, bytes that the fit was admitted with, bytes at the peak, and control points."""
    time.sleep(0.5)
    idle = resident(process, "VmRSS")
    method = {"kind": "least_squares", "control_points": "auto"}
    job = geometry | {"method": method, "stop": {"tolerance": tolerance}, "stream": {"view": "errors"}}
    resource = orjson.loads(read(f"{base}/v1/jobs", orjson.dumps(job, option=orjson.OPT_SERIALIZE_NUMPY)))
    # Resets the peak.
    Path(f"/proc/{process.pid}/clear_refs").write_text("5")
    admitted = 0
    while resource["state"] in ("queued", "running"):
        used = re.search(rb"^piad_memory_used_bytes (\S+)$", read(f"{base}/metrics"), re.MULTILINE)
        # During the fit, iterations buffered for readers count, too.
        admitted = admitted or int(float(used.group(1)))
        time.sleep(0.05)
        resource = orjson.loads(read(base + resource["links"]["self"]))
    assert resource["state"] == "converged", resource
    peak = resident(process, "VmHWM")
    net = np.array(orjson.loads(read(base + resource["links"]["result"]))["control_points"])
    return idle, admitted, peak, " × ".join(map(str, net.shape[:-1]))


def main() -> int:
    wrong = 0
    print("| fit | tolerance | control points | admitted, MiB | idle, MiB | peak, MiB |")
    print("|---|---|---|---|---|---|")
    for name, make, tolerance in CASES:
        command = [sys.argv[1], "--listen", "127.0.0.1:0", "--store", ":memory:", "--log-format", "json", "--max-body", "256MiB"]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        try:
            found = (re.search(r"listening on (http://[^\s\"]+)", line) for line in process.stderr)
            base = next(it for it in found if it).group(1)
            threading.Thread(target=process.stderr.read, daemon=True).start()
            idle, admitted, peak, shape = measure(process, base, make(), tolerance)
        finally:
            process.terminate()
            process.wait()
        print(f"| {name} | {tolerance:g} | {shape} | {admitted / MIB:.0f} | {idle / MIB:.0f} | {peak / MIB:.0f} |", flush=True)
        wrong += peak > admitted + OWN
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

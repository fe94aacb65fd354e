"""Fits the examples on a real server and checks all exported files.

    over_http.py PROGRAM            # the server to start, such as target/debug/piad

Needs the packages of requirements.txt.
"""

import contextlib
import glob
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import urllib.request

ROOT = os.path.join(os.path.dirname(__file__), "..", "..")
FORMATS = {"step": "step", "iges": "igs", "obj": "obj", "gltf": "glb", "stl": "stl", "dxf": "dxf", "svg": "svg", "csv": "csv"}


@contextlib.contextmanager
def server(program: str, *flags: str, store: str = ":memory:"):
    """Starts a server on a free port and yields its address."""
    command = [program, "--listen", "127.0.0.1:0", "--store", store, "--log-format", "json", *flags]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        for line in process.stderr:
            found = re.search(r"listening on (https?://[^\s\"]+)", line)
            if found:
                break
        else:
            raise SystemExit(f"{program} has not started")
        # A full pipe would block the server.
        threading.Thread(target=process.stderr.read, daemon=True).start()
        yield found.group(1)
    finally:
        process.terminate()
        process.wait()


def fetch(url: str, body: bytes | None = None) -> bytes:
    request = urllib.request.Request(url, body, {"Content-Type": "application/json", "Prefer": "wait=60"})
    with urllib.request.urlopen(request) as response:
        return response.read()


def write_all(base: str, folder: str) -> None:
    """Fits every example; writes the job, the result and its files."""
    for example in sorted(glob.glob(os.path.join(ROOT, "examples", "*.json"))):
        name = os.path.splitext(os.path.basename(example))[0]
        with open(example, "rb") as file:
            job = file.read()
        resource = json.loads(fetch(f"{base}/v1/jobs", job))
        result = base + resource["links"]["result"]
        files = {"job.json": job, "result.json": fetch(result)}
        formats = {format: ending for format, ending in FORMATS.items() if format != "stl" or resource["kind"] == "surface"}
        files |= {ending: fetch(f"{result}/{format}") for format, ending in formats.items()}
        for ending, content in files.items():
            with open(os.path.join(folder, f"{name}.{ending}"), "wb") as file:
                file.write(content)


def main() -> int:
    checker = os.path.join(os.path.dirname(__file__), "export_check.py")
    with tempfile.TemporaryDirectory() as folder, server(sys.argv[1]) as base:
        write_all(base, folder)
        return subprocess.run([sys.executable, checker, "--all", folder]).returncode


if __name__ == "__main__":
    sys.exit(main())

"""Compares the memory for reading bodies, per byte, with the accounted memory.

    bodies.py PROGRAM [--megabytes 8]        # PROGRAM is target/release/piad

Each list of a body is filled with its shortest elements, without a limit of points. Each body has
its own server; the peak is the increase over the idle process. Exits with status 1 if a body takes
more than is accounted. Takes a minute.
"""

import argparse
import contextlib
import http.client
import re
import subprocess
import sys
import threading
import zlib
from pathlib import Path

MOST_POINTS = 100_000_000

# The minimum memory accounted per byte of a body, as it arrives and while it is read.
COUNTED = 16

JSON, CSV, PROTOBUF = "application/json", "text/csv", "application/x-protobuf"
CURVE = b'"points":[[0,0],[1,2],[3,1],[4,3]]'
ROWS = b'"points":[' + b",".join(b"[[%d,0,0],[%d,1,1],[%d,2,0],[%d,3,1]]" % (i, i, i, i) for i in range(4)) + b"]"


def repeated(element: bytes, size: int) -> bytes:
    return element * (size // len(element))


def filled(element: bytes, size: int) -> bytes:
    return b"[" + element + repeated(b"," + element, size) + b"]"


def curve(field: bytes, element: bytes, size: int) -> bytes:
    return b'{"curve":{' + CURVE + b"," + field + filled(element, size) + b"}}"


def surface(field: bytes, element: bytes, size: int) -> bytes:
    return b'{"surface":{' + ROWS + b"," + field + filled(element, size) + b"}}"


def method(fields: bytes, element: bytes, size: int, end: bytes = b"}}") -> bytes:
    return b'{"curve":{' + CURVE + b'},"method":{' + fields + filled(element, size) + end


def field(tag: int, content: bytes) -> bytes:
    """A field of a message that has a length."""
    head, length = bytes([tag << 3 | 2]), len(content)
    while length >= 128:
        head += bytes([length & 127 | 128])
        length >>= 7
    return head + bytes([length]) + content


def line_of_numbers(size: int) -> bytes:
    return b"".join(b"%d %d 1\n" % (i // 1000, i % 1000) for i in range(size // 9000 * 1000))


def bodies(size: int) -> dict[str, tuple[str, str, bytes]]:
    """The path, the media type and the body of each list."""
    least = b'"kind":"least_squares","control_points":3,'
    rows = size // 4000
    # A fit that is created and finally rejected: the memory of a job is accounted with the job.
    refused = b'},"stop":{"tolerance":-1}}'
    json = {
        "points of a curve": b'{"curve":{"points":' + filled(b"[0]", size) + b"}}",
        "points in space": b'{"curve":{"points":' + filled(b"[0,0,0]", size) + b"}}",
        "heights": b'{"surface":{"points":[[0' + repeated(b",0", size) + b"]]}}",
        "rows of heights": b'{"surface":{"points":[' + b",".join([b"[0" + b",0" * 1999 + b"]"] * rows) + b"]" + refused,
        "a curve": b'{"curve":{"points":' + filled(b"[0],[1]", size) + refused,
        "missing points": b'{"surface":{"points":[' + filled(b"null", size) + b"]}}",
        "scattered points": b'{"surface":{"scattered":' + filled(b"[0,0,0]", size) + b',"parameters":"project"}}',
        "points, unusual": b'{"curve":{"points":' + filled(b"[0]", size) + b',"points":0}}',
        "weights": curve(b'"weights":', b"1", size),
        "weights of a surface": surface(b'"weights":', b"[1]", size),
        "weights of a direction": surface(b'"weights":{"v":[1],"u":', b"1", size)[:-2] + b"}}}",
        "parameters": curve(b'"parameters":', b"1", size),
        "pairs of parameters": b'{"surface":{"scattered":[[0,0,0]],"parameters":' + filled(b"[0,0]", size) + b"}}",
        "knots": curve(b'"basis":{"kind":"bspline","knots":', b"1", size)[:-2] + b"}}}",
        "derivatives": curve(b'"ends":{"start":{"derivatives":', b"[1]", size)[:-2] + b"}}}}",
        "indices": method(b'"kind":"local","indices":', b"0", size),
        "pairs of indices": method(b'"kind":"local","indices":', b"[0,0]", size),
        "thresholds": method(b'"kind":"adaptive","threshold":', b"1", size),
        "row of a transform": method(b'"kind":"custom","transform":[', b"1", size, b"]}}"),
        "weights of data": method(least + b'"data_weights":', b"1", size),
        "constraints": method(least + b'"constraints":', b'{"at":"end"}', size),
        "a name": b'{"name":"' + repeated(b"\\u0001", size) + b'"}',
        "a key": b'{"' + repeated(b"a", size) + b'":0}',
    }
    local = field(5, field(3, field(1, bytes(size))))
    doubles = bytes(size // 8 * 8)
    messages = {
        "message: points": field(2, b"\x08\x01" + field(2, doubles)),
        "message: weights": field(2, b"\x08\x01" + field(5, doubles)),
        "message: indices": field(2, b"\x08\x01" + field(2, bytes(32))) + local,
        "message: missing": field(3, b"\x08\x01" + field(5, bytes(size))),
        "message: constraints": field(5, field(10, repeated(b"\x52\x00", size))),
    }
    files = {
        "file: one column": repeated(b"1\n", size),
        "file: two columns": repeated(b"0,1\n", size),
        "file: rows": line_of_numbers(size),
        "file: blank lines": repeated(b"0 0\n\n", size),
        "file: remarks": b"1 2\n3 4\n\n" + repeated(b"a\n", size),
        "file: names of columns": repeated(b"a,", size) + b"\n1,2\n3,4\n",
        "file: no text": repeated(b"\xff", size),
    }
    jobs = {name: ("/v1/jobs", JSON, body) for name, body in json.items()}
    jobs |= {name: ("/v1/jobs", PROTOBUF, body) for name, body in messages.items()}
    jobs |= {name: ("/v1/fit", CSV, body) for name, body in files.items()}
    jobs["file: a curve"] = ("/v1/fit?stop.tolerance=-1", CSV, repeated(b"0\n1\n", size))
    return jobs | {"file: shown": ("/v1/points", CSV, repeated(b"1e15 1e15\n", size))}


@contextlib.contextmanager
def server(program: str):
    """A server with enough memory for each body; returns its process and port."""
    command = [program, "--listen", "127.0.0.1:0", "--store", ":memory:", "--memory", "64GiB"]
    command += ["--max-points", str(MOST_POINTS), "--log-format", "json"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        for line in process.stderr:
            found = re.search(r"listening on http://127.0.0.1:(\d+)", line)
            if found:
                break
        else:
            raise SystemExit(f"{program} has not started")
        threading.Thread(target=process.stderr.read, daemon=True).start()
        yield process.pid, int(found.group(1))
    finally:
        process.kill()
        process.wait()


def resident(pid: int, what: str) -> int:
    found = re.search(what + r":\s+(\d+)", Path(f"/proc/{pid}/status").read_text())
    return int(found.group(1)) << 10


def ask(port: int, method: str, path: str, body: bytes | None = None, media_type: str = JSON, coding: str = "identity"):
    connection = http.client.HTTPConnection("127.0.0.1", port)
    connection.request(method, path, body, {"Content-Type": media_type, "Content-Encoding": coding})
    response = connection.getresponse()
    text = response.read()
    connection.close()
    return response.status, text


def accounted(port: int, most: list[int], ended: threading.Event) -> None:
    """Samples the memory accounted by the server until it is stopped."""
    while not ended.is_set():
        text = ask(port, "GET", "/metrics")[1].decode()
        most[0] = max(most[0], int(float(re.search(r"^piad_memory_used_bytes (\S+)", text, re.M).group(1))))


def measured(program: str, path: str, media_type: str, body: bytes, coding: str) -> tuple[int, int, int]:
    """The status of the response, and the memory used and accounted for the body."""
    sent = body if coding == "identity" else zlib.compress(body, 1, zlib.MAX_WBITS | 16)
    with server(program) as (pid, port):
        ask(port, "GET", "/metrics")
        before = resident(pid, "VmRSS")
        most, ended = [0], threading.Event()
        watching = threading.Thread(target=accounted, args=(port, most, ended))
        watching.start()
        status, _ = ask(port, "POST", path, sent, media_type, coding)
        ended.set()
        watching.join()
        return status, resident(pid, "VmHWM") - before, most[0]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--megabytes", type=int, default=8)
    arguments = parser.parse_args()
    too_much = []
    print(f"{'list':26} {'status':>6} {'taken':>7} {'counted':>8} {'gzip':>7}    for each byte")
    for name, (path, media_type, body) in bodies(arguments.megabytes * 1_000_000).items():
        status, plain, counted = measured(arguments.program, path, media_type, body, "identity")
        _, packed, counted_packed = measured(arguments.program, path, media_type, body, "gzip")
        each = [taken / len(body) for taken in (plain, counted, packed)]
        print(f"{name:26} {status:6} {each[0]:7.1f} {each[1]:8.1f} {each[2]:7.1f}", flush=True)
        # Sampling from outside misses short peaks.
        least = COUNTED * len(body)
        if plain > max(counted, least) or packed > max(counted_packed, least):
            too_much.append(name)
    for name in too_much:
        print(f"more than it is accounted with: {name}")
    return 1 if too_much else 0


if __name__ == "__main__":
    sys.exit(main())

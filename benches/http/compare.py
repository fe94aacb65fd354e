"""End to end over HTTP: compares piad with the obvious alternative (fastapi_service.py), in one
run.

    compare.py PROGRAM [--quick]        # PROGRAM is target/release/piad

Small jobs: wrk posts a curve of 100 points, 50 iterations are streamed; jobs and events per second,
and those of two processes that send prepared responses. Large jobs: one client posts 1e4, 1e5, 1e6
points and reads 50 iterations; seconds, the transfer time of the request and response alone, and
peak memory; Bézier curves compared with the products of their matrix; the peak memory with several
clients; and a small job beside a large one. Needs wrk, and the packages of ../requirements.txt.
"""

import argparse
import json
import math
import multiprocessing
import os
import re
import selectors
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
PIAD, FASTAPI = 18480, 18490
ITERATIONS = 50
EVENTS = ITERATIONS + 3  # job, iterations 0 to 50, end


def job(count: int, **basis: str) -> bytes:
    """A rippled spiral in space, fitted by cubic B-splines by default."""
    def point(i: int) -> list[float]:
        t = 60.0 * i / count
        r = 1.0 + t / 10.0 + 0.05 * math.sin(20.0 * t)
        return [r * math.cos(t), r * math.sin(t), 0.3 * t]

    points = [point(i) for i in range(count)]
    stop = {"tolerance": 0, "max_iterations": ITERATIONS}
    return json.dumps({"curve": {"points": points, **basis}, "stop": stop}).encode()


def start(command: list[str], port: int) -> subprocess.Popen:
    process = subprocess.Popen(command, cwd=HERE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    for _ in range(200):
        try:
            socket.create_connection(("127.0.0.1", port), 0.1).close()
            return process
        except OSError:
            time.sleep(0.1)
    raise SystemExit(f"{command[0]} has not started")


def stop(process: subprocess.Popen) -> None:
    os.killpg(process.pid, signal.SIGTERM)
    process.wait()


def servers(program: str) -> dict[str, tuple[list[str], int, str]]:
    piad = [os.path.abspath(program), "--listen", f"127.0.0.1:{PIAD}", "--store", ":memory:", "--log", "warn", "--retain-jobs", "10"]
    fastapi = [sys.executable, "-m", "uvicorn", "fastapi_service:app", "--port", str(FASTAPI), "--workers", "2", "--log-level", "warning"]
    return {"piad": (piad, PIAD, "/v1/jobs"), "fastapi": (fastapi, FASTAPI, "/fit")}


def wrk(port: int, path: str, connections: int, seconds: int) -> str:
    """Posts jobs of 100 points and reads their events."""
    with tempfile.NamedTemporaryFile("w", suffix=".lua", delete=False) as script:
        script.write('wrk.method = "POST"\nwrk.headers["Content-Type"] = "application/json"\n')
        script.write('wrk.headers["Accept"] = "text/event-stream"\n')
        script.write(f"wrk.body = [==[{job(100).decode()}]==]\n")
    command = ["wrk", "-t1", "--latency", f"-c{connections}", f"-d{seconds}s", "--timeout", "60s", "-s", script.name, f"http://127.0.0.1:{port}{path}"]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    os.unlink(script.name)
    assert "Non-2xx" not in output, output
    return output


def rate(output: str) -> float:
    """Jobs per second."""
    return float(re.search(r"Requests/sec:\s+([\d.]+)", output).group(1))


def latency(output: str, percentile: int) -> float:
    """Milliseconds from the request to the end of the stream."""
    number, unit = re.search(rf"{percentile}%\s+([\d.]+)(us|ms|s)", output).groups()
    return float(number) * {"us": 1e-3, "ms": 1.0, "s": 1e3}[unit]


def read_all(port: int, path: str, body: bytes) -> tuple[float, float, int]:
    """Posts and reads everything; seconds to the first iteration and to the end, and bytes."""
    head = f"POST {path} HTTP/1.0\r\nHost: localhost\r\nContent-Type: application/json\r\nAccept: text/event-stream\r\nContent-Length: {len(body)}\r\n\r\n"
    request = head.encode() + body
    connection = socket.create_connection(("127.0.0.1", port))
    begin = time.perf_counter()
    connection.sendall(request)
    first, total = drain(connection, begin)
    return first, time.perf_counter() - begin, total


def read_events(port: int, path: str) -> int:
    """Reads all events of a job; the number of bytes."""
    connection = socket.create_connection(("127.0.0.1", port))
    connection.sendall(f"GET {path} HTTP/1.0\r\nHost: localhost\r\nAccept: text/event-stream\r\n\r\n".encode())
    return drain(connection, time.perf_counter())[1]


def drain(connection: socket.socket, begin: float) -> tuple[float, int]:
    """Seconds until the first iteration, and bytes."""
    buffer = bytearray(1 << 20)
    total, first, seen = 0, 0.0, b""
    while count := connection.recv_into(buffer):
        if not first:
            seen = seen[-32:] + bytes(buffer[:count])
            if b"event: iteration" in seen:
                first = time.perf_counter() - begin
        total += count
    return first, total


def connected(work: Callable[[tuple[str, int], int], None], size: int) -> tuple[socket.socket, multiprocessing.Process]:
    """A process that connects to this one and sends or receives this many bytes, and the
    connection."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        process = multiprocessing.Process(target=work, args=(listener.getsockname(), size))
        process.start()
        return listener.accept()[0], process


def alone(size: int) -> float:
    """Seconds for sending this many prepared bytes to the same client."""
    connection, sender = connected(send, size)
    begin = time.perf_counter()
    connection.sendall(b"!")
    _, received = drain(connection, begin)
    taken = time.perf_counter() - begin
    sender.join()
    assert received == size, (received, size)
    return taken


def send(address: tuple[str, int], size: int) -> None:
    """Sends on request: the start of the process is not measured."""
    block = b"event: iteration".ljust(1 << 17)
    connection = socket.create_connection(address)
    connection.recv(1)
    for start in range(0, size, len(block)):
        connection.sendall(block[: size - start])


def request_alone(body: bytes) -> float:
    """Seconds until a process has received such a request."""
    connection, receiver = connected(take, len(body))
    connection.recv(1)
    begin = time.perf_counter()
    connection.sendall(body)
    connection.recv(1)
    taken = time.perf_counter() - begin
    receiver.join()
    return taken


def take(address: tuple[str, int], size: int) -> None:
    """Signals that it is ready, and that it has all bytes."""
    connection, buffer = socket.create_connection(address), bytearray(1 << 20)
    connection.sendall(b"!")
    while size > 0:
        size -= connection.recv_into(buffer)
    connection.sendall(b"!")


def answer(port: int, path: str) -> bytes:
    """All bytes of the response to a job of 100 points."""
    body, received = job(100), b""
    head = f"POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nAccept: text/event-stream\r\nContent-Length: {len(body)}\r\n\r\n"
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.sendall(head.encode() + body)
        while not received.endswith(b"\r\n0\r\n\r\n"):
            received += connection.recv(1 << 20)
    return received


def rate_at_hand(content: bytes, connections: int, seconds: int) -> float:
    """Jobs per second of two processes that answer each of them with these bytes."""
    with socket.create_server(("127.0.0.1", 0), backlog=512) as listener:
        processes = [multiprocessing.Process(target=hand_out, args=(listener, content)) for _ in range(2)]
        for process in processes:
            process.start()
        port = listener.getsockname()[1]
        rates = [rate(wrk(port, "/", connections, seconds)) for _ in range(3)]
        for process in processes:
            process.kill()
            process.join()
    return statistics.median(rates)


def hand_out(listener: socket.socket, content: bytes) -> None:
    end = job(100)[-64:]
    listener.setblocking(False)
    ready = selectors.DefaultSelector()
    ready.register(listener, selectors.EVENT_READ)
    while True:
        for key, _ in ready.select():
            if key.fileobj is listener:
                try:
                    connection, _ = listener.accept()
                except BlockingIOError:  # The other process has it.
                    continue
                connection.setblocking(True)
                ready.register(connection, selectors.EVENT_READ)
                continue
            try:
                received = key.fileobj.recv(1 << 16)
                if received.endswith(end):
                    key.fileobj.sendall(content)
            except ConnectionError:  # wrk has ended.
                received = b""
            if not received:
                ready.unregister(key.fileobj)
                key.fileobj.close()


def peak(process: subprocess.Popen) -> int:
    with open(f"/proc/{process.pid}/status") as status:
        return int(re.search(r"VmHWM:\s+(\d+)", status.read()).group(1)) * 1024


def small(program: str, seconds: int) -> None:
    print(f"\n100 points, {ITERATIONS} iterations streamed\n")
    print("| connections | server | jobs/s | events/s | ratio |\n|---|---|---|---|---|")
    for connections in (1, 16, 256):
        rates = {}
        for name, query in [("fastapi", ""), ("piad", ""), ("piad", "?encoding=base64"), ("piad", "?view=errors")]:
            command, port, path = servers(program)[name]
            name, path = f"{name}{query}", f"{path}{query}"
            process = start(command, port)
            wrk(port, path, min(connections, 16), 1)
            # A server with many connections needs time to respond to all of them.
            time_each = max(seconds, connections // 16)
            rates[name] = statistics.median(rate(wrk(port, path, connections, time_each)) for _ in range(3))
            content = answer(port, path)
            stop(process)
            if name.startswith("piad"):
                rates[f"{name}, bytes at hand"] = rate_at_hand(content, connections, time_each)
        for name, jobs in rates.items():
            ratio = jobs / rates["fastapi"]
            print(f"| {connections} | {name} | {jobs:.0f} | {jobs * EVENTS:.0f} | {ratio:.1f}× |", flush=True)


def large(program: str, counts: list[int]) -> None:
    print(f"\none client, {ITERATIONS} iterations: seconds to the first and to the last of them, peak memory\n")
    print("| points | server | encoding | first, s | all, s | MB | these bytes alone, s | ratio | peak, bytes per point |\n|---|---|---|---|---|---|---|---|---|")
    for count in counts:
        body = job(count)
        taken = statistics.median(request_alone(body) for _ in range(5))
        print(f"| {count} | its request alone | | {taken:.4f} | | {len(body) / 1e6:.0f} | | | |")
        base = None
        for name, query in [("fastapi", ""), ("piad", ""), ("piad", "?digits=auto"), ("piad", "?encoding=base64"), ("piad", "?encoding=base64_f32")]:
            command, port, path = servers(program)[name]
            process = start(command, port)
            runs = [read_all(port, path + query, body) for _ in range(1 if count > 100_000 else 5)]
            first, total, size = sorted(runs, key=lambda run: run[1])[len(runs) // 2]
            base = base or total
            memory = f"{peak(process) / count:.0f}" if name == "piad" else ""
            stop(process)
            bare = statistics.median(alone(size) for _ in range(3))
            form = query.partition("?")[2] or "json"
            print(f"| {count} | {name} | {form} | {first:.3f} | {total:.3f} | {size / 1e6:.0f} | {bare:.3f} | {base / total:.1f}× | {memory} |", flush=True)


def bezier(program: str) -> None:
    """Compares Bézier curves with the minimum cost of a fit with a dense matrix: its products."""
    print(f"\nBézier curves, {ITERATIONS} iterations: ms, and beside as many products of a matrix of this size with its points by numpy\n")
    print("| degree | products alone | JSON | ratio | base64 | ratio |\n|---|---|---|---|---|---|")
    for degree in (100, 300, 1000):
        count = degree + 1
        random, body = np.random.default_rng(0), job(count, basis="bernstein")
        matrix, points = random.random((count, count)), random.random((count, 3))
        command, port, path = servers(program)["piad"]
        process = start(command, port)
        taken: dict[str, list[float]] = {"products": [], "": [], "?encoding=base64": []}
        for _ in range(11):
            begin = time.perf_counter()
            for _ in range(ITERATIONS):
                matrix @ points
            taken["products"].append(time.perf_counter() - begin)
            for query in ("", "?encoding=base64"):
                taken[query].append(read_all(port, path + query, body)[1])
        stop(process)
        products, *forms = (1e3 * statistics.median(seconds) for seconds in taken.values())
        cells = [f"{form:.1f} | {form / products:.1f}" for form in forms]
        print(f"| {degree} | {products:.1f} | {' | '.join(cells)} |", flush=True)


def readers(program: str, count: int) -> None:
    """Peak memory of one job that several clients read at the same time, each at its own pace."""
    print(f"\n{count} points, {ITERATIONS} iterations as JSON, read by several clients\n")
    print("| clients | all, s | peak, MB | of the points' own size |\n|---|---|---|---|")
    body = job(count)
    for clients in (1, 4, 16):
        command, port, path = servers(program)["piad"]
        process = start(command, port)
        begin = time.perf_counter()
        request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", body, {"Content-Type": "application/json"})
        with urllib.request.urlopen(request) as answer:
            events = json.load(answer)["links"]["events"]
        with ThreadPoolExecutor(clients) as pool:
            sizes = list(pool.map(lambda _: read_events(port, events), range(clients)))
        assert len(set(sizes)) == 1, sizes
        memory = peak(process)
        stop(process)
        print(f"| {clients} | {time.perf_counter() - begin:.1f} | {memory / 1e6:.0f} | {memory / (24 * count):.1f}× |", flush=True)


def beside(program: str, count: int, seconds: int) -> None:
    """A job of 100 points alone, and beside a large one that is being streamed."""
    command, port, path = servers(program)["piad"]
    process = start(command, port)
    wrk(port, path, 1, 1)
    alone = wrk(port, path, 1, seconds)
    body, over = job(count), threading.Event()

    def keep_busy() -> None:
        while not over.is_set():
            read_all(port, path, body)

    large = threading.Thread(target=keep_busy)
    large.start()
    time.sleep(1)
    together = wrk(port, path, 1, seconds)
    over.set()
    large.join()
    stop(process)
    print(f"\n100 points, {ITERATIONS} iterations, beside a job of {count} points: ms until all is read\n")
    print("| | alone | beside | ratio |\n|---|---|---|---|")
    for percentile in (50, 99):
        one, other = latency(alone, percentile), latency(together, percentile)
        print(f"| {percentile} % | {one:.2f} | {other:.2f} | {other / one:.1f}× |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--quick", action="store_true", help="shorter runs, no million points")
    given = parser.parse_args()
    small(given.program, 2 if given.quick else 5)
    large(given.program, [10_000, 100_000] if given.quick else [10_000, 100_000, 1_000_000])
    bezier(given.program)
    readers(given.program, 100_000 if given.quick else 1_000_000)
    beside(given.program, 100_000 if given.quick else 1_000_000, 3 if given.quick else 10)


if __name__ == "__main__":
    main()

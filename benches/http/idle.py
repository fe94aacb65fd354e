"""Measures the cost of connections: idle ones with TLS, and event streams with a distant next
iteration, on separate connections or a hundred per HTTP/2 connection.

    idle.py PROGRAM [--idle N] [--streams N] [--http2]      # PROGRAM is target/release/piad; needs openssl

Prints the memory of the server, and the time of /livez meanwhile. Each connection takes a file
descriptor on both sides (ulimit -n). --http2 needs the Python package h2.
"""

import argparse
import asyncio
import json
import os
import re
import resource
import ssl
import statistics
import subprocess
import tempfile
import threading
import time

AT_ONCE = 100
PROBES = 200
STREAMS_OF_ONE = 100

Connection = tuple[asyncio.StreamReader, asyncio.StreamWriter]


def memory(process: subprocess.Popen) -> float:
    """Resident memory in MB."""
    with open(f"/proc/{process.pid}/status") as file:
        [line] = [line for line in file if line.startswith("VmRSS")]
    return int(line.split()[1]) * 1024 / 1e6


async def many(count: int, make) -> list[Connection]:
    """Opens this many connections, in groups."""
    made: list[Connection] = []
    while len(made) < count:
        made += await asyncio.gather(*(make() for _ in range(min(AT_ONCE, count - len(made)))))
    return made


async def head(reader: asyncio.StreamReader) -> None:
    answer = await reader.readuntil(b"\r\n\r\n")
    assert answer.startswith(b"HTTP/1.1 20"), answer


async def streams_of_http2(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, path: str) -> None:
    """Starts the maximum number of streams of a connection, and waits for their response
    headers."""
    import h2.connection
    import h2.events

    connection = h2.connection.H2Connection()
    connection.initiate_connection()
    head = [(":method", "GET"), (":scheme", "https"), (":authority", "localhost"), (":path", path), ("accept", "text/event-stream")]
    for _ in range(STREAMS_OF_ONE):
        connection.send_headers(connection.get_next_available_stream_id(), head, end_stream=True)
    answered = 0
    while answered < STREAMS_OF_ONE:
        writer.write(connection.data_to_send())
        for event in connection.receive_data(await reader.read(1 << 16)):
            if isinstance(event, h2.events.ResponseReceived):
                assert dict(event.headers)[b":status"] == b"200", event
                answered += 1
            elif isinstance(event, h2.events.DataReceived):
                connection.acknowledge_received_data(event.flow_controlled_length, event.stream_id)
    writer.write(connection.data_to_send())


async def probes(connect) -> list[float]:
    seconds = []
    for _ in range(PROBES):
        begin = time.perf_counter()
        reader, writer = await connect()
        writer.write(b"GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        await reader.read()
        seconds.append(time.perf_counter() - begin)
        writer.close()
    return seconds


async def measure(server: subprocess.Popen, port: int, certificate: str, arguments: argparse.Namespace) -> None:
    trusted, multiplexed = (ssl.create_default_context(cafile=certificate) for _ in range(2))
    multiplexed.set_alpn_protocols(["h2"])

    async def connect() -> Connection:
        return await asyncio.open_connection("localhost", port, ssl=trusted)

    async def idle() -> Connection:
        reader, writer = await connect()
        writer.write(b"GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n")
        await head(reader)
        return reader, writer

    def quiet() -> str:
        # Only iterations that are far apart: only comments arrive.
        return f"{job['links']['events']}?view=errors&every=1000000000"

    async def stream() -> Connection:
        reader, writer = await connect()
        path = quiet()
        writer.write(f"GET {path} HTTP/1.1\r\nHost: localhost\r\nAccept: text/event-stream\r\n\r\n".encode())
        await head(reader)
        return reader, writer

    async def hundred() -> Connection:
        reader, writer = await asyncio.open_connection("localhost", port, ssl=multiplexed)
        await streams_of_http2(reader, writer, quiet())
        return reader, writer

    reader, writer = await connect()
    body = json.dumps({"curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3]]}, "stop": {"tolerance": 0, "max_iterations": 1_000_000_000}})
    writer.write(f"POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n{body}".encode())
    job = json.loads((await reader.read()).split(b"\r\n\r\n")[1])
    print("| connections | memory of the server | /livez, p50 | p99 |\n|---|---|---|---|")
    kept: list[Connection] = []
    streams = (arguments.streams // STREAMS_OF_ONE, hundred) if arguments.http2 else (arguments.streams, stream)
    for name, count, make in (("none", 0, idle), (f"{arguments.idle} idle", arguments.idle, idle), (f"and {arguments.streams} streams", *streams)):
        kept += await many(count, make)
        # Connections are closed after five seconds, and memory is released a little later.
        await asyncio.sleep(10)
        cuts = statistics.quantiles(await probes(connect), n=100)
        print(f"| {name} | {memory(server):.0f} MB | {1e3 * cuts[49]:.1f} ms | {1e3 * cuts[98]:.1f} ms |", flush=True)
    for _, writer in kept:
        writer.transport.abort()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--idle", type=int, default=10_000)
    parser.add_argument("--streams", type=int, default=5_000)
    parser.add_argument("--http2", action="store_true")
    arguments = parser.parse_args()
    if arguments.http2 and arguments.streams % STREAMS_OF_ONE:
        parser.error(f"--streams: with --http2 a multiple of {STREAMS_OF_ONE}")
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    with tempfile.TemporaryDirectory() as folder:
        certificate, key = os.path.join(folder, "cert.pem"), os.path.join(folder, "key.pem")
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-keyout", key, "-out", certificate,
                        "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"], check=True, capture_output=True)
        most = str(2 * (arguments.idle + arguments.streams))
        command = [arguments.program, "--listen", "127.0.0.1:0", "--store", ":memory:", "--tls-cert", certificate, "--tls-key", key, "--max-iterations", "1000000000",
                   "--idle-timeout", "3600", "--max-connections-per-peer", most, "--max-requests-per-peer", most]
        server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        assert server.stderr is not None
        port = next(int(found[1]) for line in server.stderr if (found := re.search(r"listening on https://[^ ]+:(\d+)", line)))
        # A full pipe would block the server.
        threading.Thread(target=server.stderr.read, daemon=True).start()
        try:
            asyncio.run(measure(server, port, certificate, arguments))
        finally:
            server.terminate()
            server.wait()


if __name__ == "__main__":
    main()

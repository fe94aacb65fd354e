"""Tests piad behind the proxies of docs/how-to/operate.md, as configured there: nginx, Caddy, Envoy.

    proxies.py PROGRAM            # the server to start, such as target/debug/piad

Events pass while their job is computed, jobs end with their client, large bodies and gRPC pass.
Needs the packages of requirements.txt, and Debian's nginx-light, caddy and openssl.
"""

import contextlib
import http.client
import json
import os
import pathlib
import re
import socket
import ssl
import subprocess
import sys
import tempfile
import time

import grpc
from caddyfile import of_debian
from grpc_health.v1 import health_pb2, health_pb2_grpc
from over_http import server

ROOT = pathlib.Path(__file__).resolve().parents[2]
OPERATIONS = ROOT / "docs/how-to/operate.md"
CADDYFILE = ROOT / "deploy" / "Caddyfile.tls"

# It runs until it is cancelled.
ENDLESS = {
    "curve": {"points": [[i % 7, i * i % 11, i] for i in range(200)]},
    "stop": {"tolerance": 0, "max_iterations": 1_000_000_000},
}


class Proxy:
    """The address of a proxy, and the file of its CA certificate, if it uses TLS."""

    def __init__(self, port: int, authority: pathlib.Path | None):
        self.port, self.authority = port, authority

    def connect(self) -> http.client.HTTPConnection:
        if self.authority is None:
            return http.client.HTTPConnection("localhost", self.port, timeout=60)
        context = ssl.create_default_context(cafile=self.authority)
        return http.client.HTTPSConnection("localhost", self.port, timeout=60, context=context)

    def channel(self) -> grpc.Channel:
        target = f"localhost:{self.port}"
        if self.authority is None:
            return grpc.insecure_channel(target)
        return grpc.secure_channel(target, grpc.ssl_channel_credentials(self.authority.read_bytes()))

    def ask(self, method: str, path: str, body: bytes | None = None, **headers: str) -> tuple[int, bytes]:
        with contextlib.closing(self.connect()) as connection:
            connection.request(method, path, body, {"Content-Type": "application/json", **headers})
            response = connection.getresponse()
            return response.status, response.read()

    def state(self, job: str) -> str:
        return json.loads(self.ask("GET", f"/v1/jobs/{job}")[1])["state"]


# The proxies


def free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


def snippet(language: str) -> str:
    """The block of the documentation in a language."""
    [block] = re.findall(rf"^```{language}\n(.*?)^```$", OPERATIONS.read_text(), re.MULTILINE | re.DOTALL)
    return block


def replaced(text: str, **places: tuple[str, str]) -> str:
    """Replaces addresses and files by those of this test."""
    for name, (old, new) in places.items():
        assert old in text, f"there is no {name}: {old}"
        text = text.replace(old, new)
    return text


@contextlib.contextmanager
def running(proxy: Proxy, folder: pathlib.Path, *command: str | pathlib.Path, **environment: str):
    """Runs a proxy that forwards requests."""
    log = folder / "log"
    with log.open("w") as file:
        process = subprocess.Popen(command, stdout=file, stderr=file, env=os.environ | environment)
    try:
        deadline = time.monotonic() + 120
        while not answers(proxy):
            if process.poll() is not None or time.monotonic() > deadline:
                raise SystemExit(f"{command[0]} has not started:\n{log.read_text()}")
            time.sleep(0.05)
        yield proxy
    finally:
        process.terminate()
        try:
            process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            # It waits for a stream.
            process.kill()
            process.wait()


def answers(proxy: Proxy) -> bool:
    # It may not listen yet, or have no certificate.
    with contextlib.suppress(OSError, http.client.HTTPException):
        return proxy.ask("GET", "/livez")[0] == 200
    return False


@contextlib.contextmanager
def nginx(upstream: str, folder: pathlib.Path):
    port, certificate, key = free_port(), folder / "certificate", folder / "key"
    request = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-subj", "/CN=localhost"]
    command = ["openssl", "req", "-x509", *request, "-addext", "subjectAltName=DNS:localhost"]
    subprocess.run([*command, "-keyout", key, "-out", certificate], check=True, capture_output=True)
    block = replaced(
        snippet("nginx"),
        port=("listen 443 ", f"listen 127.0.0.1:{port} "),
        certificate=("/etc/ssl/fit.example.org.pem", str(certificate)),
        key=("/etc/ssl/fit.example.org.key", str(key)),
        upstream=("127.0.0.1:8080", upstream),
    )
    temporary = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"]
    paths = "\n".join(f"{name}_temp_path {folder / name};" for name in temporary)
    configuration = folder / "nginx.conf"
    configuration.write_text(f"""
        daemon off;
        pid {folder / "pid"};
        error_log stderr;
        events {{}}
        http {{
            access_log off;
            {paths}
            {block}
        }}
    """)
    with running(Proxy(port, certificate), folder, "/usr/sbin/nginx", "-p", folder, "-c", configuration) as proxy:
        yield proxy


@contextlib.contextmanager
def caddy(upstream: str, folder: pathlib.Path):
    port = free_port()
    block = replaced(of_debian(CADDYFILE), upstream=("piad:8080", upstream))
    options = f"{{\n admin off\n skip_install_trust\n http_port {free_port()}\n default_bind 127.0.0.1\n}}\n"
    configuration = folder / "Caddyfile"
    configuration.write_text(options + block)
    command = ["caddy", "run", "--adapter", "caddyfile", "--config", configuration]
    environment = {"PIAD_DOMAIN": f"localhost:{port}", "XDG_DATA_HOME": str(folder), "XDG_CONFIG_HOME": str(folder)}
    authority = folder / "caddy/pki/authorities/local/root.crt"
    with running(Proxy(port, authority), folder, *command, **environment) as proxy:
        yield proxy


@contextlib.contextmanager
def envoy(upstream: str, folder: pathlib.Path):
    port, (_, behind) = free_port(), upstream.split(":")
    configuration = folder / "envoy.yaml"
    configuration.write_text(replaced(
        snippet("yaml"),
        address=("0.0.0.0", "127.0.0.1"),
        port=("port_value: 8443", f"port_value: {port}"),
        upstream=("port_value: 8080", f"port_value: {behind}"),
    ))
    command = [pathlib.Path(sys.executable).parent / "envoy", "--use-dynamic-base-id", "--concurrency", "1"]
    with running(Proxy(port, None), folder, *command, "--config-path", configuration) as proxy:
        yield proxy


# Requests that must pass


def event(stream: http.client.HTTPResponse) -> tuple[str, dict]:
    """The next event: its name and its data."""
    name = ""
    for line in stream:
        if line.startswith(b"event: "):
            name = line[7:].strip().decode()
        if line.startswith(b"data: "):
            return name, json.loads(line[6:])
    raise SystemExit("the stream ends in the middle")


def streams(proxy: Proxy) -> None:
    """The first iteration arrives while the job runs; then it is cancelled, and the stream ends."""
    with contextlib.closing(proxy.connect()) as connection:
        connection.request("POST", "/v1/jobs/stream?view=errors", json.dumps(ENDLESS), {"Content-Type": "application/json"})
        stream = connection.getresponse()
        name, job = event(stream)
        assert name == "job", name
        name, iteration = event(stream)
        assert (name, iteration["iteration"]) == ("iteration", 0), name
        assert proxy.state(job["id"]) == "running"
        assert proxy.ask("POST", f"/v1/jobs/{job['id']}/cancel")[0] == 200
        while name != "end":
            name, end = event(stream)
        assert end["state"] == "cancelled", end


def quiet_streams(proxy: Proxy) -> None:
    """The first iteration is not delayed, for each kind of stream."""
    for kind in ("text/event-stream", "application/x-ndjson"):
        with contextlib.closing(proxy.connect()) as connection:
            headers = {"Content-Type": "application/json", "Accept": kind}
            connection.request("POST", "/v1/jobs?view=errors&every=1000000000", json.dumps(ENDLESS), headers)
            stream = connection.getresponse()
            assert stream.getheader("Content-Type").startswith(kind), stream.getheader("Content-Type")
            lines = (line for line in stream if b'"iteration":0' in line)
            assert next(lines)
            job = stream.getheader("Location").rpartition("/")[2]
            assert proxy.state(job) == "running"
            proxy.ask("DELETE", f"/v1/jobs/{job}")


def jobs_end_with_their_client(proxy: Proxy) -> None:
    """The server notices that a client disconnects, although nothing is sent."""
    connection = proxy.connect()
    path = "/v1/jobs/stream?view=errors&every=1000000000&on_disconnect=cancel"
    connection.request("POST", path, json.dumps(ENDLESS), {"Content-Type": "application/json"})
    stream = connection.getresponse()
    (_, job), _ = event(stream), event(stream)
    stream.close()
    connection.close()
    deadline = time.monotonic() + 120
    while proxy.state(job["id"]) != "cancelled":
        assert time.monotonic() < deadline, "the job continues without its client"
        time.sleep(0.05)


def large_bodies(proxy: Proxy) -> None:
    job = {"curve": {"points": [[0, 0], [1, 2], [3, 1], [4, 3]]}}
    status, answer = proxy.ask("POST", "/v1/jobs", json.dumps(job).encode() + b" " * 3_000_000, Prefer="wait=60")
    assert status == 201 and json.loads(answer)["state"] == "converged", answer


def the_page(proxy: Proxy) -> None:
    status, page = proxy.ask("GET", "/", Accept="text/html")
    assert status == 200 and b"<html" in page, status


def no_metrics(proxy: Proxy) -> None:
    """The proxy blocks the metrics, also below a base path."""
    for path in ("/metrics", "/fits/metrics", "/metrics?a=b"):
        status, body = proxy.ask("GET", path)
        assert status == 404 and b"/problems/" not in body, (path, status, body)


def calls(proxy: Proxy) -> None:
    """gRPC."""
    with proxy.channel() as channel:
        health = health_pb2_grpc.HealthStub(channel)
        request = health_pb2.HealthCheckRequest(service="piad.v1.FittingService")
        assert health.Check(request, timeout=60).status == health_pb2.HealthCheckResponse.SERVING


# Without its buffer Caddy loses one of thirty streams.
ROUNDS = 20


def main() -> None:
    # No comment makes the server notice the disconnection.
    flags = ["--max-iterations", "1000000000", "--trusted-proxy", "127.0.0.0/8", "--heartbeat", "3600"]
    with server(sys.argv[1], *flags) as base:
        upstream = base.removeprefix("http://")
        for proxy in (nginx, caddy, envoy):
            with tempfile.TemporaryDirectory() as folder, proxy(upstream, pathlib.Path(folder)) as address:
                for check in (the_page, *ROUNDS * (streams, quiet_streams, jobs_end_with_their_client), large_bodies, no_metrics, calls):
                    try:
                        check(address)
                    except (Exception, SystemExit) as error:
                        raise SystemExit(f"{proxy.__name__}, {check.__name__}: {error!r}") from error
                print(f"{proxy.__name__}: events, bodies and calls come through")


if __name__ == "__main__":
    main()

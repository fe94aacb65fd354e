"""Tests an image: it is small, runs as any user with only /data writable, and keeps its jobs.

    image.py [NAME]                 # piad, as deploy/image builds it; needs buildah, and podman or chroot
"""

import contextlib
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
import zlib

NAME = sys.argv[1] if len(sys.argv) > 1 else "piad"
USER = 12345
MOST_BYTES = 25_000_000
TIMEOUT = 60


def run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, f"{' '.join(command)}: {done.stderr}"
    return done.stdout.strip()


@contextlib.contextmanager
def files():
    """The root of the image."""
    container = run("buildah", "from", f"localhost/{NAME}")
    try:
        yield run("buildah", "mount", container)
    finally:
        run("buildah", "rm", container)


def free_port() -> int:
    with socket.socket() as it:
        it.bind(("127.0.0.1", 0))
        return it.getsockname()[1]


class Container:
    """Runs a container of the image with podman if possible, otherwise its program in a chroot."""

    def __init__(self, root: str, data: str, with_podman: bool):
        self.address = f"http://127.0.0.1:{free_port()}"
        listen = self.address.removeprefix("http://")
        if with_podman:
            self.command = ["podman", "run", "--rm", "--network=host", "--cgroups=disabled", "--read-only", "--read-only-tmpfs=false",
                            f"--user={USER}", f"--volume={data}:/data", f"--env=PIAD_LISTEN={listen}", f"localhost/{NAME}"]
        else:
            self.command = ["env", "-i", f"PIAD_LISTEN={listen}", "PIAD_STORE=/data",
                            shutil.which("chroot") or "/usr/sbin/chroot", f"--userspec={USER}:{USER}", root, "/piad"]
        self.process = subprocess.Popen(self.command)

    def fetch(self, path: str, body: bytes | None = None, **headers: str):
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        request = urllib.request.Request(self.address + path, body, {"content-type": "application/json", **headers})
        return urllib.request.urlopen(request, timeout=TIMEOUT)

    def wait_until_ready(self) -> None:
        end = time.monotonic() + TIMEOUT
        while True:
            assert self.process.poll() is None, f"it has ended: {self.command}"
            try:
                with self.fetch("/readyz"):
                    return
            except OSError:
                assert time.monotonic() < end, "it does not answer"
                time.sleep(0.05)

    def stop(self) -> None:
        self.process.send_signal(signal.SIGTERM)
        assert self.process.wait(TIMEOUT) == 0, "SIGTERM is an orderly stop"


def podman_works() -> bool:
    command = ["podman", "run", "--rm", "--network=host", "--cgroups=disabled", f"localhost/{NAME}", "--version"]
    return shutil.which("podman") is not None and subprocess.run(command, capture_output=True).returncode == 0


def check_files(root: str) -> None:
    found = sorted(os.path.relpath(os.path.join(folder, name), root) for folder, _, names in os.walk(root) for name in names)
    assert found == ["etc/ssl/certs/ca-certificates.crt", "piad"], found
    size = sum(os.path.getsize(os.path.join(root, name)) for name in found)
    assert size <= MOST_BYTES, f"{size} bytes"
    # The list of crates, which cargo auditable has written.
    section = os.path.join(tempfile.gettempdir(), f"crates-{os.getpid()}")
    run("objcopy", "--dump-section", f".dep-v0={section}", os.path.join(root, "piad"), os.devnull)
    with open(section, "rb") as file:
        crates = json.loads(zlib.decompress(file.read()))["packages"]
    os.remove(section)
    assert {"piad", "axum", "redb"} <= {crate["name"] for crate in crates}, crates
    print(f"{size / 1e6:.1f} MB; {len(crates)} crates are listed in the program")


def check_config() -> None:
    config = json.loads(run("buildah", "inspect", "--type", "image", f"localhost/{NAME}"))["Docker"]["config"]
    assert config["User"] == "65532:65532" and config["StopSignal"] == "SIGTERM", config
    assert config["Healthcheck"]["Test"] == ["CMD", "/piad", "health"], config
    assert "/data" in config["Volumes"] and "8080/tcp" in config["ExposedPorts"], config
    labels = config["Labels"]
    assert re.fullmatch(r"\d+\.\d+\.\d+", labels["org.opencontainers.image.version"]), labels
    assert labels["org.opencontainers.image.licenses"] == "MIT OR Apache-2.0", labels


def check_service(root: str, with_podman: bool) -> None:
    """Streams a job; stops and restarts with the same data."""
    job = json.dumps({"curve": {"points": [[i, i * i % 7] for i in range(50)]}}).encode()
    # In a chroot, the data are below the root of the image.
    data = tempfile.mkdtemp() if with_podman else os.path.join(root, "data")
    os.chown(data, USER, USER)
    server = Container(root, data, with_podman)
    server.wait_until_ready()
    health = ["env", "-i", f"PIAD_LISTEN={server.address.removeprefix('http://')}", os.path.join(root, "piad"), "health"]
    run(*health)
    with server.fetch("/v1/jobs", job, accept="text/event-stream") as answer:
        story = answer.read().decode()
    assert story.count("event: iteration") > 2 and '"state":"converged"' in story, story[-500:]
    server.stop()
    server = Container(root, data, with_podman)
    server.wait_until_ready()
    with server.fetch("/v1/jobs") as answer:
        jobs = json.load(answer)["jobs"]
    assert [job["state"] for job in jobs] == ["converged"], jobs
    server.stop()
    owners = {os.stat(os.path.join(data, name)).st_uid for name in os.listdir(data)}
    assert owners == {USER}, owners


def main() -> None:
    with files() as root:
        check_files(root)
        check_config()
        with_podman = podman_works()
        print(f"started by {'podman' if with_podman else 'chroot, as podman does not work here'}")
        check_service(root, with_podman)
    print("the image works")


main()

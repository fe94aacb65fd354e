"""Real servers on free ports."""

from __future__ import annotations

import os
import re
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import piad

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = os.environ.get("PIAD_PROGRAM", str(ROOT / "target" / "debug" / "piad"))


class Server:
    """A server that can be killed and restarted with the same data at the same address."""

    def __init__(self, store: str, *flags: str, token: str = ""):
        self._store, self._flags = store, flags
        self._environment = {**os.environ, "PIAD_TOKEN": token}
        self.address = "127.0.0.1:0"
        self.start()

    @property
    def url(self) -> str:
        return f"http://{self.address}"

    def start(self) -> None:
        command = [PROGRAM, "--listen", self.address, "--store", self._store, "--log-format", "json"]
        self._process = subprocess.Popen(
            [*command, *self._flags], stderr=subprocess.PIPE, text=True, env=self._environment
        )
        assert self._process.stderr is not None
        for line in self._process.stderr:
            found = re.search(r"listening on https?://([^\s\"]+)", line)
            if found:
                self.address = found.group(1)
                # A full pipe would block the server.
                threading.Thread(target=self._process.stderr.read, daemon=True).start()
                return
        raise AssertionError(f"{PROGRAM} has not started")

    def kill(self) -> None:
        """Sends SIGKILL: connections are not closed cleanly."""
        self._process.kill()
        self._process.wait()


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    server = Server(":memory:")
    yield server
    server.kill()


@pytest.fixture
def client(server: Server) -> Iterator[piad.Client]:
    with piad.Client(server.url) as client:
        yield client


@pytest.fixture
def durable_server(tmp_path: Path) -> Iterator[Server]:
    server = Server(str(tmp_path / "data"))
    yield server
    server.kill()

"""A server of this process, for fits without the URL of one.

It listens on a Unix domain socket that only this user reaches, keeps its jobs in memory, and ends with the process: it
watches a pipe to its standard input, which the operating system closes when the process ends in any way.
"""

from __future__ import annotations

import atexit
import os
import secrets
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Optional

from ._program import find_program
from .errors import ServerNotStarted

# Seconds within which a server must listen. It takes some hundredths of a second on a quiet machine.
_START = 30.0

# Settings of servers that hold for this one, too. Others, such as tokens or addresses, are those of other servers.
_SHARED_SETTINGS = ("PIAD_MEMORY", "PIAD_WORKERS", "PIAD_MAX_BODY", "PIAD_MAX_POINTS", "PIAD_MAX_ITERATIONS")

# Paths of sockets are at most 103 bytes long on macOS, 107 on Linux.
_LONGEST_PATH = 103


class LocalServer:
    """A server that is a child of this process."""

    def __init__(self) -> None:
        if not hasattr(socket, "AF_UNIX") or os.name == "nt":
            raise ServerNotStarted(
                "servers on Unix domain sockets are not supported on this system: start `piad`, and give its URL, as url=… or in PIAD_URL"
            )
        self._folder = _new_folder()
        self.socket = str(self._folder / "piad.sock")
        """The path of its socket."""
        program = find_program()
        command = [program, "serve", "--listen", f"unix:{self.socket}", "--store", ":memory:", "--log", "warn"]
        command += ["--exit-with-stdin", "--grace", "0", "--retain-bytes", "256MiB"]
        with tempfile.TemporaryFile() as log:
            try:
                # In a session of its own it gets no Ctrl-C of the terminal, which interrupts the fit alone.
                self._process = subprocess.Popen(
                    command,
                    stdin=subprocess.PIPE,
                    stdout=subprocess.DEVNULL,
                    stderr=log,
                    env=_environment(),
                    start_new_session=True,
                )
            except OSError as error:
                raise ServerNotStarted(f"{program} cannot be started: {error}") from error
            try:
                self._wait(program, log.fileno())
            except BaseException:
                self.stop()
                raise

    def _wait(self, program: str, log: int) -> None:
        """Waits until it listens."""
        end = time.monotonic() + _START
        while not _listens(self.socket):
            if self._process.poll() is not None or time.monotonic() > end:
                said = os.pread(log, 4096, 0).decode(errors="replace").strip()
                raise ServerNotStarted(f"{program} has not started a server: {said}")
            time.sleep(0.002)

    @property
    def runs(self) -> bool:
        """True until it ends."""
        return self._process.poll() is None

    def stop(self) -> None:
        """Ends it at once: its jobs are not kept."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        self._process.kill()
        self._process.wait()
        Path(self.socket).unlink(missing_ok=True)
        if self._folder.exists():
            self._folder.rmdir()

    def leave(self) -> None:
        """Leaves it to the parent of this process, which has been forked."""
        if self._process.stdin is not None:
            self._process.stdin.close()
        # It is no child of this process, which must not wait for it.
        self._process.returncode = 0


def _listens(path: str) -> bool:
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.connect(path)
        except OSError:
            return False
        return True


def _new_folder() -> Path:
    """A path where nothing is. The server makes the folder, for this user alone, and removes it."""
    name = f"piad-{secrets.token_hex(8)}"
    folder = Path(tempfile.gettempdir()) / name
    is_long = len(os.fsencode(folder / "piad.sock")) > _LONGEST_PATH
    return Path("/tmp") / name if is_long else folder


def _environment() -> dict[str, str]:
    of_servers = ("PIAD_", "OTEL_")
    return {name: value for name, value in os.environ.items() if name in _SHARED_SETTINGS or not name.startswith(of_servers)}


_lock = threading.Lock()
_server: Optional[LocalServer] = None


def local_socket() -> str:
    """The path of the socket of the server of this process, which is started if none runs."""
    global _server
    with _lock:
        if _server is None or not _server.runs:
            if _server is not None:
                _server.stop()
            _server = None
            _server = LocalServer()
        return _server.socket


def _stop() -> None:
    global _server
    if _server is not None:
        _server.stop()
        _server = None


def _forked() -> None:
    """In a forked process: the server is that of its parent, and the lock may be held by a thread that is not here."""
    global _lock, _server
    _lock = threading.Lock()
    if _server is not None:
        _server.leave()
        _server = None


atexit.register(_stop)
if sys.platform != "win32":
    os.register_at_fork(after_in_child=_forked)

"""The server: the one of the preferences, or a program started on a free port."""

from __future__ import annotations

import atexit
import importlib.util
import os
import shutil
import subprocess
import sys
import threading
import time
from types import ModuleType
from typing import Any

import FreeCAD

translate = FreeCAD.Qt.translate

PREFERENCES = "User parameter:BaseApp/Preferences/Mod/piad"

# A missing server is detected after one retry, about three seconds.
_ATTEMPTS = 2

# Seconds within which a started program must listen.
_START = 10.0


class ServerError(Exception):
    """No server, with a message for the user."""


def piad() -> ModuleType:
    """Imports the client. A package has it next to the workbench, a copy of the repository in
    clients/python."""
    source = os.path.join(os.path.realpath(__file__).rsplit(os.sep, 4)[0], "python", "src")
    if importlib.util.find_spec("piad") is None and os.path.isdir(source):
        sys.path.append(source)
    try:
        return importlib.import_module("piad")
    except ImportError as error:
        text = translate("piad", "The workbench needs the Python package {}: install it for FreeCAD's Python.")
        raise ServerError(text.format(error.name)) from error


def client(headers: dict[str, str] | None = None) -> Any:
    """A client of the server, which is started if necessary."""
    url, token = _address()
    try:
        return piad().Client(url, attempts=_ATTEMPTS, token=token, headers=headers)
    except ValueError as error:
        raise ServerError(translate("piad", "The server in the preferences: {}").format(error)) from error


def _address() -> tuple[str, str | None]:
    preferences = FreeCAD.ParamGet(PREFERENCES)
    address = preferences.GetString("Server").strip()
    if address:
        return address, preferences.GetString("Token").strip() or None
    return _OWN.address(preferences.GetString("Program").strip()), None


class _Program:
    """The server of this workbench: one for all documents, from the first fit until FreeCAD
    exits."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: Any = None
        self._address = ""

    def address(self, program: str) -> str:
        """Its address. Starts the program, or the one of this name in the path, if it is not
        running."""
        with self._lock:
            if self._process is None or self._process.poll() is not None:
                self._address = self._start(program or "piad")
            return self._address

    def _start(self, program: str) -> str:
        path = shutil.which(program)
        if path is None:
            text = translate("piad", "There is no program {!r}: install piad, or set its path or the address of a server in the preferences (piad).")
            raise ServerError(text.format(program))
        command = [path, "--listen", "127.0.0.1:0", "--store", ":memory:"]
        try:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        except OSError as error:
            raise ServerError(f"{path}: {error.strerror}") from error
        log = _Log(process.stderr)
        deadline = time.monotonic() + _START
        while log.address is None and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        if log.address is None:
            process.kill()
            text = translate("piad", "{} did not start: {}")
            raise ServerError(text.format(path, log.last or translate("piad", "it is not listening")))
        self._process = process
        return log.address

    def stop(self) -> None:
        """Stops it, if it is running."""
        with self._lock:
            if self._process is not None and self._process.poll() is None:
                self._process.terminate()
                self._process.wait()


class _Log:
    """Reads the log of a program to its end: a full pipe would block it."""

    def __init__(self, stream: Any):
        self.address: str | None = None
        self.last = ""
        threading.Thread(target=self._read, args=(stream,), daemon=True).start()

    def _read(self, stream: Any) -> None:
        for line in stream:
            self.last = line.strip() or self.last
            if self.address is None and "listening on http" in line:
                self.address = "http" + line.split("listening on http", 1)[1].split()[0]


_OWN = _Program()
atexit.register(_OWN.stop)


def in_words(error: Exception) -> str:
    """The message of an error, with the fields that the server names."""
    problem = getattr(error, "problem", None)
    if problem is not None:
        lines = [f"{it.pointer or it.parameter}: {it.detail}" if it.pointer or it.parameter else it.detail for it in problem.errors]
        return "\n".join(lines or [problem.detail or problem.title])
    return str(error) or type(error).__name__

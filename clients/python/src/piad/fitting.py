"""Fits in one call: `fit`, `fit_file` and `read`, at a server of this process or at another one."""

from __future__ import annotations

import atexit
import os
import threading
from os import PathLike
from typing import TYPE_CHECKING, Any, Optional, Union

from ._place import Place, place
from ._settings import FileSettings, PointSettings, Settings, check_names, spelled_out
from .client import Client
from .iteration import Result
from .points import FilePoints

if TYPE_CHECKING:
    from typing_extensions import Unpack


@spelled_out(Settings)
def fit(points: Any, *, url: Optional[str] = None, timeout: Optional[float] = None, **settings: Unpack[Settings]) -> Result:
    """Fits a curve or a surface to points: `piad.fit(points, tolerance=0.01, control_points="auto")`.

    `points` of a curve have the shape (n, dimension), of a surface (rows, columns, dimension); `Client.create` describes
    the settings. Waits at most `timeout` seconds. A fit that has not reached its tolerance also returns a result, with
    the warning `NotConverged`.

    `url` is that of a server, by default the one in the variable PIAD_URL; the token for it is in PIAD_TOKEN. Without
    a URL a server is started for this process, which all fits share and which ends with the process.
    """
    check_names(fit, settings, Settings)
    return _client(url).fit(points, timeout=timeout, **settings)


@spelled_out(FileSettings)
def fit_file(
    file: Union[str, bytes, PathLike[str]],
    /,
    *,
    url: Optional[str] = None,
    timeout: Optional[float] = None,
    **settings: Unpack[FileSettings],
) -> Result:
    """Fits a curve or a surface to the points of a file. See `read` for reading and `fit` for the other settings."""
    check_names(fit_file, settings, FileSettings)
    return _client(url).fit_file(file, timeout=timeout, **settings)


@spelled_out(PointSettings)
def read(
    file: Union[str, bytes, PathLike[str]], /, *, url: Optional[str] = None, **settings: Unpack[PointSettings]
) -> FilePoints:
    """Reads the points of a file, with notes about how it was read: `Client.read_points` at the server of `fit`."""
    check_names(read, settings, PointSettings)
    return _client(url).read_points(file, **settings)


_lock = threading.Lock()
_clients: dict[Place, Client] = {}


def _client(url: Optional[str]) -> Client:
    """The client of this process for a server."""
    wanted = place(url, os.environ.get("PIAD_TOKEN") if url else None)
    with _lock:
        if wanted not in _clients:
            _clients[wanted] = Client(url, token=wanted.token)
        return _clients[wanted]


def _close() -> None:
    for client in _clients.values():
        client.close()
    _clients.clear()


def _forked() -> None:
    """In a forked process, which must not use the connections of its parent."""
    global _lock
    _lock = threading.Lock()
    _clients.clear()


atexit.register(_close)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)

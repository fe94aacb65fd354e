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
    """The curve or the surface of these points: `piad.fit(points, tolerance=0.01, control_points="auto")`.

    `points` of a curve have the shape (n, dimension), of a surface (rows, columns, dimension); `Client.create` says
    what the settings mean. Waits for the end, `timeout` seconds at most. A fit that has not reached its tolerance is
    a result, too, with the warning `NotConverged`.

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
    """The curve or the surface of the points of a file. `read` says how it is read, `fit` what the rest means."""
    check_names(fit_file, settings, FileSettings)
    return _client(url).fit_file(file, timeout=timeout, **settings)


@spelled_out(PointSettings)
def read(
    file: Union[str, bytes, PathLike[str]], /, *, url: Optional[str] = None, **settings: Unpack[PointSettings]
) -> FilePoints:
    """The points of a file, and what was found out about it: `Client.read_points`, at the server that `fit` uses."""
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

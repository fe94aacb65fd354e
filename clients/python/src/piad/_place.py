"""Which server a client uses."""

from __future__ import annotations

import os
from typing import NamedTuple, Optional

from ._local import local_socket


class Place(NamedTuple):
    """A server."""

    url: str
    token: Optional[str] = None
    socket: Optional[str] = None
    """The path of its Unix domain socket, if it has one."""


def place(url: Optional[str], token: Optional[str], *, has_transport: bool = False) -> Place:
    """The server at this URL, or at that in PIAD_URL (with the token in PIAD_TOKEN), or one of this process.

    A transport that is given reaches a server by itself.
    """
    if url is not None:
        return Place(url, token)
    url = os.environ.get("PIAD_URL")
    if url:
        return Place(url, token or os.environ.get("PIAD_TOKEN") or None)
    if has_transport:
        return Place("http://localhost", token)
    return Place("http://localhost", token, local_socket())

"""The client for programs with an event loop."""

from __future__ import annotations

from collections.abc import Mapping
from types import TracebackType
from typing import Optional

import httpx

from ._connections import AsyncConnections
from ._place import place
from ._service import Service
from ._transport import Transport, settings


class AsyncClient(Service):
    """A connection to a server, to be closed at the end; an asynchronous context manager does that.

    It is `Client` with methods to be awaited, for one event loop of asyncio. A task that is
    cancelled closes the connection that it waits for; jobs go on.
    """

    def __init__(
        self,
        base_url: Optional[str] = None,
        *,
        timeout: float = 60.0,
        attempts: int = 8,
        token: Optional[str] = None,
        headers: Optional[Mapping[str, str]] = None,
        transport: Optional[httpx.AsyncBaseTransport] = None,
    ):
        """The arguments are those of `Client`."""
        where = place(base_url, token, has_transport=transport is not None)
        connections = AsyncConnections(transport, where.socket, **settings(where.url, timeout, where.token, headers))
        super().__init__(Transport(connections, attempts=attempts), timeout)

    async def __aenter__(self) -> AsyncClient:
        return self

    async def __aexit__(
        self,
        kind: Optional[type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        await self.close()

"""The client for asyncio."""

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
    """A connection to a server, which must be closed; use it as an asynchronous context manager.

    It has the methods of `Client` as coroutines, for one event loop. A cancelled task closes its connection; jobs
    continue.
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
        """Takes the arguments of `Client`."""
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

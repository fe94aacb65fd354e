"""Connections to a server: asynchronous and blocking.

The client is implemented once, as coroutines. Over blocking connections they never suspend, so `_blocking.run` runs
them in one step.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from typing import Any, Optional, Protocol, Union

import httpx

# Each open stream holds a connection; the number of streams is limited by the server.
_LIMITS = httpx.Limits(max_connections=None, max_keepalive_connections=100)


class Connections(Protocol):
    """The interface of connections. `http` builds requests; responses of `stream` are read by `read` or `chunks` and
    then released.
    """

    blocks: bool
    """True if coroutines never wait for an event loop."""

    @property
    def http(self) -> Union[httpx.Client, httpx.AsyncClient]: ...
    async def send(self, request: httpx.Request, *, stream: bool = False) -> httpx.Response: ...
    async def read(self, response: httpx.Response) -> None: ...
    def chunks(self, response: httpx.Response) -> AsyncIterator[bytes]: ...
    async def release(self, response: httpx.Response) -> None: ...
    async def sleep(self, seconds: float) -> None: ...
    async def close(self) -> None: ...


class AsyncConnections:
    """Connections of the running event loop."""

    blocks = False

    def __init__(self, transport: Optional[httpx.AsyncBaseTransport], socket: Optional[str], **more: Any):
        if transport is None and socket is not None:
            transport = httpx.AsyncHTTPTransport(uds=socket, limits=_LIMITS)
        self.http = httpx.AsyncClient(transport=transport, limits=_LIMITS, **more)

    async def send(self, request: httpx.Request, *, stream: bool = False) -> httpx.Response:
        return await self.http.send(request, stream=stream)

    async def read(self, response: httpx.Response) -> None:
        await response.aread()

    def chunks(self, response: httpx.Response) -> AsyncIterator[bytes]:
        return response.aiter_bytes()

    async def release(self, response: httpx.Response) -> None:
        await response.aclose()

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds)

    async def close(self) -> None:
        await self.http.aclose()


class BlockingConnections:
    """Blocking connections. None of the coroutines ever suspends."""

    blocks = True

    def __init__(self, transport: Optional[httpx.BaseTransport], socket: Optional[str], **more: Any):
        if transport is None and socket is not None:
            transport = httpx.HTTPTransport(uds=socket, limits=_LIMITS)
        self.http = httpx.Client(transport=transport, limits=_LIMITS, **more)

    async def send(self, request: httpx.Request, *, stream: bool = False) -> httpx.Response:
        return self.http.send(request, stream=stream)

    async def read(self, response: httpx.Response) -> None:
        response.read()

    async def chunks(self, response: httpx.Response) -> AsyncIterator[bytes]:
        for chunk in response.iter_bytes():
            yield chunk

    async def release(self, response: httpx.Response) -> None:
        response.close()

    async def sleep(self, seconds: float) -> None:
        time.sleep(seconds)

    async def close(self) -> None:
        self.http.close()

"""Connections to a server: those of an event loop, and those that block a thread.

All that the client does is written once, in coroutines. Over connections that block they never wait for an event loop,
so that `_blocking.run` goes through them in one step.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from typing import Any, Optional, Protocol, Union

import httpx

# Each open stream holds a connection; the server says how many streams it takes.
_LIMITS = httpx.Limits(max_connections=None, max_keepalive_connections=100)


class Connections(Protocol):
    """What the client needs of connections. `http` builds requests; responses of `stream` are read by `read` or
    `chunks`, and released.
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
    """Those of the event loop that runs."""

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
    """Those of threads. None of the coroutines is ever suspended."""

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

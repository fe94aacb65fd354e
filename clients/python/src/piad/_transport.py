"""Requests with retries; responses as JSON or exceptions."""

from __future__ import annotations

import json
import math
import time
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager
from typing import Any, Optional, Union

import httpx

from ._backoff import delay, retry_after
from ._connections import Connections
from .errors import ApiError, ConnectionLost, PiadError, Problem, ProtocolError

# Too many requests, and the statuses of overloaded servers and proxies.
_TRY_AGAIN = frozenset({429, 502, 503, 504})

# Servers send a comment every 15 seconds.
_QUIET_STREAM = 60.0

# Connection timeout in seconds for a server that has never responded. One that has responded may be restarting and is
# retried for longer.
_FIRST_CONTACT = 1.5

# Nothing was sent.
_UNREACHABLE = (httpx.ConnectError, httpx.ConnectTimeout)

# Errors of the client, which a retry does not fix.
_HOPELESS = (httpx.UnsupportedProtocol, httpx.LocalProtocolError)

Parameters = Mapping[str, str]


def settings(base_url: str, timeout: float, token: Optional[str], headers: Optional[Mapping[str, str]]) -> dict[str, Any]:
    """Arguments of httpx clients."""
    if token is not None:
        headers = {**(headers or {}), "Authorization": f"Bearer {token}"}
    limits = httpx.Timeout(timeout, connect=min(timeout, _FIRST_CONTACT))
    return {"base_url": server_url(base_url), "timeout": limits, "headers": headers}


class Transport:
    """Requests to one server.

    Each request may be sent more than once: those that create something have a key by which the server recognises them.
    """

    def __init__(self, connections: Connections, *, attempts: int):
        if attempts < 1:
            raise ValueError("there is one attempt at least")
        self._connections = connections
        self._has_answered = False
        self.attempts = attempts
        """The maximum number of attempts."""

    @property
    def blocks(self) -> bool:
        """True if coroutines that make requests never wait for an event loop."""
        return self._connections.blocks

    async def close(self) -> None:
        """Closes all connections."""
        await self._connections.close()

    async def sleep(self, seconds: float) -> None:
        """Waits before a retry."""
        await self._connections.sleep(seconds)

    async def request(
        self,
        method: str,
        path: str,
        *,
        body: Optional[Mapping[str, Any]] = None,
        text: Union[str, bytes, None] = None,
        headers: Optional[Mapping[str, str]] = None,
        parameters: Optional[Parameters] = None,
    ) -> httpx.Response:
        """Returns a successful response. The path may contain a query. `body` is sent as JSON, `text` unchanged."""
        content = text if body is None else encoded(body)
        sent = {"Accept": "application/json", **(headers or {})}
        if content is not None:
            plain = "text/plain" if isinstance(text, str) else "application/octet-stream"
            sent["Content-Type"] = plain if body is None else "application/json"
        http = self._connections.http
        request = http.build_request(method, path, content=content, headers=sent, params=parameters or None)
        started = time.monotonic()
        for attempt in range(1, self.attempts + 1):
            last = attempt == self.attempts
            try:
                response = await self._connections.send(request)
            except httpx.TransportError as error:
                pause = delay(attempt)
                if last or self.is_hopeless(error, time.monotonic() + pause - started):
                    raise self.lost(error) from error
                await self.sleep(pause)
                continue
            self._has_answered = True
            if response.is_success:
                return response
            error_ = api_error(response)
            # The response to an earlier attempt was lost: the job is already deleted.
            if method == "DELETE" and response.status_code == 404 and attempt > 1:
                return response
            if last or not may_try_again(error_):
                raise error_
            await self.sleep(delay(attempt) if error_.retry_after is None else error_.retry_after)
        raise AssertionError("there is one attempt at least")

    async def json(self, method: str, path: str, **more: Any) -> dict[str, Any]:
        """Returns the JSON object of the response; see `request`."""
        return parse((await self.request(method, path, **more)).content)

    @asynccontextmanager
    async def stream(
        self, path: str, *, body: Union[Mapping[str, Any], bytes, None], headers: Mapping[str, str], parameters: Parameters
    ) -> AsyncIterator[AsyncIterator[bytes]]:
        """Yields the pieces of a response as they are consumed. With a body the request is a POST: JSON, or unchanged
        if the headers have a `Content-Type`. There are no retries."""
        http = self._connections.http
        timeout = httpx.Timeout(http.timeout)
        timeout.read = max(timeout.read or _QUIET_STREAM, _QUIET_STREAM)
        content = body if body is None or isinstance(body, bytes) else encoded(body)
        method = "GET" if content is None else "POST"
        if isinstance(body, Mapping):
            headers = {**headers, "Content-Type": "application/json"}
        request = http.build_request(
            method, path, content=content, headers=headers, params=parameters or None, timeout=timeout
        )
        response = await self._connections.send(request, stream=True)
        try:
            self._has_answered = True
            if not response.is_success:
                await self._connections.read(response)
                raise api_error(response)
            yield self._connections.chunks(response)
        finally:
            await self._connections.release(response)

    def is_hopeless(self, error: httpx.TransportError, seconds: float) -> bool:
        """True if a retry is useless after failing for this many seconds."""
        unreachable = isinstance(error, _UNREACHABLE) and not self._has_answered
        return isinstance(error, _HOPELESS) or (unreachable and seconds > _FIRST_CONTACT)

    def lost(self, error: httpx.TransportError) -> PiadError:
        """The error after the last attempt, or if the connection was never made."""
        what = "cannot reach" if isinstance(error, _UNREACHABLE) else "lost the connection to"
        return ConnectionLost(f"{what} {self._connections.http.base_url}: {type(error).__name__}: {error}")


def server_url(text: str) -> httpx.URL:
    """Checks the URL of a server; raises `ValueError` if it is invalid."""
    scheme, separator, rest = text.partition("://")
    if not separator or scheme.lower() not in ("http", "https"):
        host = (rest if separator else text) or "127.0.0.1:8080"
        raise ValueError(f'{text!r} is not the URL of a server, which begins with http:// or https://: "http://{host}"?')
    try:
        url = httpx.URL(text)
    except httpx.InvalidURL as error:
        raise ValueError(f"{text!r} is not the URL of a server: {error}") from error
    if not url.host or not 0 < (url.port or 80) < 1 << 16:
        part = "port" if url.host else "host"
        raise ValueError(f"{text!r} is not the URL of a server: there is no such {part}")
    return url


def encoded(body: Mapping[str, Any]) -> bytes:
    """Encodes a body as JSON; `ValueError` names the first number that is not finite."""
    try:
        return json.dumps(body, allow_nan=False, separators=(",", ":")).encode()
    except ValueError as error:
        for path, number in _not_finite(body, ""):
            raise ValueError(f"{path} is {number}: numbers must be finite") from error
        raise


def _not_finite(value: Any, path: str) -> Iterator[tuple[str, float]]:
    """Yields numbers that are NaN or infinite, with their locations: `curve.points[3][1]`."""
    if isinstance(value, float):
        if not math.isfinite(value):
            yield path, value
    elif isinstance(value, Mapping):
        for name, part in value.items():
            yield from _not_finite(part, f"{path}.{name}" if path else str(name))
    elif isinstance(value, (list, tuple)):
        for index, part in enumerate(value):
            yield from _not_finite(part, f"{path}[{index}]")


def parse(text: str | bytes) -> dict[str, Any]:
    """Parses the JSON object of a response or event."""
    try:
        value = json.loads(text)
    except ValueError as error:
        raise ProtocolError(f"the server did not answer JSON: {error}") from error
    if not isinstance(value, dict):
        raise ProtocolError("the server did not answer a JSON object")
    return value


def may_try_again(error: ApiError) -> bool:
    """True if the same request may succeed later."""
    return error.status in _TRY_AGAIN


def api_error(response: httpx.Response) -> ApiError:
    """The problem in a response; for responses of proxies it is made from the status."""
    problem = Problem("about:blank", response.reason_phrase, response.status_code, response.text[:1000])
    if response.headers.get("content-type", "").startswith("application/problem+json"):
        problem = Problem.from_json(parse(response.content))
    return ApiError(problem, retry_after(response))

"""Requests that are sent again when that helps, and answers as JSON or exceptions."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Optional

import httpx

from ._backoff import delay, retry_after
from .errors import ApiError, ConnectionLost, PiadError, Problem, ProtocolError

# Too many requests, and what proxies and servers say that have no room or no time.
_TRY_AGAIN = frozenset({429, 502, 503, 504})

# Servers send a comment every 15 seconds.
_QUIET_STREAM = 60.0

Parameters = Mapping[str, str]


class Transport:
    """Connections to one server.

    Every request may be sent more than once: those that create something carry a key by which the
    server recognises them.
    """

    def __init__(self, http: httpx.Client, attempts: int):
        self._http = http
        self.attempts = attempts
        """How often something is tried that fails, at most."""

    def close(self) -> None:
        """Closes all connections."""
        self._http.close()

    def request(
        self,
        method: str,
        path: str,
        *,
        body: Optional[Mapping[str, Any]] = None,
        headers: Optional[Mapping[str, str]] = None,
        parameters: Optional[Parameters] = None,
    ) -> httpx.Response:
        """An answer that is not an error. The path may have a query of its own."""
        content = None if body is None else json.dumps(body, allow_nan=False, separators=(",", ":")).encode()
        sent = {"Accept": "application/json", **(headers or {})}
        if content is not None:
            sent["Content-Type"] = "application/json"
        request = self._http.build_request(method, path, content=content, headers=sent, params=parameters or None)
        for attempt in range(1, self.attempts + 1):
            last = attempt == self.attempts
            try:
                response = self._http.send(request)
            except httpx.TransportError as error:
                if last:
                    raise lost(error) from error
                time.sleep(delay(attempt))
                continue
            if response.is_success:
                return response
            error_ = api_error(response)
            # A lost answer to the deletion: now there is nothing any more.
            if method == "DELETE" and response.status_code == 404 and attempt > 1:
                return response
            if last or not may_try_again(error_):
                raise error_
            time.sleep(delay(attempt) if error_.retry_after is None else error_.retry_after)
        raise AssertionError("there is one attempt at least")

    def json(self, method: str, path: str, **more: Any) -> dict[str, Any]:
        """The object that is answered; see `request`."""
        return parse(self.request(method, path, **more).content)

    @contextmanager
    def stream(self, path: str, *, headers: Mapping[str, str], parameters: Parameters) -> Iterator[httpx.Response]:
        """An answer that is read piece by piece. Nothing is tried again."""
        timeout = httpx.Timeout(self._http.timeout)
        timeout.read = max(timeout.read or _QUIET_STREAM, _QUIET_STREAM)
        with self._http.stream("GET", path, headers=headers, params=parameters or None, timeout=timeout) as response:
            if not response.is_success:
                response.read()
                raise api_error(response)
            yield response


def parse(text: str | bytes) -> dict[str, Any]:
    """The object of an answer or of an event."""
    try:
        value = json.loads(text)
    except ValueError as error:
        raise ProtocolError(f"the server did not answer JSON: {error}") from error
    if not isinstance(value, dict):
        raise ProtocolError("the server did not answer a JSON object")
    return value


def may_try_again(error: ApiError) -> bool:
    """Whether the same request may succeed later."""
    return error.status in _TRY_AGAIN


def lost(error: httpx.TransportError) -> PiadError:
    """A connection that broke once too often."""
    return ConnectionLost(f"{type(error).__name__}: {error}")


def api_error(response: httpx.Response) -> ApiError:
    """The problem that the server names; of other servers on the way, what the status says."""
    problem = Problem("about:blank", response.reason_phrase, response.status_code, response.text[:1000])
    if response.headers.get("content-type", "").startswith("application/problem+json"):
        problem = Problem.from_json(parse(response.content))
    return ApiError(problem, retry_after(response))

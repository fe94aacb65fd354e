"""The event stream of a job, across connections."""

from __future__ import annotations

from collections.abc import AsyncGenerator, AsyncIterator, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import Any, Optional, Union

import httpx

from . import _sse
from ._backoff import delay
from ._transport import Parameters, Transport, may_try_again, parse
from .errors import ApiError, ConnectionLost, PiadError

Events = AsyncGenerator[tuple[str, dict[str, Any]], None]
"""Yields pairs of event name and data. Each connection begins with a `job` event."""

_RETRY = 2.0
_END = "end"


class EventStream:
    """The events of a job, each exactly once and in order, up to the `end` event.

    If the connection breaks or the server stops, the stream is reopened after the last event received. If the server
    has been replaced by another version, whose numbers may differ in the last digits, all iterations are sent again and
    the `job` event says `"resumed": "restarted"`. The delay is the one requested by the server (`retry:`,
    `Retry-After`) and grows until an iteration arrives.

    A stream with a `body` is the response to a POST that stores nothing: it cannot be resumed.
    """

    def __init__(
        self,
        transport: Transport,
        path: str,
        parameters: Parameters,
        *,
        after: Optional[int] = None,
        body: Optional[Mapping[str, Any]] = None,
    ):
        self._transport = transport
        self._path = path
        self._parameters = parameters
        self._seen = None if after is None else str(after)
        self._body = body
        self._retry = _RETRY
        self._failures = 0

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Events]:
        """Yields the events and closes the connection at the end."""
        events = self._events()
        try:
            yield events
        finally:
            await events.aclose()

    async def _events(self) -> Events:
        while True:
            try:
                async with self._connection() as chunks:
                    parser = _sse.Parser()
                    async for chunk in chunks:
                        for event in parser.feed(chunk):
                            taken = self._take(event)
                            if taken is not None:
                                yield taken
                                if taken[0] == _END:
                                    return
                await self._wait(ConnectionLost("the stream ended before the job"))
            except httpx.TransportError as error:
                await self._wait(self._transport.lost(error))
            except ApiError as error:
                if not may_try_again(error):
                    raise
                await self._wait(error, error.retry_after or 0.0)

    def _connection(self) -> AbstractAsyncContextManager[AsyncIterator[bytes]]:
        headers = {"Accept": "text/event-stream", "Cache-Control": "no-store"}
        if self._seen is not None:
            headers["Last-Event-ID"] = self._seen
        return self._transport.stream(self._path, body=self._body, headers=headers, parameters=self._parameters)

    def _take(self, event: Union[_sse.Event, _sse.Retry]) -> Optional[tuple[str, dict[str, Any]]]:
        """The name and data of a new event; None if it was already seen."""
        if isinstance(event, _sse.Retry):
            self._retry = event.seconds
            return None
        if self._is_known(event.id):
            return None
        data = parse(event.data)
        if data.get("resumed") == "restarted":
            self._seen = None
        if event.id:
            self._seen, self._failures = event.id, 0
        return event.name, data

    def _is_known(self, event_id: str) -> bool:
        """True if an iteration has been received, so that the server would send it twice."""
        numbers = event_id.isdecimal() and self._seen is not None and self._seen.isdecimal()
        return numbers and int(event_id) <= int(self._seen or 0)

    async def _wait(self, error: PiadError, at_least: float = 0.0) -> None:
        self._failures += 1
        cannot_go_on = self._body is not None and self._seen is not None
        if self._failures >= self._transport.attempts or cannot_go_on:
            raise error
        await self._transport.sleep(delay(self._failures, max(self._retry, at_least)))

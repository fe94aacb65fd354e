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
"""Pairs of the name of an event and its data. The `job` event comes with every connection."""

_RETRY = 2.0
_END = "end"


class EventStream:
    """The events of a job, each once and in order, up to the `end` event.

    Whenever the connection breaks or the server stops it is opened again after the last event that
    arrived. If the server is another version by then, whose numbers differ in the last digits, all
    iterations come again: the `job` event says `"resumed": "restarted"`. The waiting time is the one
    that the server asks for (`retry:`, `Retry-After`), and grows as long as no iteration arrives.

    A stream with a `body` is the answer to a POST of which nothing is kept: it goes on with nothing.
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
        """The events, of which no connection is left open afterwards."""
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
        """The name and the data of an event that is not known yet."""
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
        """Whether an iteration has been seen: a server would have to send it twice."""
        numbers = event_id.isdecimal() and self._seen is not None and self._seen.isdecimal()
        return numbers and int(event_id) <= int(self._seen or 0)

    async def _wait(self, error: PiadError, at_least: float = 0.0) -> None:
        self._failures += 1
        cannot_go_on = self._body is not None and self._seen is not None
        if self._failures >= self._transport.attempts or cannot_go_on:
            raise error
        await self._transport.sleep(delay(self._failures, max(self._retry, at_least)))

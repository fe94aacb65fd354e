"""The event stream of a job, across connections."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any, Optional

import httpx

from . import _sse
from ._backoff import delay
from ._transport import Parameters, Transport, may_try_again, parse
from .errors import ApiError, ConnectionLost, PiadError

_RETRY = 2.0
_END = "end"


class EventStream:
    """The events of a job, each once and in order, up to the `end` event.

    Whenever the connection breaks or the server stops it is opened again after the last event that
    arrived. If the server is another version by then, whose numbers differ in the last digits, all
    iterations come again: the `job` event says `"resumed": "restarted"`. The waiting time is the one
    that the server asks for (`retry:`, `Retry-After`), and grows as long as no iteration arrives.
    """

    def __init__(self, transport: Transport, path: str, parameters: Parameters, after: Optional[int] = None):
        self._transport = transport
        self._path = path
        self._parameters = parameters
        self._seen = None if after is None else str(after)
        self._retry = _RETRY
        self._failures = 0

    def __iter__(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Pairs of the name of an event and its data. The `job` event comes with every connection."""
        while True:
            try:
                for event in self._connection():
                    data = parse(event.data)
                    if data.get("resumed") == "restarted":
                        self._seen = None
                    yield event.name, data
                    if event.id:
                        self._seen, self._failures = event.id, 0
                    if event.name == _END:
                        return
                if self._seen == _END:
                    return
                self._wait(ConnectionLost("the stream ended before the job"))
            except httpx.TransportError as error:
                self._wait(self._transport.lost(error))
            except ApiError as error:
                if not may_try_again(error):
                    raise
                self._wait(error, error.retry_after or 0.0)

    def _connection(self) -> Iterator[_sse.Event]:
        """The events of one connection, without those that are known."""
        headers = {"Accept": "text/event-stream", "Cache-Control": "no-store"}
        if self._seen is not None:
            headers["Last-Event-ID"] = self._seen
        with self._transport.stream(self._path, headers=headers, parameters=self._parameters) as response:
            for event in _sse.events(_sse.lines(response.iter_bytes())):
                if isinstance(event, _sse.Retry):
                    self._retry = event.seconds
                elif not self._is_known(event.id):
                    yield event

    def _is_known(self, event_id: str) -> bool:
        """Whether an iteration has been seen: a server would have to send it twice."""
        numbers = event_id.isdecimal() and self._seen is not None and self._seen.isdecimal()
        return numbers and int(event_id) <= int(self._seen or 0)

    def _wait(self, error: PiadError, at_least: float = 0.0) -> None:
        self._failures += 1
        if self._failures >= self._transport.attempts:
            raise error
        time.sleep(delay(self._failures, max(self._retry, at_least)))

"""The part of server-sent events (WHATWG HTML, section 9.2) that this API uses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Union


@dataclass(frozen=True)
class Event:
    """An event."""

    name: str
    data: str
    id: str
    """The id of this event, or an empty string."""


@dataclass(frozen=True)
class Retry:
    """Seconds to wait before reconnecting."""

    seconds: float


class Parser:
    """Parses the events of a stream as bytes arrive. An incomplete event at the end is dropped."""

    def __init__(self) -> None:
        self._line: list[bytes] = []
        self._clear()

    def _clear(self) -> None:
        self._name, self._id, self._data = "message", "", list[str]()

    def feed(self, chunk: bytes) -> Iterator[Union[Event, Retry]]:
        """Returns the events completed by these bytes; lines end with LF or CR LF."""
        *complete, last = chunk.split(b"\n")
        for end in complete:
            line = b"".join([*self._line, end]).rstrip(b"\r").decode()
            self._line = []
            if line:
                yield from self._field(line)
            else:
                if self._data:
                    yield Event(self._name, "\n".join(self._data), self._id)
                self._clear()
        self._line.append(last)

    def _field(self, line: str) -> Iterator[Retry]:
        field, _, value = line.partition(":")
        value = value[1:] if value.startswith(" ") else value
        if field == "event":
            self._name = value
        elif field == "data":
            self._data.append(value)
        elif field == "id":
            self._id = value
        elif field == "retry" and value.isdecimal():
            yield Retry(int(value) / 1000)

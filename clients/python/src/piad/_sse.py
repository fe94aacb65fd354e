"""Server-sent events (WHATWG HTML, section 9.2), as far as a client of this API needs them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Union


@dataclass(frozen=True)
class Event:
    """An event."""

    name: str
    data: str
    id: str
    """The id of this event or, if it has none, an empty text."""


@dataclass(frozen=True)
class Retry:
    """How long to wait before connecting again, in seconds."""

    seconds: float


def events(lines: Iterable[str]) -> Iterator[Union[Event, Retry]]:
    """The events in the lines of a stream. One that is cut off by the end of the stream is dropped."""
    name, event_id, data = "message", "", list[str]()
    for line in lines:
        if not line:
            if data:
                yield Event(name, "\n".join(data), event_id)
            name, event_id, data = "message", "", []
            continue
        field, _, value = line.partition(":")
        value = value[1:] if value.startswith(" ") else value
        if field == "event":
            name = value
        elif field == "data":
            data.append(value)
        elif field == "id":
            event_id = value
        elif field == "retry" and value.isdecimal():
            yield Retry(int(value) / 1000)


def lines(chunks: Iterable[bytes]) -> Iterator[str]:
    """The complete lines of a stream of bytes; they end with LF or CR LF."""
    rest: list[bytes] = []
    for chunk in chunks:
        *complete, last = chunk.split(b"\n")
        for line in complete:
            rest.append(line)
            yield b"".join(rest).rstrip(b"\r").decode()
            rest = []
        rest.append(last)

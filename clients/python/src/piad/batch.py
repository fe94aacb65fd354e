"""Batches: many fits in one request, and their results."""

from __future__ import annotations

import json
import math
import time
from collections.abc import AsyncGenerator, AsyncIterable, AsyncIterator, Generator, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Optional, Union

import httpx

from . import _request
from ._arrays import np
from ._backoff import delay
from ._blocking import iterate
from ._transport import Transport, encoded, may_try_again, parse
from .errors import ApiError, FieldError, Problem
from .geometry import Curve, Surface
from .iteration import Distances, Result

# A request is sent completely before its response is read: the server reads this far ahead.
_PART_BYTES = 256 * 1024
_PART_ITEMS = 5000

# Seconds after which a partly filled request is sent.
_PART_SECONDS = 0.5

_HEADERS = {"Accept": "application/x-ndjson", "Content-Type": "application/x-ndjson"}

Items = Union[Iterable[Any], AsyncIterable[Any]]


@dataclass(frozen=True, eq=False)
class BatchItem:
    """The result of an item of a batch."""

    index: int
    """Its index in the batch, from 0."""
    name: Optional[str]
    state: str
    """"converged", "exhausted", "stalled" or "failed"; "failed" also if the item is invalid."""
    iteration: Optional[int]
    """The number of the last iteration; None if there was none."""
    error: Optional[Distances]
    result: Optional[Result]
    """The last iteration, also if the fit has not converged; its id is empty."""
    problem: Optional[Problem]
    """Why it has not converged; its pointers begin with `/items/3` or `/defaults`."""
    notices: tuple[str, ...] = ()
    """Notes about the interpretation of its points, such as the chosen parameters."""

    def __repr__(self) -> str:
        error = "" if self.error is None else f", {self.error.brief}"
        return f"<piad.BatchItem {self.index}: {self.state}{error}>"

    @property
    def converged(self) -> bool:
        """True if the fit is within its tolerance."""
        return self.state == "converged"

    @property
    def curve(self) -> Curve:
        """The curve, also of a fit that has not converged. `ApiError` if there is none, `TypeError` if it is a surface."""
        return self._fitted().curve

    @property
    def surface(self) -> Surface:
        """The surface, likewise."""
        return self._fitted().surface

    def _fitted(self) -> Result:
        if self.result is None:
            raise ApiError(self.problem or Problem("about:blank", "", 0, f"item {self.index} is {self.state}"))
        return self.result

    @classmethod
    def from_json(cls, value: Mapping[str, Any], first: int = 0) -> BatchItem:
        """Parses the line of an item; the request began with item `first`."""
        own = value["index"]
        error = value.get("error")
        result = None
        for kind in ("curve", "surface"):
            if kind in value:
                about = {"id": "", "kind": kind, "name": value.get("name"), "state": value["state"]}
                level = {"iteration": value["iteration"], "error": error}
                result = Result.from_json({**value[kind], **about, **level})
        problem = None if "problem" not in value else _moved(Problem.from_json(value["problem"]), own, own + first)
        return cls(
            own + first,
            value.get("name"),
            value["state"],
            value.get("iteration"),
            None if error is None else Distances.from_json(error),
            result,
            problem,
            tuple(value.get("notices", ())),
        )


def _moved(problem: Problem, own: int, index: int) -> Problem:
    """Replaces the index of the item in its request by that in the batch."""
    before, after = f"/items/{own}", f"/items/{index}"

    def moved(error: FieldError) -> FieldError:
        pointer = error.pointer
        if pointer is None or not f"{pointer}/".startswith(f"{before}/"):
            return error
        return replace(error, pointer=after + pointer[len(before) :])

    detail = problem.detail.replace(f"{before}/", f"{after}/").replace(f"{before}:", f"{after}:")
    return replace(problem, detail=detail, errors=tuple(map(moved, problem.errors)))


@dataclass
class BatchTotals:
    """Counts of the items of a batch that have ended."""

    items: int = 0
    converged: int = 0
    failed: int = 0
    """The number that have not converged."""


class AsyncBatch:
    """The results of a batch, in the order of the items, as they complete: `async for item in batch`. It can be
    iterated once."""

    def __init__(self, transport: Transport, items: Items, defaults: Mapping[str, Any]):
        self.totals = BatchTotals()
        """Counts of the items so far."""
        self._transport = transport
        self._begin = encoded({"defaults": defaults}) + b"\n" if defaults else b""
        self._items = self._read(items)

    def __aiter__(self) -> AsyncGenerator[BatchItem, None]:
        return self._items

    async def _read(self, items: Items) -> AsyncGenerator[BatchItem, None]:
        first = 0
        async for part in _parts(items):
            count = len(part)
            fitted = self._fit(part, first)
            try:
                async for item in fitted:
                    self.totals.items += 1
                    if item.converged:
                        self.totals.converged += 1
                    else:
                        self.totals.failed += 1
                    yield item
            finally:
                await fitted.aclose()
            first += count

    async def _fit(self, lines: list[bytes], first: int) -> AsyncGenerator[BatchItem, None]:
        """Fits a group of items. After a broken connection, items without a result are sent again."""
        failures, started = 0, time.monotonic()
        while lines:
            answered = 0
            values = self._values(self._begin + b"".join(lines))
            try:
                async for value in values:
                    if "totals" in value:
                        return
                    if "index" not in value:
                        raise ApiError(Problem.from_json(value.get("problem", {})))
                    answered, failures, started = value["index"] + 1, 0, time.monotonic()
                    yield BatchItem.from_json(value, first)
                raise httpx.ReadError("the answer has no end")
            except (httpx.TransportError, ApiError) as error:
                failures += 1
                await self._wait(error, failures, time.monotonic() - started)
            finally:
                await values.aclose()
            del lines[:answered]
            first += answered

    async def _wait(self, error: Union[httpx.TransportError, ApiError], failures: int, seconds: float) -> None:
        """Waits before a retry, or raises the error if there are no attempts left."""
        transport, pause = self._transport, delay(failures)
        is_last = failures >= transport.attempts
        if isinstance(error, ApiError):
            if is_last or not may_try_again(error):
                raise error
            pause = pause if error.retry_after is None else error.retry_after
        elif is_last or transport.is_hopeless(error, seconds + pause):
            raise transport.lost(error) from error
        await transport.sleep(pause)

    async def _values(self, body: bytes) -> AsyncGenerator[dict[str, Any], None]:
        """The lines of the response to a group."""
        parameters = {} if np is None else {"encoding": "base64"}
        async with self._transport.stream("/v1/batch", body=body, headers=_HEADERS, parameters=parameters) as chunks:
            async for line in _lines(chunks):
                yield parse(line)


class Batch:
    """The results of a batch, in the order of the items, as they complete: `for item in batch`. It can be iterated
    once."""

    def __init__(self, batch: AsyncBatch):
        self._batch = batch
        self._items = iterate(batch.__aiter__())

    @property
    def totals(self) -> BatchTotals:
        """Counts of the items so far."""
        return self._batch.totals

    def __iter__(self) -> Generator[BatchItem, None, None]:
        return self._items


async def _lines(chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
    """Splits chunks of text into lines."""
    begun: list[bytes] = []
    async for chunk in chunks:
        *ends, rest = chunk.split(b"\n")
        for end in ends:
            yield b"".join([*begun, end])
            begun = []
        begun.append(rest)


async def _parts(items: Items) -> AsyncIterator[list[bytes]]:
    """Groups items as lines."""
    part: list[bytes] = []
    size, begun = 0, 0.0
    async for item in _each(items):
        line = _line(item)
        if part and size + len(line) > _PART_BYTES:
            yield part
            part, size = [], 0
        if not part:
            begun = time.monotonic()
        part.append(line)
        size += len(line)
        if len(part) >= _PART_ITEMS or time.monotonic() - begun > _PART_SECONDS:
            yield part
            part, size = [], 0
    if part:
        yield part


async def _each(items: Items) -> AsyncIterator[Any]:
    if isinstance(items, AsyncIterable):
        async for item in items:
            yield item
    else:
        for item in items:
            yield item


def _line(item: Any) -> bytes:
    """Encodes an item as a line. NaN and infinity become null, so that only this item fails."""
    if isinstance(item, Mapping):
        job = {str(name): _request.plain(value) for name, value in item.items()}
    else:
        job = _request.shape_alone(item)
    try:
        return encoded(job) + b"\n"
    except ValueError:
        return json.dumps(_with_nulls(job), separators=(",", ":")).encode() + b"\n"


def _with_nulls(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {name: _with_nulls(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_with_nulls(part) for part in value]
    return value

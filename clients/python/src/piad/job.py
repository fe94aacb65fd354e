"""Jobs: fits on the server."""

from __future__ import annotations

import os
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Optional, Union

from . import _request
from ._arrays import as_lists, np
from ._events import EventStream
from ._request import Method, Rational
from ._transport import Transport
from .errors import JobFailed, Problem, WaitTimeout
from .iteration import Deviation, Distances, Index, Iteration, Result, Samples, Shape

State = Literal["queued", "running", "converged", "exhausted", "stalled", "failed", "cancelled"]
View = Literal["control_points", "samples", "errors"]
Encoding = Literal["json", "base64", "base64_f32"]
Format = Literal["json", "step", "iges", "obj", "gltf", "stl", "dxf", "svg", "csv"]
Dots = Literal["auto", "on", "off"]
Units = Literal["mm", "m", "in"]
SampleCount = Union[int, tuple[int, int]]
"""The number of points of a curve, or the numbers in u and in v of a surface."""

# What streams are like, whatever the job sets for its own.
_PLAIN = {
    "view": "errors",
    "every": "1",
    "milestones": "",
    "pace": "all",
    "changed": "false",
    "describe": "full",
    "encoding": "json",
    "digits": "full",
    "on_disconnect": "continue",
}
# No job has so many iterations: a stream has the first and the last.
_ENDS_ONLY = {**_PLAIN, "every": "1000000000"}


@dataclass(frozen=True)
class JobWarning:
    """What is doubtful about a fit that is computed even so."""

    code: str
    """What it is, such as "few_points"."""
    pointer: str
    """The part of the job's input that it is about, such as "/curve/basis/degree"."""
    detail: str
    """Why it is doubtful, and what to do about it."""

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> JobWarning:
        """Reads a warning."""
        return cls(value["code"], value["pointer"], value["detail"])


@dataclass(frozen=True)
class Status:
    """A job as it stood when the server was asked."""

    id: str
    name: Optional[str]
    kind: Literal["curve", "surface"]
    state: State
    reason: Optional[str]
    """Why a job ended as it did, such as "minimum" or "convexity"."""
    detail: Optional[str]
    """The reason in words, with the distance that is left."""
    warnings: tuple[JobWarning, ...]
    """What is doubtful about the fit; some of it is known only when the job runs."""
    points: int
    method: Mapping[str, Any]
    """With the numbers that were computed for it."""
    stop: Mapping[str, Any]
    """The tolerance in data units, and `max_iterations`."""
    stream: Optional[Mapping[str, Any]]
    iteration: Optional[int]
    predicted: Mapping[str, Any]
    """`rate` and `iterations` in all, by what is known at that iteration; None where nobody knows."""
    error: Optional[Distances]
    progress: float
    """From 0 to 1."""
    created_at: str
    started_at: Optional[str]
    finished_at: Optional[str]
    """Times as in RFC 3339."""
    parent: Optional[Mapping[str, Any]] = None
    """Of an edit: `id` and `iteration`."""
    problem: Optional[Problem] = None
    """Why the job failed."""

    @property
    def ended(self) -> bool:
        """Whether the job goes no further."""
        return self.state not in ("queued", "running")

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Status:
        """Reads a job."""
        fields = {name: value[name] for name in _FIELDS}
        error, problem = value["error"], value.get("problem")
        return cls(
            **fields,
            detail=value.get("detail"),
            predicted=value.get("predicted", {}),
            warnings=tuple(JobWarning.from_json(it) for it in value.get("warnings", ())),
            error=None if error is None else Distances.from_json(error),
            parent=value.get("parent"),
            problem=None if problem is None else Problem.from_json(problem),
        )


_FIELDS = (
    "id",
    "name",
    "kind",
    "state",
    "reason",
    "points",
    "method",
    "stop",
    "stream",
    "iteration",
    "progress",
    "created_at",
    "started_at",
    "finished_at",
)


class Job:
    """A job, and what can be done with it."""

    def __init__(self, transport: Transport, status: Status):
        self._transport = transport
        self._shape: Optional[Shape] = None
        self.status = status
        """What the server said last; `refresh` asks it again."""

    def __repr__(self) -> str:
        return f"<piad.Job {self.id}: {self.status.state}>"

    @property
    def id(self) -> str:
        """The id."""
        return self.status.id

    @property
    def _path(self) -> str:
        return f"/v1/jobs/{self.id}"

    def refresh(self) -> Status:
        """Asks the server how the job stands."""
        self.status = Status.from_json(self._transport.json("GET", self._path))
        return self.status

    def iterations(
        self,
        *,
        view: Optional[View] = None,
        samples: Optional[SampleCount] = None,
        every: Optional[int] = None,
        milestones: Optional[Sequence[float]] = None,
        pace: Optional[Literal["all", "latest"]] = None,
        changed: Optional[bool] = None,
        encoding: Optional[Encoding] = None,
        digits: Optional[Literal["full", "auto"]] = None,
        after: Optional[int] = None,
    ) -> Iterator[Iteration]:
        """The iterations of the job, as they are computed and then up to its end.

        Every one from 0 on (or after `after`) comes once and in order, unless `every`, `milestones`
        (decreasing distances) or `pace="latest"` leave some out. Broken connections and servers that
        start again are survived: the stream goes on where it broke off. When the iterator ends,
        `status` is that of the ended job.

        With `changed` the server sends only control points that have moved; iterations are complete
        even so. Numbers travel as base64 where numpy is there, unless the job has a `stream` of its
        own or other parameters forbid it.
        """
        parameters = {
            "view": view,
            "samples": None if samples is None else _grid(samples),
            "every": every,
            "milestones": None if milestones is None else ",".join(repr(float(m)) for m in milestones),
            "pace": pace,
            "changed": None if changed is None else str(bool(changed)).lower(),
            "encoding": encoding,
            "digits": digits,
        }
        text = {name: str(value) for name, value in _request.given(parameters).items()}
        if "describe" in (self.status.stream or {}):
            # Knots are needed, whatever the job says of its streams.
            text["describe"] = "full"
        if self._may_be_binary(text):
            text["encoding"] = "base64"
        return self._iterations(text, after)

    def _may_be_binary(self, parameters: Mapping[str, str]) -> bool:
        """Whether base64 goes with these parameters and is quicker to read."""
        decimal = {"encoding", "digits", "changed"} & parameters.keys() or parameters.get("view") == "errors"
        return np is not None and self.status.stream is None and not decimal

    def _iterations(self, parameters: Mapping[str, str], after: Optional[int]) -> Iterator[Iteration]:
        before: Optional[Iteration] = None
        shape: Optional[Shape] = None
        for name, data in EventStream(self._transport, f"{self._path}/events", parameters, after):
            if name == "job":
                self._shape = shape = Shape.from_json(data)
            elif name == "iteration":
                before = Iteration.from_json(data, shape or self.shape(), before)
                shape = before.shape
                yield before
        self.refresh()

    def shape(self) -> Shape:
        """The bases of the fit. Waits until the job has begun."""
        if self._shape is None:
            for name, data in EventStream(self._transport, f"{self._path}/events", _ENDS_ONLY):
                if name == "job":
                    self._shape = Shape.from_json(data)
                    break
            else:
                raise JobFailed(self.id, self.refresh().state, self.status.problem)
        return self._shape

    def iteration(self, number: Union[int, Literal["last"]] = "last") -> Iteration:
        """One iteration with its geometry, of a job in any state; those to come are waited for."""
        parameters = {} if np is None else {"encoding": "base64"}
        data = self._level(number, parameters)
        return Iteration.from_json(data, self.shape())

    def samples(self, count: SampleCount, iteration: Union[int, Literal["last"]] = "last") -> Samples:
        """Points at equal steps of the parameters, computed by the server."""
        parameters = {"view": "samples", "samples": _grid(count)}
        if np is not None:
            parameters["encoding"] = "base64"
        return Samples.from_json(self._level(iteration, parameters))

    def _level(self, number: Union[int, str], parameters: Mapping[str, str]) -> dict[str, Any]:
        return self._transport.json("GET", f"{self._path}/iterations/{number}", parameters=parameters)

    def wait(self, timeout: Optional[float] = None) -> Status:
        """Waits until the job has ended; `WaitTimeout` after so many seconds."""
        if timeout is None:
            for _ in EventStream(self._transport, f"{self._path}/events", _ENDS_ONLY):
                pass
            return self.refresh()
        deadline, pause = time.monotonic() + timeout, 0.01
        while not self.refresh().ended:
            left = deadline - time.monotonic()
            if left <= 0:
                raise WaitTimeout(f"the job {self.id} is {self.status.state} after {timeout} s")
            time.sleep(min(pause, left))
            pause = min(1.5 * pause, 1.0)
        return self.status

    def result(self, timeout: Optional[float] = None) -> Result:
        """The last level, when the job has ended: waits for that, `timeout` seconds at most.

        A job that was cancelled has a result if it got anywhere. `JobFailed` if there is none.
        """
        status = self.status if self.status.ended else self.wait(timeout)
        if status.state == "failed" or status.iteration is None:
            raise JobFailed(self.id, status.state, status.problem)
        parameters = {} if np is None else {"encoding": "base64"}
        return Result.from_json(self._transport.json("GET", f"{self._path}/result", parameters=parameters))

    def deviation(self, iteration: Union[int, Literal["last"]] = "last", *, distances: bool = False) -> Deviation:
        """How far the data are from the nearest points of an iteration: with `distances` also for each point.

        The `error` of an iteration is taken at the parameters of the data, and is larger.
        """
        parameters = {"iteration": str(iteration), "list": str(bool(distances)).lower()}
        return Deviation.from_json(self._transport.json("GET", f"{self._path}/deviation", parameters=parameters))

    def input(self) -> dict[str, Any]:
        """The job as it was asked for, as JSON."""
        return self._transport.json("GET", f"{self._path}/input")

    def ticket(self) -> str:
        """Opens the stream of the job for a minute where no token can be sent, as in a browser's `EventSource`.

        It is the query parameter `ticket` of `/v1/jobs/{id}/events`. An `ApiError` with status 409 if
        the server asks for no tokens.
        """
        ticket: str = self._transport.json("POST", f"{self._path}/tickets")["ticket"]
        return ticket

    def cancel(self) -> Status:
        """Stops the job. An `ApiError` with status 409 if it has already ended."""
        self.status = Status.from_json(self._transport.json("POST", f"{self._path}/cancel"))
        return self.status

    def delete(self) -> None:
        """Makes the server forget the job."""
        self._transport.request("DELETE", self._path)

    def edit(
        self,
        points: Optional[Mapping[Index, Any]] = None,
        *,
        point_weights: Optional[Mapping[Index, float]] = None,
        weights: Any = None,
        rational: Optional[Rational] = None,
        method: Optional[Method] = None,
        tolerance: Optional[float] = None,
        relative_tolerance: Optional[float] = None,
        max_iterations: Optional[int] = None,
        iteration: Optional[int] = None,
        name: Optional[str] = None,
        stream: Optional[Mapping[str, Any]] = None,
        idempotency_key: Optional[str] = None,
    ) -> Job:
        """A new job that starts from the control points of this one; what is not given stays.

        `points` moves data points, `{17: [x, y, z]}` or on surfaces `{(row, column): …}`;
        `point_weights` gives some of a homogeneous fit new weights, `weights` all. `iteration` is
        the one to start from, by default the last.
        """
        body = {
            "name": name,
            "iteration": iteration,
            "points": _moves(points or {}, point_weights or {}) or None,
            "weights": _request.plain(weights),
            "rational": rational,
            "method": None if method is None else _request.settings(method),
            "stop": _request.stop(tolerance, relative_tolerance, max_iterations) or None,
            "stream": stream,
        }
        return post(self._transport, f"{self._path}/edits", _request.given(body), key=idempotency_key)

    def download(
        self,
        format: Format,
        path: Union[str, os.PathLike[str]],
        *,
        iteration: Union[int, Literal["last"], None] = None,
        samples: Optional[SampleCount] = None,
        dots: Optional[Dots] = None,
        units: Optional[Units] = None,
    ) -> Path:
        """Writes the result (or an iteration) to a file, such as STEP for CAD systems.

        `samples` says how many points gltf, stl, dxf, svg and csv take, `dots` whether svg shows data points,
        `units` which unit step and iges declare. The file is there as a whole or not at all.
        """
        part = "result" if iteration is None else f"iterations/{iteration}"
        parameters: dict[str, str] = {}
        if samples is not None:
            parameters["samples"] = _grid(samples)
        if dots is not None:
            parameters["dots"] = dots
        if units is not None:
            parameters["units"] = units
        headers = {"Accept": "*/*"}
        answer = self._transport.request("GET", f"{self._path}/{part}/{format}", headers=headers, parameters=parameters)
        target = Path(path)
        unfinished = target.with_name(f"{target.name}.{uuid.uuid4().hex}.part")
        try:
            unfinished.write_bytes(answer.content)
            unfinished.replace(target)
        finally:
            unfinished.unlink(missing_ok=True)
        return target


def post(
    transport: Transport,
    path: str,
    body: Mapping[str, Any],
    *,
    key: Optional[str] = None,
    wait: Optional[float] = None,
) -> Job:
    """A new job. However often the request has to be sent, its key makes it one job.

    With `wait` the server answers when the job has ended or after so many seconds.
    """
    headers = {"Idempotency-Key": str(uuid.uuid4()) if key is None else key}
    if wait is not None and wait >= 1.0:
        headers["Prefer"] = f"wait={int(wait)}"
    return Job(transport, Status.from_json(transport.json("POST", path, body=body, headers=headers)))


def _moves(points: Mapping[Index, Any], weights: Mapping[Index, float]) -> list[dict[str, Any]]:
    return [
        _request.given(
            {
                "index": _request.plain(index),
                "point": _request.plain(points.get(index)),
                "weight": weights.get(index),
            }
        )
        for index in {**points, **weights}
    ]


def _grid(count: SampleCount) -> str:
    return str(count) if isinstance(count, int) else "x".join(map(str, as_lists(count)))

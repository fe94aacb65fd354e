"""A fit as a series of updates, independent of a user interface."""

from __future__ import annotations

import hashlib
import time
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from . import plane, server
from .points import CLOUD, CURVE, Points
from .settings import Settings

# Time limit in seconds for distances of points; above it they are requested only at the end.
_QUICK = 0.15

# Control points of the base surface, in each direction.
_ROUGH = 8


@dataclass(frozen=True)
class Update:
    """A fit at one of its iterations."""

    geometry: Any
    iteration: int
    error: float
    """The largest distance of the points."""
    rough: bool = False
    """True for the base surface that provides parameters for the fit."""
    distances: tuple[float, ...] | None = None
    """The distance of each point from the nearest point of the shape."""
    state: str = "running"
    detail: str = ""
    """The reason, if the fit has ended outside the tolerance."""
    warnings: tuple[str, ...] = ()
    version: str = ""
    """The id on the server."""

    @property
    def ended(self) -> bool:
        """True for the last update."""
        return self.state != "running"

    @property
    def control_points(self) -> tuple[int, ...]:
        """The number of control points; for a surface those in u and v."""
        net = self.geometry.control_points
        return (len(net), len(net[0])) if hasattr(self.geometry, "degrees") else (len(net),)


class Follower:
    """Creates jobs on a server and watches them; `cancel` ends it from another thread."""

    def __init__(self, client: Any):
        self._client = client
        self.job: Any = None
        self.cancelled = False
        self._measures = True

    def updates(self, points: Points, settings: Settings) -> Iterator[Update]:
        """The updates of a fit, the last one with its end. Slow readers get the newest."""
        parameters: Any = None
        degree: Any = settings.degree
        if points.kind == CLOUD:
            parameters = plane.parameters(points.values) if points.are_numbers else "project"
            degree = degrees(points, settings, parameters)
            if settings.steep:
                yield from self._follow(rough_request(points, settings, parameters), rough=True)
                parameters = {"foot_points": {"job": self.job.id}}
        rough = self.job
        if not self.cancelled:
            yield from self._follow(request(points, settings, degree, parameters))
        if rough is not None:
            rough.delete()

    def cancel(self) -> None:
        """Cancels and deletes the job."""
        self.cancelled = True
        self.forget()

    def forget(self) -> None:
        """Deletes the job on the server; its results remain valid here."""
        job, self.job = self.job, None
        if job is not None:
            try:
                job.delete()
            except server.piad().PiadError:
                pass  # The server has stopped, and the job with it.

    def _follow(self, request: dict[str, Any], rough: bool = False) -> Iterator[Update]:
        job = self._client.create(**request)
        self.job = job
        if self.cancelled:
            self.forget()
            return
        last: Any = None
        for last in job.iterations(pace="latest", encoding="delta"):
            if self.cancelled:
                return
            # Distances from the base surface would be of little use.
            distances = None if rough or not self._measures else self._distances(job, last.number)
            yield Update(last.geometry, last.number, _error(last), rough, distances)
        if not rough and last is not None and not self.cancelled:
            yield self._end(job, last)

    def _end(self, job: Any, last: Any) -> Update:
        if job.status.state == "cancelled":
            last = job.iteration(last.number)  # The last one of a broken stream is not exact.
        return replace(_ended(job, last), version=self._client.capabilities()["version"])

    def _distances(self, job: Any, iteration: int) -> tuple[float, ...]:
        started = time.monotonic()
        distances = _distances(job, iteration)
        self._measures = time.monotonic() - started < _QUICK
        return distances


def _ended(job: Any, last: Any) -> Update:
    status = job.status
    if status.state == "failed":
        raise server.piad().JobFailed(job.id, status.state, status.problem)
    distances = _distances(job, last.number)
    warnings = tuple(warning.detail for warning in status.warnings)
    return Update(last.geometry, last.number, _error(last), False, distances, status.state, status.detail or "", warnings)


def _distances(job: Any, iteration: int) -> tuple[float, ...]:
    values = job.deviation(iteration, distances=True).distances
    return tuple(float(x) for x in (values.ravel() if hasattr(values, "ravel") else _flat(values)))


def _flat(values: Any) -> Iterator[float]:
    for value in values:
        if isinstance(value, list):
            yield from _flat(value)
        else:
            yield value


def _error(iteration: Any) -> float:
    return float("inf") if iteration.error.max is None else iteration.error.max


def rough_request(points: Points, settings: Settings, parameters: Any) -> dict[str, Any]:
    """A smooth surface with few control points over a plane."""
    counts = {way: min(_ROUGH, rows) for way, rows in _rows(points, parameters).items()}
    method = {"kind": "least_squares", "control_points": counts, "variant": "direct", "fairness": 1e-9, "end_points": "free"}
    return {
        "points": points.nested(),
        "scattered": True,
        "parameters": parameters,
        "degree": degrees(points, settings, parameters),
        "method": method,
        "name": "FreeCAD",
    }


def degrees(points: Points, settings: Settings, parameters: Any) -> dict[str, int]:
    """Vertices of a mesh may lie in a few rows: between them a surface should be straight, not bent
    by smoothing."""
    return {way: max(1, min(settings.degree, rows - 1)) for way, rows in _rows(points, parameters).items()}


def _rows(points: Points, parameters: Any) -> dict[str, int]:
    """The number of distinct parameters in each direction, up to rounding."""
    if parameters == "project":
        return {"u": points.shortest, "v": points.shortest}
    unit = 1e-9 * points.size or 1.0
    return {way: len({round(x / unit) for x in line}) for way, line in zip("uv", zip(*parameters))}


def request(points: Points, settings: Settings, degree: Any, parameters: Any) -> dict[str, Any]:
    """The arguments of `Client.create` for the fewest control points that meet the tolerance."""
    return {
        "points": points.nested(),
        "scattered": points.kind == CLOUD,
        "parameters": parameters,
        "closed": points.kind == CURVE and settings.closed,
        "degree": degree,
        "method": method_of(points, settings),
        "tolerance": settings.tolerance,
        "name": "FreeCAD",
    }


def method_of(points: Points, settings: Settings) -> dict[str, Any]:
    """The method of a fit, and of its edits."""
    method: dict[str, Any] = {"kind": "least_squares", "control_points": "auto"}
    if settings.limit:
        method["max_control_points"] = settings.limit
    if settings.fairness:
        method["fairness"] = settings.fairness
    if points.kind != CURVE or not (settings.ends or settings.closed):
        method["end_points"] = "free"
    if points.moved and (settings.fairness or points.kind == CLOUD):
        # Among many points, or with smoothing, a single point would not move the shape.
        method["constraints"] = [{"index": points.index(i)} for i in points.moved]
    elif points.kind == CURVE and not settings.fairness:
        # Errors are then distances from the curve, and fewer control points suffice.
        method["correct_parameters"] = True
    return method


def fit(points: Points, settings: Settings) -> Update:
    """Waits for the end of a fit."""
    last: Update | None = None
    with server.client() as client:
        follower = Follower(client)
        try:
            for last in follower.updates(points, settings):
                pass
        finally:
            follower.forget()
    assert last is not None, "a fit has an iteration or raises"
    return last


def edit(job: Any, points: Points, moves: dict[int, Any], settings: Settings) -> Update:
    """Waits for the end of an edit with moved points."""
    method = method_of(points.with_moves(moves), settings)
    places = {points.index(i): list(point) for i, point in moves.items()}
    edited = job.edit(places, method=method)
    last: Any = None
    for last in edited.iterations(pace="latest"):
        pass
    update = _ended(edited, last)
    edited.delete()
    return update


def key(points: Points, settings: Settings) -> str:
    """A digest that is equal for equal fits, across sessions."""
    numbers = array("d", [x for point in points.values for x in point])
    head = repr((points.kind, points.rows, points.moved, settings.as_tuple()))
    return hashlib.sha256(head.encode() + numbers.tobytes()).hexdigest()

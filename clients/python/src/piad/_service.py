"""The client interface that both clients share, as coroutines."""

from __future__ import annotations

import inspect
import sys
import warnings
from collections.abc import AsyncGenerator, Coroutine, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple, Optional, Union

from . import _request
from ._request import ControlPoints, Corners, Knots, Method, Parameters, PerDirection, Rational, ScatteredParameters, SurfaceEnds
from ._transport import Transport
from .async_job import AsyncJob, post
from .batch import AsyncBatch, Items
from .errors import NotConverged
from .geometry import BasisKind
from .iteration import Result
from .points import FilePoints
from .status import State, Status

# The server is asked to wait up to this many seconds for the end of a job before it responds.
_WAIT = 10.0


class Service:
    """A server. `Transport` determines whether the methods are asynchronous or blocking."""

    def __init__(self, transport: Transport, timeout: float):
        self._transport = transport
        self._wait = min(_WAIT, timeout / 2)

    async def close(self) -> None:
        """Closes all connections. Jobs continue."""
        await self._transport.close()

    async def create(
        self,
        points: Any,
        *,
        basis: PerDirection[BasisKind] = "bspline",
        degree: Optional[PerDirection[int]] = None,
        knots: Optional[PerDirection[Knots]] = None,
        parameters: Union[PerDirection[Parameters], ScatteredParameters, None] = None,
        scattered: bool = False,
        sections: bool = False,
        spacing: Optional[Sequence[float]] = None,
        origin: Optional[Sequence[float]] = None,
        closed: Optional[PerDirection[bool]] = None,
        corners: Optional[Corners] = None,
        creases: Optional[Mapping[str, Sequence[int]]] = None,
        trim: Union[bool, Mapping[str, float]] = False,
        polyline: bool = False,
        order: Optional[str] = None,
        repeated_points: Optional[str] = None,
        ends: Optional[SurfaceEnds] = None,
        weights: Any = None,
        rational: Optional[Rational] = None,
        method: Optional[Method] = None,
        control_points: Optional[ControlPoints] = None,
        tolerance: Optional[float] = None,
        relative_tolerance: Optional[float] = None,
        max_iterations: Optional[int] = None,
        name: Optional[str] = None,
        stream: Optional[Mapping[str, Any]] = None,
        idempotency_key: Optional[str] = None,
    ) -> AsyncJob:
        """A new job.

        `points` of a curve have the shape (n, dimension), of a surface (rows, columns, dimension):
        an array or nested lists, in any unit. `scattered` points of a surface have the shape (n,
        dimension), and as `parameters` an array (n, 2), `"auto"`, `"project"`, `{"project": "cylinder"}`,
        `{"project": "xy"}`, `{"triangles": [[0, 1, 2], …]}` of a mesh or
        `{"foot_points": {"job": job.id}}`; least squares fits them. `sections` of a surface are arrays of points, each
        of its own length, with any start point and direction. With a `spacing` `(dx, dy)` they are heights, of the
        shape (rows, columns), with None for missing ones: x grows by dx from column to column and y by dy from row to
        row, starting at `origin` `(x, y)`. On surfaces `basis`, `degree`, `knots`, `parameters` and `closed` are one
        value for both directions or `{"u": …, "v": …}`. `tolerance` is in data units, `relative_tolerance` of the
        diagonal of their bounding box. `method` is a name or an object such as `{"kind": "local", "indices": [3, 4]}`;
        with `control_points`, a number (on surfaces also `{"u": …, "v": …}`) or `"auto"` for the fewest that meet the
        tolerance, it is `"least_squares"`. `ends` may be `"natural"` or `{"start": {"tangent": [1, 0, 0]}}`, with
        arrays or lists. A curve may have `corners`: indices of points, `"auto"` or `{"angle": 30}`; a surface may have
        `creases` at rows `u` and columns `v`: `{"u": [12]}`. With `trim` a surface is trimmed to the outline of its
        data: True, or `{"distance": 0.5}` in their unit. With `polyline` the edges are data, too: the fit has the
        fewest control points that meet the tolerance. With `order="nearest"` unordered points are first sorted along
        their curve; with `repeated_points="merge"` consecutive equal points are merged. Arguments that are not given
        get the server's defaults; docs/reference/job.md describes each.

        Requests have an `Idempotency-Key`, so a retry after a broken connection creates no second job; programs that
        may themselves restart can set `idempotency_key`.
        """
        stop = _request.stop(tolerance, relative_tolerance, max_iterations)
        body = _request.job(
            points,
            basis=basis,
            degree=degree,
            knots=knots,
            parameters=parameters,
            scattered=scattered,
            sections=sections,
            spacing=spacing,
            origin=origin,
            closed=closed,
            corners=corners,
            creases=creases,
            trim=trim,
            polyline=polyline,
            order=order,
            repeated_points=repeated_points,
            ends=ends,
            weights=weights,
            rational=rational,
            method=_request.with_control_points(method, control_points),
            stop=stop,
            name=name,
            stream=stream,
        )
        return await post(self._transport, "/v1/jobs", body, key=idempotency_key)

    def fit(
        self,
        points: Any,
        *,
        basis: PerDirection[BasisKind] = "bspline",
        degree: Optional[PerDirection[int]] = None,
        knots: Optional[PerDirection[Knots]] = None,
        parameters: Union[PerDirection[Parameters], ScatteredParameters, None] = None,
        scattered: bool = False,
        sections: bool = False,
        spacing: Optional[Sequence[float]] = None,
        origin: Optional[Sequence[float]] = None,
        closed: Optional[PerDirection[bool]] = None,
        corners: Optional[Corners] = None,
        creases: Optional[Mapping[str, Sequence[int]]] = None,
        trim: Union[bool, Mapping[str, float]] = False,
        polyline: bool = False,
        order: Optional[str] = None,
        repeated_points: Optional[str] = None,
        ends: Optional[SurfaceEnds] = None,
        weights: Any = None,
        rational: Optional[Rational] = None,
        method: Optional[Method] = None,
        control_points: Optional[ControlPoints] = None,
        tolerance: Optional[float] = None,
        relative_tolerance: Optional[float] = None,
        max_iterations: Optional[int] = None,
        name: Optional[str] = None,
        timeout: Optional[float] = None,
    ) -> Coroutine[Any, Any, Result]:
        """Creates a job and returns its result: see `create` for the arguments.

        Waits at most `timeout` seconds. A fit that has not reached its tolerance also returns a result, with the
        warning `NotConverged`: `warnings.simplefilter("error", piad.NotConverged)` turns it into an exception.
        """
        stop = _request.stop(tolerance, relative_tolerance, max_iterations)
        body = _request.job(
            points,
            basis=basis,
            degree=degree,
            knots=knots,
            parameters=parameters,
            scattered=scattered,
            sections=sections,
            spacing=spacing,
            origin=origin,
            closed=closed,
            corners=corners,
            creases=creases,
            trim=trim,
            polyline=polyline,
            order=order,
            repeated_points=repeated_points,
            ends=ends,
            weights=weights,
            rational=rational,
            method=_request.with_control_points(method, control_points),
            stop=stop,
            name=name,
            stream=None,
        )
        # In a task of its own, the coroutine has no caller on the stack.
        return self._fit(body, timeout, _caller())

    async def _fit(self, body: dict[str, Any], timeout: Optional[float], caller: _Caller) -> Result:
        wait = self._wait if timeout is None else min(self._wait, timeout)
        job = await post(self._transport, "/v1/jobs", body, wait=wait)
        result = await job.result(timeout)
        if result.state != "converged":
            _warn(_shortfall(job.status), caller)
        return result

    def batch(
        self,
        items: Items,
        defaults: Optional[Mapping[str, Any]] = None,
        *,
        degree: Optional[int] = None,
        method: Optional[Method] = None,
        control_points: Optional[ControlPoints] = None,
        tolerance: Optional[float] = None,
        relative_tolerance: Optional[float] = None,
        max_iterations: Optional[int] = None,
    ) -> AsyncBatch:
        """Fits many items, which is much faster than one request each. Returns an iterator over their results, in
        order.

        An item is an array or a list of points, as `create` takes them, or a job as JSON, such as
        `{"name": "a", "curve": {"points": points, "closed": True}}`. Items may come from a generator; they are read and
        sent in groups. `defaults` are job fields for items that do not set them; the other arguments are shorthands for
        such fields. Nothing is stored on the server.

        A failed item has a `problem` and does not end the batch. `totals` of the returned iterator counts the items so
        far.
        """
        common: dict[str, Any] = {name: _request.plain(value) for name, value in (defaults or {}).items()}
        stop = _request.stop(tolerance, relative_tolerance, max_iterations)
        if stop:
            common["stop"] = {**common.get("stop", {}), **stop}
        chosen = _request.with_control_points(method, control_points)
        if chosen is not None:
            common["method"] = _request.settings(chosen)
        if degree is not None:
            for kind in ("curve", "surface"):
                common[kind] = {**common.get(kind, {}), "degree": degree}
        return AsyncBatch(self._transport, items, common)

    async def job(self, id: str) -> AsyncJob:
        """The job with this id."""
        return AsyncJob(self._transport, Status.from_json(await self._transport.json("GET", f"/v1/jobs/{id}")))

    async def jobs(self, state: Optional[State] = None, *, page: int = 100) -> AsyncGenerator[AsyncJob, None]:
        """All jobs, newest first, fetched as they are used, `page` (1 to 1000) at a time."""
        parameters = _request.given({"state": state, "limit": str(page)})
        answer = await self._transport.json("GET", "/v1/jobs", parameters=parameters)
        while True:
            for job in answer["jobs"]:
                yield AsyncJob(self._transport, Status.from_json(job))
            if answer["next"] is None:
                return
            # The server may put its base path before the link, which the URL already has.
            more = answer["next"].partition("?")[2]
            answer = await self._transport.json("GET", f"/v1/jobs?{more}")

    async def read_points(
        self,
        file: Union[str, bytes, PathLike[str]],
        *,
        part: Union[int, str, None] = None,
        columns: Optional[str] = None,
        size: Optional[str] = None,
        sections: Optional[bool] = None,
        piece: Optional[int] = None,
        order: Optional[str] = None,
        times: bool = False,
        scattered: bool = False,
    ) -> FilePoints:
        """Reads the points of a file, for `create` and `fit`, with notes about how it was read.

        `file` is a path (`pathlib.Path`), bytes or text. `part` selects a curve of a file with several, by name or
        number from 1; `columns`, such as `"x=2,y=3"`, assigns the columns of a table; `size`, such as `"40x60"`, is the
        number of rows and columns of a surface; with `sections` the parts are sections of one surface; `piece` selects
        a connected piece of a mesh, 1 being the largest; `order="given"` skips the check of the order of points; with
        `times` the times of the points are their parameters; with `scattered` points without rows are those of a
        surface. Nothing is fitted. Errors in a file name their lines (`ApiError`).
        """
        parameters = _request.given(
            {
                "part": None if part is None else str(part),
                "columns": columns,
                "surface.size": size,
                "surface.sections": None if sections is None else str(sections).lower(),
                "piece": None if piece is None else str(piece),
                "curve.order": order,
                "curve.parameters": "time" if times else None,
                "surface.parameters": "auto" if scattered else None,
            }
        )
        text = Path(file).read_bytes() if isinstance(file, PathLike) else file
        answer = await self._transport.json("POST", "/v1/points", text=text, parameters=parameters)
        return FilePoints.from_json(answer)

    async def fit_file(
        self,
        file: Union[str, bytes, PathLike[str]],
        /,
        *,
        part: Union[int, str, None] = None,
        columns: Optional[str] = None,
        size: Optional[str] = None,
        piece: Optional[int] = None,
        times: bool = False,
        scattered: bool = False,
        **settings: Any,
    ) -> Result:
        """Fits a file and returns the result. See `read_points` for reading and `fit` for the `settings`."""
        order = settings.get("order")
        read = await self.read_points(
            file, part=part, columns=columns, size=size, piece=piece, order=order, times=times, scattered=scattered
        )
        settings.setdefault("name", read.name)
        if read.closed:
            settings.setdefault("closed", True)
        if read.parameters is not None:
            settings.setdefault("parameters", read.parameters)
        if read.scattered:
            settings["scattered"] = True
        return await self.fit(read.points, **settings)

    async def capabilities(self) -> dict[str, Any]:
        """The features and limits of the server, as JSON."""
        return await self._transport.json("GET", "/v1/capabilities")


def _shortfall(status: Status) -> str:
    """Describes how a fit that has not converged ended."""
    left = f"a distance of {status.error.max:.3e} is left, " if status.error else ""
    detail = status.detail or f"{left}the tolerance is {status.stop['tolerance']:.3e}"
    return f"the fit is {status.state}: {detail}"


class _Caller(NamedTuple):
    """A line of the calling program."""

    file: str
    line: int
    names: dict[str, Any]
    """The globals of its module."""


def _caller() -> _Caller:
    """The innermost calling line outside this package."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "piad":
        frame = frame.f_back
    return _Caller(frame.f_code.co_filename, frame.f_lineno, frame.f_globals)


def _warn(text: str, caller: _Caller) -> None:
    """Issues a warning about a fit at the line that requested it."""
    file, line, names = caller
    registry = names.setdefault("__warningregistry__", {})
    warnings.warn_explicit(text, NotConverged, file, line, names.get("__name__"), registry, names)


def _named_as_public() -> None:
    """Names the methods after the public class, for error messages and `help()`."""
    for name, method in vars(Service).items():
        if inspect.isfunction(method):
            method.__qualname__ = f"AsyncClient.{name.lstrip('_') if name == '_fit' else name}"
            method.__module__ = "piad.async_client"


_named_as_public()

"""The client interface that both clients share, as coroutines."""

from __future__ import annotations

import inspect
import sys
import warnings
from collections.abc import AsyncGenerator, Coroutine, Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union, cast

from . import _request
from ._settings import ControlPoints, FileSettings, Method, PointSettings, Reading, Settings, check_names, spelled_out
from ._transport import Transport
from .async_job import AsyncJob, post
from .batch import AsyncBatch, Items
from .errors import NotConverged
from .iteration import Result
from .points import FilePoints
from .status import State, Status

if TYPE_CHECKING:
    from typing_extensions import Unpack

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

    @spelled_out(Settings)
    def create(
        self,
        points: Any,
        *,
        stream: Optional[Mapping[str, Any]] = None,
        idempotency_key: Optional[str] = None,
        **settings: Unpack[Settings],
    ) -> Coroutine[Any, Any, AsyncJob]:
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
        check_names(Service.create, settings, Settings)
        body = _request.job(points, settings, stream=stream)
        return post(self._transport, "/v1/jobs", body, key=idempotency_key)

    @spelled_out(Settings)
    def fit(
        self, points: Any, *, timeout: Optional[float] = None, **settings: Unpack[Settings]
    ) -> Coroutine[Any, Any, Result]:
        """Creates a job and returns its result: see `create` for the arguments.

        Waits at most `timeout` seconds. A fit that has not reached its tolerance also returns a result, with the
        warning `NotConverged`: `warnings.simplefilter("error", piad.NotConverged)` turns it into an exception.
        """
        check_names(Service.fit, settings, Settings)
        body = _request.job(points, settings)
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
            common["method"] = _request.method_fields(chosen)
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

    @spelled_out(PointSettings)
    def read_points(
        self, file: Union[str, bytes, PathLike[str]], **settings: Unpack[PointSettings]
    ) -> Coroutine[Any, Any, FilePoints]:
        """Reads the points of a file, for `create` and `fit`, with notes about how it was read.

        `file` is a path, bytes or text: a string of several lines, or one that begins with `{`, `[` or `<`, is text;
        other strings are paths. `part` selects a curve of a file with several, by name or number from 1; `columns`,
        such as `"x=2,y=3"`, assigns the columns of a table; `size`, such as `"40x60"`, is the number of rows and columns
        of a surface; with `sections` the parts are sections of one surface; `piece` selects a connected piece of a mesh,
        1 being the largest; `order="given"` skips the check of the order of points; with `times` the times of the points
        are their parameters; with `scattered` points without rows are those of a surface. Nothing is fitted. Errors in a
        file name their lines (`ApiError`).
        """
        check_names(Service.read_points, settings, PointSettings)
        return self._read(file, settings)

    async def _read(self, file: Union[str, bytes, PathLike[str]], settings: PointSettings) -> FilePoints:
        part, sections = settings.get("part"), settings.get("sections")
        piece, scattered = settings.get("piece"), settings.get("scattered")
        parameters = _request.given(
            {
                "part": None if part is None else str(part),
                "columns": settings.get("columns"),
                "surface.size": settings.get("size"),
                "surface.sections": None if sections is None else str(bool(sections)).lower(),
                "piece": None if piece is None else str(piece),
                "curve.order": settings.get("order"),
                "curve.parameters": "time" if settings.get("times") else None,
                "surface.parameters": "auto" if scattered else None,
            }
        )
        answer = await self._transport.json("POST", "/v1/points", text=_content(file), parameters=parameters)
        return FilePoints.from_json(answer)

    @spelled_out(FileSettings)
    def fit_file(
        self,
        file: Union[str, bytes, PathLike[str]],
        /,
        *,
        timeout: Optional[float] = None,
        **settings: Unpack[FileSettings],
    ) -> Coroutine[Any, Any, Result]:
        """Fits a file and returns the result. See `read_points` for reading and `fit` for the other settings."""
        check_names(Service.fit_file, settings, FileSettings)
        return self._fit_file(file, timeout, settings, _caller())

    async def _fit_file(
        self, file: Union[str, bytes, PathLike[str]], timeout: Optional[float], settings: FileSettings, caller: _Caller
    ) -> Result:
        both = {name: value for name, value in settings.items() if name in PointSettings.__annotations__}
        read = await self._read(file, cast(PointSettings, both))
        fit = {name: value for name, value in settings.items() if name not in Reading.__annotations__}
        # The points of sections are those of a list, with the number of each section in the parameters.
        fit.pop("sections", None)
        fit.setdefault("name", read.name)
        if read.closed:
            fit.setdefault("closed", True)
        if read.parameters is not None:
            fit.setdefault("parameters", read.parameters)
        if read.scattered:
            fit["scattered"] = True
        return await self._fit(_request.job(read.points, cast(Settings, fit)), timeout, caller)

    async def capabilities(self) -> dict[str, Any]:
        """The features and limits of the server, as JSON."""
        return await self._transport.json("GET", "/v1/capabilities")


def _content(file: Union[str, bytes, PathLike[str]]) -> Union[str, bytes]:
    """Returns the content of a file, given its path or its content."""
    if isinstance(file, bytes):
        return file
    if isinstance(file, str) and ("\n" in file or file.lstrip().startswith(("{", "[", "<"))):
        return file
    return Path(file).read_bytes()


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
            public = name.lstrip("_") if name in ("_fit", "_fit_file") else name
            method.__qualname__ = f"AsyncClient.{public}"
            method.__module__ = "piad.async_client"


_named_as_public()

"""Jobs, for asyncio."""

from __future__ import annotations

import os
import time
import uuid
from collections.abc import AsyncGenerator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Optional, Union

from . import _request
from ._arrays import np
from ._events import EventStream
from ._settings import Method, Rational, SampleCount
from ._transport import Transport
from .curvature import CurveShape, SurfaceShape, shape_from_json
from .errors import JobFailed, Problem, WaitTimeout
from .iteration import Deviation, Index, Iteration, Result, Samples, Shape
from .status import Status

View = Literal["control_points", "samples", "errors"]
Encoding = Literal["json", "base64", "base64_f32", "delta"]
Format = Literal["json", "step", "iges", "obj", "gltf", "stl", "ply", "dxf", "svg", "geojson", "gpx", "csv"]
Dots = Literal["auto", "on", "off"]
Units = Literal["mm", "m", "in"]

# Settings of streams that override those of the job.
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
# No job has this many iterations, so the stream has the first and the last only.
_ENDS_ONLY = {**_PLAIN, "every": "1000000000"}
_COMPLETE = {**_PLAIN, "view": "control_points", "encoding": "json" if np is None else "base64"}
_CHANGES = {**_PLAIN, "view": "control_points", "changed": "true", "describe": "none"}


class AsyncJob:
    """A job and its operations: `Job` with coroutines."""

    def __init__(self, transport: Transport, status: Status):
        self._transport = transport
        self._shape: Optional[Shape] = None
        self.status = status
        """The last state received from the server; `refresh` updates it."""

    def __repr__(self) -> str:
        return f"<piad.AsyncJob {self.id}: {self.status.state}>"

    @property
    def id(self) -> str:
        """The id."""
        return self.status.id

    @property
    def _path(self) -> str:
        return f"/v1/jobs/{self.id}"

    async def refresh(self) -> Status:
        """Fetches the current state of the job."""
        self.status = Status.from_json(await self._transport.json("GET", self._path))
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
    ) -> AsyncGenerator[Iteration, None]:
        """The iterations of the job, as they are computed, until it ends.

        Each one from 0 (or after `after`) arrives once and in order, unless `every`, `milestones` (decreasing
        distances) or `pace="latest"` skip some. The stream resumes after broken connections and restarts of the server.
        When the iterator ends, `status` is that of the ended job.

        With `changed` the server sends only control points that have moved; the iterations returned are complete.
        Numbers are sent as base64 if numpy is installed, unless the job has a `stream` setting or other parameters
        exclude it. With `encoding="delta"` they take about a tenth of the bytes: an iteration is accurate to a
        hundredth of its largest error, and the last one is exact.
        """
        parameters = {
            "view": view,
            "samples": None if samples is None else _request.grid(samples),
            "every": every,
            "milestones": None if milestones is None else ",".join(repr(float(m)) for m in milestones),
            "pace": pace,
            "changed": None if changed is None else str(bool(changed)).lower(),
            "encoding": encoding,
            "digits": digits,
        }
        text = {name: str(value) for name, value in _request.given(parameters).items()}
        if "describe" in (self.status.stream or {}):
            # Knots are needed, whatever the job sets for its streams.
            text["describe"] = "full"
        if self._may_be_binary(text):
            text["encoding"] = "base64"
        return self._iterations(text, after)

    def _may_be_binary(self, parameters: Mapping[str, str]) -> bool:
        """True if base64 is compatible with these parameters and faster to read."""
        decimal = {"encoding", "digits", "changed"} & parameters.keys() or parameters.get("view") == "errors"
        return np is not None and self.status.stream is None and not decimal

    async def _iterations(
        self, parameters: Mapping[str, str], after: Optional[int]
    ) -> AsyncGenerator[Iteration, None]:
        before: Optional[Iteration] = None
        shape: Optional[Shape] = None
        async with self._events(parameters, after).open() as events:
            async for name, data in events:
                if name == "job":
                    self._shape = shape = Shape.from_json(data)
                elif name == "iteration":
                    before = Iteration.from_json(data, shape or await self.shape(), before)
                    shape = before.shape
                    yield before
        await self.refresh()

    def _events(self, parameters: Mapping[str, str], after: Optional[int] = None) -> EventStream:
        return EventStream(self._transport, f"{self._path}/events", parameters, after=after)

    async def shape(self) -> Shape:
        """The bases of the fit. Waits until the job has started."""
        if self._shape is None:
            async with self._events(_ENDS_ONLY).open() as events:
                async for name, data in events:
                    if name == "job":
                        self._shape = Shape.from_json(data)
                        break
                else:
                    raise JobFailed(self.id, (await self.refresh()).state, self.status.problem)
        return self._shape

    async def iteration(self, number: Union[int, Literal["last"]] = "last") -> Iteration:
        """One iteration with its geometry, of a job in any state; waits for one that is not computed yet."""
        parameters = {} if np is None else {"encoding": "base64"}
        data = await self._level(number, parameters)
        return Iteration.from_json(data, await self.shape())

    async def samples(self, count: SampleCount, iteration: Union[int, Literal["last"]] = "last") -> Samples:
        """Points at equal steps of the parameters, computed by the server."""
        parameters = {"view": "samples", "samples": _request.grid(count)}
        if np is not None:
            parameters["encoding"] = "base64"
        return Samples.from_json(await self._level(iteration, parameters))

    async def _level(self, number: Union[int, str], parameters: Mapping[str, str]) -> dict[str, Any]:
        return await self._transport.json("GET", f"{self._path}/iterations/{number}", parameters=parameters)

    async def wait(self, timeout: Optional[float] = None) -> Status:
        """Waits until the job has ended; raises `WaitTimeout` after `timeout` seconds."""
        if timeout is None:
            async with self._events(_ENDS_ONLY).open() as events:
                async for _ in events:
                    pass
            return await self.refresh()
        deadline, pause = time.monotonic() + timeout, 0.01
        while not (await self.refresh()).ended:
            left = deadline - time.monotonic()
            if left <= 0:
                raise WaitTimeout(f"the job {self.id} is {self.status.state} after {timeout} s")
            await self._transport.sleep(min(pause, left))
            pause = min(1.5 * pause, 1.0)
        return self.status

    async def result(self, timeout: Optional[float] = None) -> Result:
        """The last iteration. Waits at most `timeout` seconds for the end of the job.

        A cancelled job has a result if it computed an iteration. Raises `JobFailed` if there is none.
        """
        status = self.status if self.status.ended else await self.wait(timeout)
        if status.state == "failed" or status.iteration is None:
            raise JobFailed(self.id, status.state, status.problem)
        parameters = {} if np is None else {"encoding": "base64"}
        answer = await self._transport.json("GET", f"{self._path}/result", parameters=parameters)
        result = Result.from_json(answer)
        if self._transport.blocks:
            result.geometry.export_by(self.download)
        return result

    async def deviation(self, iteration: Union[int, Literal["last"]] = "last", *, distances: bool = False) -> Deviation:
        """The distances of the data from the nearest points of an iteration, with `distances` also of each point.

        The `error` of an iteration is measured at the parameters of the data and is larger.
        """
        parameters = {"iteration": str(iteration), "list": str(bool(distances)).lower()}
        return Deviation.from_json(await self._transport.json("GET", f"{self._path}/deviation", parameters=parameters))

    async def curvature(
        self,
        iteration: Union[int, Literal["last"]] = "last",
        *,
        samples: Optional[SampleCount] = None,
        spacing: Optional[float] = None,
        by_length: bool = False,
    ) -> Union[CurveShape, SurfaceShape]:
        """The shape of an iteration: curvatures at samples and their extremes, length or area, continuity.

        `samples` is a number for a curve (200 by default) or two for a surface (40 × 40); samples of a curve can be
        `spacing` apart, in data units, or at equal arc lengths with `by_length`. Extremes do not depend on the samples.
        """
        parameters = {"iteration": str(iteration)}
        if samples is not None:
            parameters["samples"] = _request.grid(samples)
        if spacing is not None:
            parameters["spacing"] = repr(float(spacing))
        if by_length:
            parameters["by"] = "length"
        return shape_from_json(await self._transport.json("GET", f"{self._path}/shape", parameters=parameters))

    async def input(self) -> dict[str, Any]:
        """The request that created the job, as JSON."""
        return await self._transport.json("GET", f"{self._path}/input")

    async def ticket(self) -> str:
        """Returns a ticket that opens the stream of the job for one minute without a token, as for a browser's
        `EventSource`.

        Pass it as the query parameter `ticket` of `/v1/jobs/{id}/events`. Raises `ApiError` with status 409 if the
        server requires no tokens.
        """
        ticket: str = (await self._transport.json("POST", f"{self._path}/tickets"))["ticket"]
        return ticket

    async def cancel(self) -> Status:
        """Cancels the job. Raises `ApiError` with status 409 if it has already ended otherwise."""
        self.status = Status.from_json(await self._transport.json("POST", f"{self._path}/cancel"))
        return self.status

    async def delete(self) -> None:
        """Deletes the job."""
        await self._transport.request("DELETE", self._path)

    async def edit(
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
    ) -> AsyncJob:
        """Creates a job that starts from the control points of this one; other settings are kept.

        `points` moves data points, `{17: [x, y, z]}` or on surfaces `{(row, column): …}`;
        `point_weights` changes some weights of a homogeneous fit, `weights` all. `iteration` is the one to start from,
        by default the last.
        """
        body = _request.edit(
            points,
            point_weights=point_weights,
            weights=weights,
            rational=rational,
            method=method,
            stop=_request.stop(tolerance, relative_tolerance, max_iterations),
            iteration=iteration,
            name=name,
            stream=stream,
        )
        return await post(self._transport, f"{self._path}/edits", body, key=idempotency_key)

    async def preview(
        self,
        points: Optional[Mapping[Index, Any]] = None,
        *,
        start: Optional[Iteration] = None,
        session: Optional[str] = None,
        every: int = 1,
        pace: Literal["all", "latest"] = "all",
        point_weights: Optional[Mapping[Index, float]] = None,
        method: Optional[Method] = None,
        tolerance: Optional[float] = None,
        relative_tolerance: Optional[float] = None,
        max_iterations: Optional[int] = None,
    ) -> AsyncGenerator[Iteration, None]:
        """The iterations of an edit that is not stored, as while a point is dragged.

        Closing the iterator ends the fit. A fit with a `session` replaces the previous one of that session, whose
        iterator then ends. `start` is the iteration of this job to start from, by default the last; if it is given,
        only control points that move are sent. `every=1000000` returns only the last iteration, `pace="latest"` skips
        iterations that arrive faster than they are read. If the connection breaks after the first iteration,
        `ConnectionLost` is raised: send the newest position again.
        """
        body = _request.edit(
            points,
            point_weights=point_weights,
            method=method,
            stop=_request.stop(tolerance, relative_tolerance, max_iterations),
            iteration=None if start is None else start.number,
            ephemeral=True,
            session=session,
        )
        # Changes are relative to the previous iteration, so none may be skipped.
        complete = (every, pace) == (1, "all") and start is not None and start.control_points is not None
        before = start if complete else None
        shape = None if before is None else before.shape
        parameters = {**_COMPLETE, "every": str(every), "pace": pace} if before is None else _CHANGES
        stream, id = EventStream(self._transport, f"{self._path}/edits/stream", parameters, body=body), ""
        async with stream.open() as events:
            async for name, data in events:
                if name == "job":
                    id = data["id"]
                    shape = shape or Shape.from_json(data)
                elif name == "iteration" and shape is not None:
                    before = Iteration.from_json(data, shape, before)
                    shape = before.shape
                    yield before
                elif data.get("problem") is not None:
                    raise JobFailed(id, data["state"], Problem.from_json(data["problem"]))

    async def download(
        self,
        format: Format,
        path: Union[str, os.PathLike[str]],
        *,
        iteration: Union[int, Literal["last"], None] = None,
        samples: Optional[SampleCount] = None,
        dots: Optional[Dots] = None,
        units: Optional[Units] = None,
    ) -> Path:
        """Writes the result (or an iteration) to a file, such as STEP for CAD systems; docs/reference/files.md has the formats.

        `samples` is the number of points in gltf, stl, ply, dxf, svg, geojson, gpx and csv, `dots` shows data points
        in svg or hides them, `units` is the unit that step and iges declare. The file is written completely or not at
        all.
        """
        part = "result" if iteration is None else f"iterations/{iteration}"
        parameters: dict[str, str] = {}
        if samples is not None:
            parameters["samples"] = _request.grid(samples)
        if dots is not None:
            parameters["dots"] = dots
        if units is not None:
            parameters["units"] = units
        headers = {"Accept": "*/*"}
        answer = await self._transport.request("GET", f"{self._path}/{part}/{format}", headers=headers, parameters=parameters)
        target = Path(path)
        unfinished = target.with_name(f"{target.name}.{uuid.uuid4().hex}.part")
        try:
            unfinished.write_bytes(answer.content)
            unfinished.replace(target)
        finally:
            unfinished.unlink(missing_ok=True)
        return target


async def post(
    transport: Transport,
    path: str,
    body: Mapping[str, Any],
    *,
    key: Optional[str] = None,
    wait: Optional[float] = None,
) -> AsyncJob:
    """Creates a job. Its key makes retries create a single job.

    With `wait` the server responds when the job has ended, at the latest after this many seconds.
    """
    headers = {"Idempotency-Key": str(uuid.uuid4()) if key is None else key}
    if wait is not None and wait >= 1.0:
        headers["Prefer"] = f"wait={int(wait)}"
    return AsyncJob(transport, Status.from_json(await transport.json("POST", path, body=body, headers=headers)))

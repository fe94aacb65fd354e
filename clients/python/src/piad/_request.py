"""Builds the JSON of a job from arguments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Optional

from ._arrays import as_lists, depth
from ._settings import ControlPoints, Method, Rational, SampleCount, Settings
from .iteration import Index

# Settings of the curve or the surface that are sent as they are.
_OF_THE_SHAPE = (
    "spacing",
    "origin",
    "parameters",
    "closed",
    "corners",
    "creases",
    "order",
    "repeated_points",
    "ends",
    "weights",
)


def job(points: Any, settings: Settings, *, stream: Optional[Mapping[str, Any]] = None) -> dict[str, Any]:
    """A body for `POST /v1/jobs`. Arguments that are None get the server's defaults."""
    every: Mapping[str, Any] = settings
    it = every.get
    scattered, sections, spacing = it("scattered", False), it("sections", False), it("spacing")
    kind = "surface" if scattered or sections or spacing is not None else _kind(points)
    if scattered and depth(points) != 2:
        raise ValueError(f"scattered points are a list of points (2 dimensions), these have {depth(points)}")
    shape = {
        "sections" if sections else "scattered" if scattered else "points": _lists(points, sections, spacing),
        "basis": _bases(it("basis") or "bspline", it("degree"), it("knots")),
        **{name: plain(it(name)) for name in _OF_THE_SHAPE},
        "trim": plain(it("trim")) or None,
        "polyline": it("polyline") or None,
    }
    method = with_control_points(it("method"), it("control_points"))
    stop_ = stop(it("tolerance"), it("relative_tolerance"), it("max_iterations"))
    return given(
        {
            "name": it("name"),
            kind: given(shape),
            "rational": it("rational"),
            "method": None if method is None else method_fields(method),
            "stop": stop_ or None,
            "stream": stream,
        }
    )


def _lists(points: Any, sections: bool, spacing: Optional[Sequence[float]]) -> Any:
    """Points as lists; sections may have different lengths."""
    if sections:
        return [as_lists(section) for section in points]
    return as_lists(points) if spacing is None else _heights(points)


def _heights(heights: Any) -> Any:
    """Converts rows of heights to rows of points with one coordinate, since short rows would be read as points."""
    if depth(heights) != 2:
        raise ValueError(f"heights with a spacing are rows of numbers (2 dimensions), these have {depth(heights)}")
    return [[None if z is None else [z] for z in row] for row in as_lists(heights)]


def shape_alone(points: Any) -> dict[str, Any]:
    """A job of points alone."""
    return {_kind(points): {"points": as_lists(points)}}


def _kind(points: Any) -> Literal["curve", "surface"]:
    dimensions = depth(points)
    if dimensions == 2:
        return "curve"
    if dimensions == 3:
        return "surface"
    raise ValueError(
        f"points have {dimensions} dimensions: a curve is a list of points (2), a surface rows of points (3)"
    )


def _bases(basis: Any, degree: Any, knots: Any) -> Any:
    """One basis, or `{"u": …, "v": …}` if any of its settings is given per direction."""
    if not any(map(_is_each, (basis, degree, knots))):
        return _basis(basis, degree, knots)
    return {way: _basis(*(_of(it, way) for it in (basis, degree, knots))) for way in ("u", "v")}


def _basis(kind: str, degree: Any, knots: Any) -> dict[str, Any]:
    return given({"kind": kind, "degree": None if degree is None else int(degree), "knots": plain(knots)})


def _is_each(value: Any) -> bool:
    return isinstance(value, Mapping)


def _of(value: Any, way: str) -> Any:
    return value[way] if _is_each(value) else value


def stop(
    tolerance: Optional[float], relative_tolerance: Optional[float], max_iterations: Optional[int]
) -> dict[str, Any]:
    """The stopping criteria of a fit."""
    return given(
        {
            "tolerance": tolerance,
            "relative_tolerance": relative_tolerance,
            "max_iterations": max_iterations,
        }
    )


def edit(
    points: Optional[Mapping[Index, Any]],
    *,
    point_weights: Optional[Mapping[Index, float]],
    weights: Any = None,
    rational: Optional[Rational] = None,
    method: Optional[Method],
    stop: Mapping[str, Any],
    **more: Any,
) -> dict[str, Any]:
    """A body for `POST /v1/jobs/{id}/edits`. Arguments that are None keep the values of the job."""
    return given(
        {
            "points": _moves(points or {}, point_weights or {}) or None,
            "weights": plain(weights),
            "rational": rational,
            "method": None if method is None else method_fields(method),
            "stop": dict(stop) or None,
            **more,
        }
    )


def _moves(points: Mapping[Index, Any], weights: Mapping[Index, float]) -> list[dict[str, Any]]:
    return [
        given({"index": plain(index), "point": plain(points.get(index)), "weight": weights.get(index)})
        for index in {**points, **weights}
    ]


def grid(count: SampleCount) -> str:
    """A number of samples as a query parameter."""
    return str(count) if isinstance(count, int) else "x".join(map(str, as_lists(count)))


def method_fields(method: Method) -> dict[str, Any]:
    """A method with its settings."""
    if isinstance(method, str):
        return {"kind": method}
    return {name: plain(value) for name, value in method.items()}


def with_control_points(method: Optional[Method], control_points: Optional[ControlPoints]) -> Optional[Method]:
    """Sets the number of control points; the default method is then least squares."""
    if control_points is None:
        return method
    fields = method_fields("least_squares" if method is None else method)
    if "control_points" in fields:
        raise ValueError("control_points are given twice: beside the method and in it")
    return {**fields, "control_points": control_points}


def plain(value: Any) -> Any:
    """Converts arrays to lists, also within objects and lists; other values are unchanged."""
    if _is_each(value):
        return {name: plain(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)) and any(map(_is_each, value)):
        return [plain(part) for part in value]
    return as_lists(value)


def given(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Removes entries that are None."""
    return {name: value for name, value in fields.items() if value is not None}

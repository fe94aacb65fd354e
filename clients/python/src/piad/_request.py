"""Builds the JSON of a job from arguments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Optional, TypeVar, Union

from ._arrays import as_lists, depth
from .geometry import BasisKind
from .iteration import Index

T = TypeVar("T")

PerDirection = Union[T, Mapping[Literal["u", "v"], T]]
"""One value, for both directions of a surface, or `{"u": …, "v": …}`."""

MethodKind = Literal[
    "global",
    "weighted",
    "local",
    "adaptive",
    "extended",
    "transpose",
    "convex",
    "chebyshev",
    "direct",
    "least_squares",
    "custom",
]
Method = Union[MethodKind, Mapping[str, Any]]
"""The name of a method, or an object with its settings: `{"kind": "weighted", "omega": 1.2}`."""

ControlPoints = Union[PerDirection[int], Literal["auto"]]
"""The number of control points of least squares; "auto": the fewest that meet the tolerance."""

Rational = Literal["homogeneous", "fixed"]
Knots = Union[Literal["data", "averaged", "spread", "adaptive"], Sequence[float]]
End = Union[Literal["estimated", "repeated", "natural"], Mapping[str, Any]]
"""The end condition on one side of a direction: a name, or an object with a `derivative`, `derivatives` or a
`tangent`."""
Ends = Union[Literal["estimated", "repeated", "natural"], Mapping[Literal["start", "end"], End]]
"""The end conditions of a direction: a name for both sides, or an object with one for each side."""
SurfaceEnds = Union[Ends, Mapping[Literal["u", "v"], Ends]]
"""The end conditions of a surface: those of a curve, for both directions or for each."""
Corners = Union[Literal["auto"], Mapping[Literal["angle"], float], Sequence[int]]
"""The corners of a curve: "auto", a smallest angle in degrees, or indices of points."""
Parameters = Union[Literal["chord_length", "centripetal", "uniform"], Sequence[float]]
ScatteredParameters = Union[
    Literal["auto", "project"],
    Mapping[Literal["project", "axis", "center"], Any],
    Mapping[Literal["pairs", "domains"], Any],
    Mapping[Literal["sections"], Sequence[int]],
    Mapping[Literal["triangles", "unfolding"], Any],
    Mapping[Literal["foot_points"], Mapping[str, Any]],
    Sequence[Sequence[float]],
]
"""Parameters of scattered points: u and v of each, shape (n, 2); `"auto"`; the surface they are on, such as
`{"project": "cylinder", "axis": [0, 0, 1]}`, the triangles of the mesh with these vertices,
`{"triangles": [[0, 1, 2], …]}`, or a job whose surface gives their foot points:
`{"foot_points": {"job": job.id}}`."""

SampleCount = Union[int, tuple[int, int]]
"""The number of samples of a curve, or the numbers in u and v of a surface."""


def job(
    points: Any,
    *,
    basis: PerDirection[BasisKind],
    degree: Optional[PerDirection[int]],
    knots: Optional[PerDirection[Knots]],
    parameters: Union[PerDirection[Parameters], ScatteredParameters, None],
    scattered: bool,
    sections: bool,
    spacing: Optional[Sequence[float]],
    origin: Optional[Sequence[float]],
    closed: Optional[PerDirection[bool]],
    corners: Optional[Corners],
    creases: Optional[Mapping[str, Sequence[int]]],
    trim: Union[bool, Mapping[str, float]],
    polyline: bool,
    order: Optional[str],
    repeated_points: Optional[str],
    ends: Optional[SurfaceEnds],
    weights: Any,
    rational: Optional[Rational],
    method: Optional[Method],
    stop: Mapping[str, Any],
    name: Optional[str],
    stream: Optional[Mapping[str, Any]],
) -> dict[str, Any]:
    """A body for `POST /v1/jobs`. Arguments that are None get the server's defaults."""
    kind = "surface" if scattered or sections or spacing is not None else _kind(points)
    if scattered and depth(points) != 2:
        raise ValueError(f"scattered points are a list of points (2 dimensions), these have {depth(points)}")
    shape = {
        "sections" if sections else "scattered" if scattered else "points": _lists(points, sections, spacing),
        "spacing": plain(spacing),
        "origin": plain(origin),
        "basis": _bases(basis, degree, knots),
        "parameters": plain(parameters),
        "closed": plain(closed),
        "corners": plain(corners),
        "creases": plain(creases),
        "trim": plain(trim) or None,
        "polyline": polyline or None,
        "order": order,
        "repeated_points": repeated_points,
        "ends": plain(ends),
        "weights": plain(weights),
    }
    return given(
        {
            "name": name,
            kind: given(shape),
            "rational": rational,
            "method": None if method is None else settings(method),
            "stop": dict(stop) or None,
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
            "method": None if method is None else settings(method),
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


def settings(method: Method) -> dict[str, Any]:
    """A method with its settings."""
    if isinstance(method, str):
        return {"kind": method}
    return {name: plain(value) for name, value in method.items()}


def with_control_points(method: Optional[Method], control_points: Optional[ControlPoints]) -> Optional[Method]:
    """Sets the number of control points; the default method is then least squares."""
    if control_points is None:
        return method
    fields = settings("least_squares" if method is None else method)
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

"""The settings of fits, with their types, defined once for all functions that take them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, Optional, TypedDict, TypeVar, Union

from .geometry import BasisKind

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


class Settings(TypedDict, total=False):
    """Settings of a fit; missing ones and those that are None get the server's defaults."""

    basis: PerDirection[BasisKind]
    degree: Optional[PerDirection[int]]
    knots: Optional[PerDirection[Knots]]
    parameters: Union[PerDirection[Parameters], ScatteredParameters, None]
    scattered: bool
    sections: bool
    spacing: Optional[Sequence[float]]
    origin: Optional[Sequence[float]]
    closed: Optional[PerDirection[bool]]
    corners: Optional[Corners]
    creases: Optional[Mapping[str, Sequence[int]]]
    trim: Union[bool, Mapping[str, float]]
    polyline: bool
    order: Optional[str]
    repeated_points: Optional[str]
    ends: Optional[SurfaceEnds]
    weights: Any
    rational: Optional[Rational]
    method: Optional[Method]
    control_points: Optional[ControlPoints]
    tolerance: Optional[float]
    relative_tolerance: Optional[float]
    max_iterations: Optional[int]
    name: Optional[str]


class Reading(TypedDict, total=False):
    """How the points of a file are read."""

    part: Union[int, str, None]
    columns: Optional[str]
    size: Optional[str]
    piece: Optional[int]
    times: bool


class PointSettings(Reading, total=False):
    """Settings of `read_points`."""

    sections: Optional[bool]
    order: Optional[str]
    scattered: bool


class FileSettings(Reading, Settings, total=False):
    """Settings of `fit_file`: how the file is read, and those of the fit."""


F = TypeVar("F", bound=Callable[..., Any])


def spelled_out(settings: type) -> Callable[[F], F]:
    """Gives a function that takes `**settings` a signature with each of them, for `help()` and completions."""

    def decorate(function: F) -> F:
        signature = inspect.signature(function)
        kind = inspect.Parameter.KEYWORD_ONLY
        each = [
            inspect.Parameter(name, kind, default=None, annotation=getattr(type_, "__forward_arg__", type_))
            for name, type_ in settings.__annotations__.items()
        ]
        others = [it for it in signature.parameters.values() if it.kind is not inspect.Parameter.VAR_KEYWORD]
        function.__signature__ = signature.replace(parameters=[*others, *each])  # type: ignore[attr-defined]
        return function

    return decorate


def check_names(function: Callable[..., Any], given: Mapping[str, Any], settings: type) -> None:
    """Raises a `TypeError` that names the function if one of these settings is unknown."""
    for name in given:
        if name not in settings.__annotations__:
            raise TypeError(f"{function.__qualname__}() got an unexpected keyword argument {name!r}")

"""The shape of curves and surfaces, from the JSON of the server: curvature, length, area and continuity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Optional, Union

from ._arrays import Array, as_array

Parameter = Union[float, tuple[float, float]]
"""A parameter of a curve, or two of a surface."""


@dataclass(frozen=True)
class CurvatureExtreme:
    """A location with a curvature."""

    parameter: Parameter
    point: tuple[float, ...]
    value: float

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> CurvatureExtreme:
        """Parses a location."""
        parameter = value["parameter"]
        place: Parameter = (parameter[0], parameter[1]) if isinstance(parameter, list) else parameter
        return cls(place, tuple(value["point"]), value["value"])


@dataclass(frozen=True)
class CurvatureExtremes:
    """The extremes of a curvature; None if it is undefined everywhere."""

    smallest: Optional[CurvatureExtreme]
    largest: Optional[CurvatureExtreme]

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> CurvatureExtremes:
        """Parses both."""
        places = [value["smallest"], value["largest"]]
        return cls(*(None if place is None else CurvatureExtreme.from_json(place) for place in places))


@dataclass(frozen=True)
class KnotContinuity:
    """The continuity of a curve at a knot: guaranteed and measured."""

    parameter: float
    point: tuple[float, ...]
    multiplicity: int
    guaranteed: int
    """The order that the multiplicity guarantees; -1 allows a gap."""
    parametric: int
    """The order C that was found, measured up to 2."""
    geometric: int
    """The order G that was found: 0 is a corner, 1 the same tangent, 2 the same curvature."""
    gap: float
    """The distance between both sides."""
    angle: Optional[float]
    """The angle between the tangents in degrees; None where a derivative vanishes."""
    curvature: tuple[Optional[float], Optional[float]]
    """On the left and right of the knot."""
    jump: Optional[float]
    """The distance between the curvature vectors of both sides."""

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> KnotContinuity:
        """Reads a knot."""
        known = {name: value[name] for name in cls.__dataclass_fields__}
        return cls(**{**known, "point": tuple(value["point"]), "curvature": tuple(value["curvature"])})


@dataclass(frozen=True)
class KnotLine:
    """The continuity of a surface across the line at a knot."""

    parameter: float
    multiplicity: int
    guaranteed: int
    """The order that the multiplicity guarantees; -1 allows a gap."""
    angle: Optional[float]
    """The largest angle between the normals of both sides in degrees, where no tangent plane is guaranteed."""

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> KnotLine:
        """Reads a line."""
        return cls(**{name: value[name] for name in cls.__dataclass_fields__})


@dataclass(frozen=True)
class CurveShape:
    """The curvature of a curve, its length and its continuity. Curvature is NaN where a derivative vanishes."""

    iteration: int
    length: float
    extremes: CurvatureExtremes
    degenerate: tuple[float, ...]
    """Parameters at which the derivative vanishes, near which the curvature may be unbounded."""
    knots: tuple[KnotContinuity, ...]
    """Inner knots, and where a closed curve returns to its start; of more than 10,000 the least smooth."""
    parameters: Array
    points: Array
    curvature: Array
    """In the plane positive where the curve turns left, otherwise never negative."""

    def __repr__(self) -> str:
        return f"<piad.CurveShape of iteration {self.iteration}: {len(self.parameters)} samples, length {self.length:.6g}>"

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> CurveShape:
        """Reads the answer."""
        samples = value["samples"]
        return cls(
            value["iteration"],
            _number(value["length"]),
            CurvatureExtremes.from_json(value["curvature"]),
            tuple(value["degenerate"]),
            tuple(KnotContinuity.from_json(knot) for knot in value["continuity"]["knots"]),
            as_array(samples["parameters"]),
            as_array(samples["points"]),
            as_array(samples["curvature"]),
        )


@dataclass(frozen=True)
class SurfaceShape:
    """The curvatures of a surface, its area and its continuity. Curvatures are NaN where there is no normal.

    They are positive where the surface bends towards its normal, the product of the derivatives by u and by v.
    """

    iteration: int
    area: float
    extremes: Mapping[str, CurvatureExtremes]
    """Of `k1`, `k2`, `gaussian` and `mean`."""
    degenerate: tuple[tuple[float, float], ...]
    """Parameters at which there is no normal, near which curvatures may be unbounded."""
    knots: tuple[tuple[KnotLine, ...], tuple[KnotLine, ...]]
    """The lines at inner knots of u and of v."""
    parameters: tuple[Array, Array]
    """Of the rows and of the columns."""
    points: Array
    k1: Array
    """The larger principal curvature, in rows."""
    k2: Array
    """The smaller principal curvature."""
    gaussian: Array
    """k1 k2"""
    mean: Array
    """(k1 + k2) / 2"""

    def __repr__(self) -> str:
        rows, columns = map(len, self.parameters)
        return f"<piad.SurfaceShape of iteration {self.iteration}: {rows} × {columns} samples, area {self.area:.6g}>"

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> SurfaceShape:
        """Reads the answer."""
        samples, continuity = value["samples"], value["continuity"]
        lines = [tuple(KnotLine.from_json(line) for line in continuity[way]["knots"]) for way in "uv"]
        return cls(
            value["iteration"],
            _number(value["area"]),
            {name: CurvatureExtremes.from_json(both) for name, both in value["curvature"].items()},
            tuple((u, v) for u, v in value["degenerate"]),
            (lines[0], lines[1]),
            (as_array(samples["parameters"]["u"]), as_array(samples["parameters"]["v"])),
            *(as_array(samples[name]) for name in ("points", "k1", "k2", "gaussian", "mean")),
        )


def shape_from_json(value: Mapping[str, Any]) -> Union[CurveShape, SurfaceShape]:
    """Reads the answer."""
    return CurveShape.from_json(value) if value["kind"] == "curve" else SurfaceShape.from_json(value)


def _number(value: Optional[float]) -> float:
    """Converts null to NaN: the number is out of range."""
    return float("nan") if value is None else value

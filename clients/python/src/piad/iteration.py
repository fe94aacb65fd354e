"""Iterations, samples and results, from the JSON of the server."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from typing import Any, Optional, TypeVar, Union

from ._arrays import Array, as_array, as_lists, copy, from_base64, np, outer, size
from ._deltas import moved
from .errors import ProtocolError
from .geometry import Basis, Boundary, Curve, Surface
from .geometry.boundary import Side

Geometry = Union[Curve, Surface]
Index = Union[int, tuple[int, int]]
"""The number of a data point; on surfaces its row and column."""


@dataclass(frozen=True)
class Distances:
    """The distances of a curve or surface from its data points at their parameters, in data units.

    A distance is None where it is infinite, because a weight of a homogeneous fit is not positive.
    """

    max: Optional[float]
    rms: Optional[float]
    """Root mean square."""
    sum: Optional[float]
    at: Index
    """The point with the largest distance."""
    fixed_max: Optional[float] = None
    """Local fits: the largest distance of the points that are not adjusted."""
    homogeneous: Optional[float] = None
    """Homogeneous fits: the largest distance in homogeneous coordinates."""
    gradient: Optional[float] = None
    """Least squares: zero at the minimum."""
    transformed: Optional[float] = None
    """Extended fits with `transformed_error`: the largest move of a control point in the next iteration."""
    between: Optional[float] = None
    """At the end: by how much the fit deviates between neighbouring data points, beyond what the data leave open."""

    @property
    def brief(self) -> str:
        """The largest distance as text."""
        return "error infinite" if self.max is None else f"error at most {self.max:.3e}"

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Distances:
        """Reads `error`."""
        at = value["at"]
        names = ("fixed_max", "homogeneous", "gradient", "transformed", "between")
        more = {name: value.get(name) for name in names}
        return cls(value["max"], value["rms"], value["sum"], _index(at), **more)


@dataclass(frozen=True)
class Deviation:
    """The distances of the data from the nearest points of a curve or surface, in data units."""

    iteration: int
    max: float
    rms: float
    """Root mean square."""
    at: Index
    """The point with the largest distance."""
    percentiles: Mapping[int, float]
    """The 50th, 90th, 95th and 99th percentiles of the distances."""
    distances: Any = None
    """The distance of each data point, if requested: an array, or nested lists without numpy; NaN or None for a missing
    point."""
    between: Any = None
    """By how much the fit leaves the data in each gap between neighbours, or cell of a grid, beyond their freedom."""

    def __repr__(self) -> str:
        return f"<piad.Deviation of iteration {self.iteration}: at most {self.max:.3e}, rms {self.rms:.3e}>"

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Deviation:
        """Reads the answer."""
        percentiles = {int(name): number for name, number in value["percentiles"].items()}
        lists = [value.get("distances"), value.get("between")]
        if np is not None:
            lists = [None if it is None else np.asarray(it, dtype=float) for it in lists]
        return cls(value["iteration"], value["max"], value["rms"], _index(value["at"]), percentiles, *lists)


@dataclass(frozen=True)
class Trim:
    """The region of a trimmed surface: the parameters to the left of all loops."""

    loops: tuple[Curve, ...]
    """Closed curves in u and v; empty if nothing is trimmed off."""
    faces: tuple[tuple[int, ...], ...]
    """The connected pieces, by indices of loops: the outer one and those of holes."""
    area: Optional[float]
    """The area of the region, of surfaces in the plane and in space."""
    distance: float
    """The largest distance of the outline from the data, in data units."""

    def __repr__(self) -> str:
        return f"<piad.Trim of {len(self.loops)} loops, area {self.area}>"

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Trim:
        """Reads `trim`."""
        loops = (
            Curve(Basis("bspline", it["degree"], tuple(it["knots"]), True), as_array(it["control_points"]), None)
            for it in value["loops"]
        )
        faces = ((it["outer"], *it["holes"]) for it in value["faces"])
        return cls(tuple(loops), tuple(faces), value.get("area"), value["distance"])


def _index(value: Any) -> Index:
    return (value[0], value[1]) if isinstance(value, list) else value


@dataclass(frozen=True)
class Shape:
    """The parts that are constant over iterations: bases and fixed weights."""

    bases: tuple[Basis, ...]
    """One of a curve, two of a surface."""
    fixed_weights: Optional[Array]
    """Shape (n,), or (rows, columns) of a surface; end copies included."""

    def __repr__(self) -> str:
        return f"<piad.Shape of {' × '.join(f'{basis.kind} {basis.degree}' for basis in self.bases)}>"

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Shape:
        """Parses the data of the `job` event, or a result."""
        ways = [None] if value["kind"] == "curve" else ["u", "v"]
        bases = tuple(_basis(value, way) for way in ways)
        weights = value.get("weights") if value["rational"] == "fixed" else None
        return cls(bases, None if weights is None else _fixed_weights(value, weights, bases))

    def with_knots(self, knots: Any) -> Shape:
        """The same with the knots of an iteration, if the fit chooses them."""
        lines = [knots] if len(self.bases) == 1 else [knots["u"], knots["v"]]
        bases = tuple(replace(basis, knots=_knots(line)) for basis, line in zip(self.bases, lines))
        return Shape(bases, self.fixed_weights)

    def with_net(self, points: Array, weights: Optional[Array]) -> Geometry:
        """The curve or surface of these control points."""
        weights = self.fixed_weights if weights is None else weights
        if len(self.bases) == 1:
            return Curve(self.bases[0], points, weights)
        return Surface((self.bases[0], self.bases[1]), points, weights)


def _basis(value: Mapping[str, Any], way: Optional[str]) -> Basis:
    parts = (value["basis"], value["degree"], value["knots"], value["closed"])
    kind, degree, knots, closed = parts if way is None else (part[way] for part in parts)
    return Basis(kind, degree, _knots(knots), closed)


def _knots(knots: Any) -> Optional[tuple[float, ...]]:
    if isinstance(knots, str):
        knots = _line_of(knots, 8)
    return None if knots is None else tuple(as_lists(knots))


def _fixed_weights(value: Mapping[str, Any], weights: Any, bases: tuple[Basis, ...]) -> Array:
    """Weights of surfaces are products of those of rows and columns; a direction may lack them."""
    if len(bases) == 1:
        return _line(value, weights)
    u, v = (
        _line(value, weights[way]) if weights[way] else as_array([1.0] * basis.count)
        for way, basis in zip(("u", "v"), bases)
    )
    return outer(list(u), list(v))


def _line(value: Mapping[str, Any], numbers: Any) -> Array:
    if isinstance(numbers, str):
        return _line_of(numbers, 4 if value["encoding"] == "base64_f32" else 8)
    return as_array(numbers)


def _line_of(text: str, width: int) -> Array:
    """Decodes base64 numbers of this many bytes."""
    count = (len(text) // 4 * 3 - text.count("=")) // width
    return from_base64(text, [count], single=width == 4)


@dataclass(frozen=True, eq=False)
class Samples:
    """Points at equal steps of the parameters."""

    parameters: tuple[Array, ...]
    """Those of a curve, or those of u and of v."""
    points: Array
    """Shape (n, dimension), or (rows, columns, dimension) of a surface."""

    def __repr__(self) -> str:
        return f"<piad.Samples {size(self.points)}>"

    @classmethod
    def from_json(cls, value: Mapping[str, Any], before: Optional[Samples] = None) -> Samples:
        """Parses an iteration with `view=samples`. Differences are added to the samples `before`."""
        if value.get("encoding") == "delta":
            before = _known(before)
            return cls(before.parameters, _moved(value, "samples", "step", before.points))
        parameters = value["parameters"]
        lines = [parameters["u"], parameters["v"]] if isinstance(parameters, dict) else [parameters]
        return cls(tuple(_line(value, line) for line in lines), _array(value, "samples"))


_T = TypeVar("_T")


def _known(before: Optional[_T]) -> _T:
    if before is None:
        raise ProtocolError("the server sent changes before what has changed")
    return before


def _moved(value: Mapping[str, Any], name: str, step: str, before: Array) -> Array:
    """Decodes an array of an iteration that is sent as differences."""
    dimension = 1 if name == "weights" else value["shape"][-1]
    return moved(before, value[step], value[name], dimension)


def _array(value: Mapping[str, Any], name: str, dropped: int = 0) -> Array:
    """Decodes an array of the geometry, from lists or base64, without the last `dropped` axes of `shape`."""
    numbers = value[name]
    if not isinstance(numbers, str):
        return as_array(numbers)
    shape = value["shape"][: len(value["shape"]) - dropped]
    return from_base64(numbers, shape, single=value["encoding"] == "base64_f32")


@dataclass(frozen=True)
class BadWeight:
    """A control point of a homogeneous fit whose weight CAD kernels do not accept."""

    control_point: Index
    weight: float


def _bad_weight(value: Mapping[str, Any]) -> Optional[BadWeight]:
    bad = value.get("bad_weight")
    if bad is None:
        return None
    place = bad["control_point"]
    return BadWeight(tuple(place) if isinstance(place, list) else place, bad["weight"])


@dataclass(frozen=True, eq=False)
class Iteration:
    """An iteration of a fit."""

    number: int
    """Counted from 0."""
    error: Distances
    moved: int
    """The number of control points moved by the step to this iteration."""
    rate: Optional[float] = None
    """The factor by which the step has reduced the largest distance."""
    milestone: Optional[float] = None
    """The smallest milestone first reached by this iteration."""
    bad_weight: Optional[BadWeight] = None
    control_points: Optional[Array] = None
    """Complete, of shape (n, dimension) or (rows, columns, dimension); None in other views."""
    weights: Optional[Array] = None
    """Those of a homogeneous fit, of shape (n,) or (rows, columns)."""
    samples: Optional[Samples] = None
    """With `view="samples"`."""
    shape: Optional[Shape] = None
    predicted: Optional[int] = None
    """The total number of iterations, as predicted at this iteration."""

    def __repr__(self) -> str:
        return f"<piad.Iteration {self.number}: {self.error.brief}>"

    @classmethod
    def from_json(cls, value: Mapping[str, Any], shape: Shape, before: Optional[Iteration] = None) -> Iteration:
        """Parses the data of an `iteration` event. One that contains only changes is applied to the iteration `before`.
        `shape` is that of the previous iteration, whose knots this one may change.
        """
        shape = shape.with_knots(value["knots"]) if "knots" in value else shape
        points, weights = _net(value, before)
        return cls(
            value["iteration"],
            Distances.from_json(value["error"]),
            value["moved"],
            value.get("rate"),
            value.get("milestone"),
            _bad_weight(value),
            points,
            weights,
            Samples.from_json(value, None if before is None else before.samples) if "samples" in value else None,
            shape,
            value.get("predicted"),
        )

    @cached_property
    def geometry(self) -> Geometry:
        """The curve or surface. Raises `ValueError` if the view has no control points."""
        if self.control_points is None or self.shape is None:
            raise ValueError('this iteration has no control points: it was requested with another view')
        return self.shape.with_net(self.control_points, self.weights)


def _net(value: Mapping[str, Any], before: Optional[Iteration]) -> tuple[Optional[Array], Optional[Array]]:
    if value.get("encoding") == "delta" and "control_points" in value:
        points = _known(_known(before).control_points)
        weights = _known(before).weights
        if weights is not None:
            weights = _moved(value, "weights", "weight_step", weights)
        return _moved(value, "control_points", "step", points), weights
    if "control_points" in value:
        weights = _array(value, "weights", 1) if "weights" in value else None
        return _array(value, "control_points"), weights
    if "changed" not in value:
        return None, None
    before = _known(before)
    points = copy(_known(before.control_points))
    weights = None if before.weights is None else copy(before.weights)
    for place, point, *weight in value["changed"]:
        _set(points, place, as_array(point))
        if weights is not None:
            _set(weights, place, weight[0])
    return points, weights


def _set(net: Any, place: Any, value: Any) -> None:
    if isinstance(place, list):
        row, column = place
        net[row][column] = value
    else:
        net[place] = value


@dataclass(frozen=True, eq=False)
class Result:
    """The last iteration of a fit that has ended."""

    id: str
    """The job."""
    name: Optional[str]
    state: str
    """"converged", "exhausted", "stalled", "failed" or "cancelled"."""
    iteration: int
    error: Distances
    geometry: Geometry
    parameters: tuple[Array, ...]
    """The parameters of the data points: of a curve, or of u and v."""
    bad_weight: Optional[BadWeight] = None
    fairness: Optional[float] = None
    """The smoothing of a least-squares fit, also if it was chosen automatically."""
    outliers: tuple[int, ...] = ()
    """The points that a robust fit ignores, at most the first 1000."""
    trim: Optional[Trim] = None
    """The trimmed region of a surface."""

    def __repr__(self) -> str:
        return f"<piad.Result {self.id}: {self.state} after iteration {self.iteration}, {self.error.brief}>"

    def _repr_html_(self) -> str:
        """Itself in notebooks."""
        return f"<div>{escape(repr(self))}</div>{self.geometry._repr_html_()}"

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Result:
        """Reads a result."""
        lines = value["parameters"]
        lines = [lines["u"], lines["v"]] if isinstance(lines, dict) else [lines]
        shape = Shape.from_json(value)
        homogeneous = value["rational"] == "homogeneous"
        weights = _array(value, "weights", 1) if homogeneous else None
        return cls(
            value["id"],
            value["name"],
            value["state"],
            value["iteration"],
            Distances.from_json(value["error"]),
            shape.with_net(_array(value, "control_points"), weights),
            tuple(_line_of(line, 8) if isinstance(line, str) else as_array(line) for line in lines),
            _bad_weight(value),
            value.get("fairness"),
            tuple(value.get("outliers", {}).get("indices", ())),
            Trim.from_json(value["trim"]) if "trim" in value else None,
        )

    @property
    def curve(self) -> Curve:
        """The curve. Raises `TypeError` for a surface."""
        if not isinstance(self.geometry, Curve):
            raise TypeError("the job fitted a surface, not a curve")
        return self.geometry

    @property
    def surface(self) -> Surface:
        """The surface. Raises `TypeError` for a curve."""
        if not isinstance(self.geometry, Surface):
            raise TypeError("the job fitted a curve, not a surface")
        return self.geometry


def boundary(fitted: Union[Result, Iteration, Surface], side: Side) -> Boundary:
    """The boundary of a fitted surface at "u_start", "u_end", "v_start" or "v_end", to fit a neighbour to:
    `boundary(result, "u_end").constraints("u_start")`.
    """
    geometry = fitted if isinstance(fitted, Surface) else fitted.geometry
    if not isinstance(geometry, Surface):
        raise TypeError("the job fitted a curve, which has no boundaries")
    return geometry.boundary(side)

"""Points of the selection: vertices, wires, sketches, point clouds and meshes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import FreeCAD
import Part

translate = FreeCAD.Qt.translate

CURVE, GRID, CLOUD = "curve", "grid", "cloud"

Point = tuple[float, float, float]
Links = Sequence[tuple[Any, Sequence[str]]]
"""Objects of a document with the names of their elements, as in a `PropertyLinkSubList`."""


class PointsError(Exception):
    """The selection has no points for a fit."""


@dataclass(frozen=True)
class Points:
    """The points of a fit, in millimetres."""

    kind: str
    """`CURVE`, `GRID` (rows of points) or `CLOUD` (in any order)."""
    values: tuple[Point, ...]
    """The points; those of a grid row by row."""
    rows: int = 0
    """The number of rows of a grid."""
    closed: bool = False
    """True for the points of a closed wire."""
    moved: tuple[int, ...] = ()
    """The indices of dragged points."""

    @property
    def columns(self) -> int:
        """The number of points in a row of a grid."""
        return len(self.values) // self.rows if self.rows else 0

    @property
    def shortest(self) -> int:
        """The number of points in the direction with the fewest."""
        if self.kind == GRID:
            return min(self.rows, self.columns)
        return len(self.values) if self.kind == CURVE else math.isqrt(len(self.values))

    @property
    def are_numbers(self) -> bool:
        """True if all coordinates are finite."""
        return all(math.isfinite(x) for point in self.values for x in point)

    @property
    def size(self) -> float:
        """The diagonal of the bounding box of the finite points."""
        finite = [point for point in self.values if all(map(math.isfinite, point))]
        return math.dist([min(c) for c in zip(*finite)], [max(c) for c in zip(*finite)]) if finite else 0.0

    def nested(self) -> list[Any]:
        """A list of points, or of a grid its rows."""
        flat = [list(point) for point in self.values]
        if self.kind != GRID:
            return flat
        return [flat[i : i + self.columns] for i in range(0, len(flat), self.columns)]

    def index(self, flat: int) -> Any:
        """The index of a point in the API: for a grid, its row and column."""
        return divmod(flat, self.columns) if self.kind == GRID else flat

    def with_moves(self, moves: dict[int, Point]) -> Points:
        """The same with moved points. Moves of missing points are ignored."""
        values = list(self.values)
        moved = tuple(index for index in moves if index < len(values))
        for index in moved:
            values[index] = tuple(moves[index])
        return replace(self, values=tuple(values), moved=tuple(dict.fromkeys((*self.moved, *moved))))


def read_curve(links: Links) -> Points:
    """The points of a curve, in the order of selection or along a wire."""
    values: list[Point] = []
    closed = False
    for obj, names in links:
        vertices = [name for name in names if name.startswith("Vertex")]
        edges = [name for name in names if name.startswith("Edge")]
        if vertices:
            values += _tuples(_shape(obj).getElement(name).Point for name in vertices)
        elif edges:
            part, closed = _along(_sorted(_shape(obj).getElement(name) for name in edges))
            values += part
        elif hasattr(obj, "Points") and hasattr(obj.Points, "CountPoints"):
            values += _tuples(obj.Points.Points)
        else:
            part, closed = _of_shape(obj)
            values += part
    if len(values) < 2:
        raise PointsError(translate("piad", "Select two points or more, a wire, a sketch or a list of points."))
    return Points(CURVE, tuple(values), closed=closed and len(links) == 1)


def read_surface(links: Links) -> Points:
    """The points of a cloud or mesh; in rows and columns if they form a grid."""
    clouds = [_cloud(obj) for obj, _ in links]
    values = tuple(point for cloud in clouds for point in cloud)
    if len(values) < 4:
        raise PointsError(translate("piad", "Select a point cloud or a mesh with four points or more."))
    grid = _grid(links[0][0], values) if len(links) == 1 else None
    return grid or Points(CLOUD, values)


def _cloud(obj: Any) -> list[Point]:
    if hasattr(obj, "Mesh"):
        return _tuples(obj.Mesh.Topology[0])
    if hasattr(obj, "Points") and hasattr(obj.Points, "CountPoints"):
        return _tuples(obj.Points.Points)
    return _tuples(vertex.Point for vertex in _shape(obj).Vertexes)


def _grid(obj: Any, values: tuple[Point, ...]) -> Points | None:
    """The grid of a structured cloud, or of points whose x and y form a grid; otherwise None."""
    complete = all(math.isfinite(x) for point in values for x in point)
    width, height = getattr(obj, "Width", 0), getattr(obj, "Height", 0)
    if complete and min(width, height) > 1 and width * height == len(values):
        return Points(GRID, values, height)
    places = {(x, y) for x, y, _ in values}
    xs, ys = {x for x, _ in places}, {y for _, y in places}
    if complete and min(len(xs), len(ys)) > 1 and len(places) == len(xs) * len(ys) == len(values):
        return Points(GRID, tuple(sorted(values, key=lambda point: (point[1], point[0]))), len(ys))
    return None


def _shape(obj: Any) -> Any:
    shape = getattr(obj, "Shape", None)
    if shape is None or shape.isNull():
        raise PointsError(translate("piad", "{} has no points.").format(obj.Label))
    return shape


def _of_shape(obj: Any) -> tuple[list[Point], bool]:
    """The vertices of the only wire of an object, or points without edges."""
    shape = _shape(obj)
    if not shape.Edges:
        return _tuples(vertex.Point for vertex in shape.Vertexes), False
    return _along(_sorted(shape.Edges))


def _sorted(edges: Iterable[Any]) -> Any:
    chains = Part.sortEdges(list(edges))
    if len(chains) != 1:
        raise PointsError(translate("piad", "The selected edges are not one wire."))
    return Part.Wire(chains[0])


def _along(wire: Any) -> tuple[list[Point], bool]:
    """The vertices of a wire in order, without repeating the first one."""
    return _tuples(vertex.Point for vertex in wire.OrderedVertexes), wire.isClosed()


def _tuples(vectors: Iterable[Any]) -> list[Point]:
    return [(vector.x, vector.y, vector.z) for vector in vectors]

"""Curves and surfaces of OpenNURBS, with rhino3dm.

OpenNURBS omits the first and last knot, which have no effect, and stores control
points in homogeneous coordinates.
"""

from __future__ import annotations

from typing import Any

from .._arrays import as_lists
from ._optional import load
from .net import in_space
from .shapes import CurveLike, SurfaceLike


def curve(it: CurveLike) -> Any:
    """Points of the plane get z = 0."""
    rhino = load("rhino3dm", "rhino3dm")
    spline = it.as_bspline()
    points = as_lists(spline.control_points)
    made = rhino.NurbsCurve(3, spline.weights is not None, spline.degree + 1, len(points))
    for i, point in enumerate(points):
        made.Points[i] = _point(rhino, point, 1.0 if spline.weights is None else spline.weights[i])
    _set_knots(made.Knots, spline.knots)
    return made


def surface(it: SurfaceLike) -> Any:
    """Points of the plane get z = 0."""
    rhino = load("rhino3dm", "rhino3dm")
    spline = it.as_bspline()
    rows = as_lists(spline.control_points)
    (u, v), rational = spline.degrees, spline.weights is not None
    made = rhino.NurbsSurface.Create(3, rational, u + 1, v + 1, len(rows), len(rows[0]))
    for i, row in enumerate(rows):
        for j, point in enumerate(row):
            weight = 1.0 if spline.weights is None else spline.weights[i][j]
            made.Points[i, j] = _point(rhino, point, weight)
    for knots, values in zip((made.KnotsU, made.KnotsV), spline.knots):
        _set_knots(knots, values)
    return made


def _point(rhino: Any, point: list[float], weight: float) -> Any:
    w = float(weight)
    x, y, z = in_space(point)
    return rhino.Point4d(x * w, y * w, z * w, w)


def _set_knots(knots: Any, values: tuple[float, ...]) -> None:
    for i, knot in enumerate(values[1:-1]):
        knots[i] = knot

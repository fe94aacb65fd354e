"""Converts fits to shapes of FreeCAD."""

from __future__ import annotations

from math import ceil
from typing import Any

import FreeCAD
import Part


def part_curve(curve: Any) -> Any:
    """A `Part.BSplineCurve`. Closed curves get clamped knots, which all of Part supports."""
    curve = curve.as_bspline()
    poles = [_vector(point) for point in curve.control_points]
    knots, counts = _multiplicities(curve.knots)
    spline = Part.BSplineCurve()
    spline.buildFromPolesMultsKnots(poles, counts, knots, False, curve.degree)
    if curve.closed:
        spline.segment(*map(float, curve.domain))
    return spline


def part_surface(surface: Any) -> Any:
    """A `Part.BSplineSurface`."""
    surface = surface.as_bspline()
    poles = [[_vector(point) for point in row] for row in surface.control_points]
    (u, counts_u), (v, counts_v) = map(_multiplicities, surface.knots)
    spline = Part.BSplineSurface()
    spline.buildFromPolesMultsKnots(poles, counts_u, counts_v, u, v, False, False, *surface.degrees)
    return spline


def part_geometry(geometry: Any) -> Any:
    """A curve or a surface of Part."""
    return part_surface(geometry) if hasattr(geometry, "degrees") else part_curve(geometry)


def curve_samples(spline: Any) -> list[Any]:
    """Points along a curve of Part, close enough to look smooth."""
    return [spline.value(t) for t in _parameters(spline.getKnots(), 300, spline.FirstParameter, spline.LastParameter)]


def surface_samples(spline: Any) -> list[list[Any]]:
    """Rows of points of a surface of Part."""
    u0, u1, v0, v1 = spline.bounds()
    us = _parameters(spline.getUKnots(), 60, u0, u1)
    vs = _parameters(spline.getVKnots(), 60, v0, v1)
    return [[spline.value(u, v) for v in vs] for u in us]


def _parameters(knots: list[float], wanted: int, first: float, last: float) -> list[float]:
    """About this number of parameters, including each knot, where the shape may have corners."""
    knots = [first, *(knot for knot in knots if first < knot < last), last]
    steps = max(1, ceil(wanted / (len(knots) - 1)))
    inner = [a + (b - a) * i / steps for a, b in zip(knots, knots[1:]) for i in range(steps)]
    return [*inner, last]


def _vector(point: Any) -> Any:
    return FreeCAD.Vector(*map(float, point))


def _multiplicities(knots: Any) -> tuple[list[float], list[int]]:
    """Distinct knots and their multiplicities."""
    distinct: list[float] = []
    counts: list[int] = []
    for knot in map(float, knots):
        if distinct and distinct[-1] == knot:
            counts[-1] += 1
        else:
            distinct.append(knot)
            counts.append(1)
    return distinct, counts

"""Splines of scipy."""

from __future__ import annotations

from typing import Any

from . import net
from ._optional import load
from .shapes import CurveLike, SurfaceLike


def curve(it: CurveLike, *, homogeneous: bool) -> Any:
    """A BSpline: knots, coefficients, degree."""
    interpolate = load("scipy.interpolate", "scipy")
    spline = it.as_bspline()
    coefficients = _coefficients(spline, homogeneous=homogeneous)
    extrapolate = "periodic" if it.closed else True
    return interpolate.BSpline(spline.knots, coefficients, spline.degree, extrapolate=extrapolate)


def surface(it: SurfaceLike, *, homogeneous: bool) -> Any:
    """An NdBSpline, whose coefficients have the axes u, v and coordinate."""
    interpolate = load("scipy.interpolate", "scipy")
    numpy = load("numpy", "numpy")
    spline = it.as_bspline()
    coefficients = _coefficients(spline, homogeneous=homogeneous)
    knots = tuple(numpy.asarray(knots) for knots in spline.knots)
    return interpolate.NdBSpline(knots, coefficients, spline.degrees)


def _coefficients(spline: CurveLike | SurfaceLike, *, homogeneous: bool) -> Any:
    if spline.weights is None:
        return spline.control_points
    if not homogeneous:
        raise ValueError("scipy has no rational splines: ask for homogeneous=True and divide by the last coordinate")
    return net.homogeneous(spline.control_points, spline.weights)

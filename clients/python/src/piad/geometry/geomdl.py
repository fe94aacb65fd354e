"""Curves and surfaces of geomdl (NURBS-Python)."""

from __future__ import annotations

from typing import Any

from .._arrays import as_lists
from . import net
from ._optional import load
from .shapes import CurveLike, SurfaceLike


def curve(it: CurveLike) -> Any:
    """Keeps the knots; geomdl would otherwise scale them to [0, 1]."""
    spline = it.as_bspline()
    made = _module(spline).Curve(normalize_kv=False)
    made.degree = spline.degree
    made.set_ctrlpts(_points(spline))
    made.knotvector = list(spline.knots)
    return made


def surface(it: SurfaceLike) -> Any:
    """Passes the control points as one list, row by row."""
    spline = it.as_bspline()
    made = _module(spline).Surface(normalize_kv=False)
    made.degree_u, made.degree_v = spline.degrees
    rows = _points(spline)
    made.set_ctrlpts([point for row in rows for point in row], len(rows), len(rows[0]))
    u, v = spline.knots
    made.knotvector_u, made.knotvector_v = list(u), list(v)
    return made


def _module(spline: CurveLike | SurfaceLike) -> Any:
    return load("geomdl.BSpline" if spline.weights is None else "geomdl.NURBS", "geomdl")


def _points(spline: CurveLike | SurfaceLike) -> Any:
    return as_lists(net.homogeneous(spline.control_points, spline.weights))

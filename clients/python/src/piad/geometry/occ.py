"""Curves and surfaces of OpenCASCADE, with OCP (as in CadQuery and build123d)."""

from __future__ import annotations

from typing import Any

from .._arrays import as_lists
from ._optional import load
from .basis import multiplicities
from .net import in_space
from .shapes import CurveLike, SurfaceLike

_MOST_DEGREE = 25
_PACKAGE = "cadquery-ocp"

# Array types by their names in OCP 8, which has one module, and the modules of OCP 7.
_ARRAYS = {
    "Array1_gp_Pnt": ("OCP.TColgp", "TColgp_Array1OfPnt"),
    "Array2_gp_Pnt": ("OCP.TColgp", "TColgp_Array2OfPnt"),
    "Array1_double": ("OCP.TColStd", "TColStd_Array1OfReal"),
    "Array2_double": ("OCP.TColStd", "TColStd_Array2OfReal"),
    "Array1_int": ("OCP.TColStd", "TColStd_Array1OfInteger"),
}


def curve(it: CurveLike) -> Any:
    """Distinct knots with their multiplicities. Points of the plane get z = 0."""
    geom = load("OCP.Geom", _PACKAGE)
    spline = it.as_bspline()
    _check_degree(spline.degree)
    points = as_lists(spline.control_points)
    poles = _array("Array1_gp_Pnt", 1, len(points))
    for i, point in enumerate(points, 1):
        poles.SetValue(i, _point(point))
    knots, counts = _knots(spline.knots)
    if spline.weights is None:
        return geom.Geom_BSplineCurve(poles, knots, counts, spline.degree)
    weights = _reals([float(w) for w in spline.weights])
    return geom.Geom_BSplineCurve(poles, weights, knots, counts, spline.degree)


def surface(it: SurfaceLike) -> Any:
    """Distinct knots with their multiplicities. Points of the plane get z = 0."""
    geom = load("OCP.Geom", _PACKAGE)
    spline = it.as_bspline()
    for degree in spline.degrees:
        _check_degree(degree)
    rows = as_lists(spline.control_points)
    poles = _array("Array2_gp_Pnt", 1, len(rows), 1, len(rows[0]))
    for i, row in enumerate(rows, 1):
        for j, point in enumerate(row, 1):
            poles.SetValue(i, j, _point(point))
    (u, counts_u), (v, counts_v) = map(_knots, spline.knots)
    numbers = (u, v, counts_u, counts_v, *spline.degrees)
    if spline.weights is None:
        return geom.Geom_BSplineSurface(poles, *numbers)
    weights = _array("Array2_double", 1, len(rows), 1, len(rows[0]))
    for i, line in enumerate(as_lists(spline.weights), 1):
        for j, weight in enumerate(line, 1):
            weights.SetValue(i, j, weight)
    return geom.Geom_BSplineSurface(poles, weights, *numbers)


def _check_degree(degree: int) -> None:
    if degree > _MOST_DEGREE:
        raise ValueError(f"OpenCASCADE has no degree {degree}: {_MOST_DEGREE} is the highest")


def _array(name: str, *bounds: int) -> Any:
    module, former = _ARRAYS[name]
    kind = getattr(load(module, _PACKAGE), former, None)
    return (kind or getattr(load("OCP.collections", _PACKAGE), name))(*bounds)


def _point(point: list[float]) -> Any:
    return load("OCP.gp", _PACKAGE).gp_Pnt(*in_space(point))


def _reals(values: list[float]) -> Any:
    array = _array("Array1_double", 1, len(values))
    for i, value in enumerate(values, 1):
        array.SetValue(i, value)
    return array


def _knots(knots: tuple[float, ...]) -> tuple[Any, Any]:
    distinct = multiplicities(knots)
    counts = _array("Array1_int", 1, len(distinct))
    for i, (_, count) in enumerate(distinct, 1):
        counts.SetValue(i, count)
    return _reals([knot for knot, _ in distinct]), counts

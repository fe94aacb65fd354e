"""Plots of curves and surfaces with matplotlib, if it is installed."""

from __future__ import annotations

from typing import Any

from .._arrays import np
from ._optional import load
from .basis import Basis
from .shapes import EvaluatedCurve, EvaluatedSurface

_NET = {"color": "0.55", "linewidth": 0.8}


def curve_plot(
    curve: EvaluatedCurve, ax: Any, net: bool, data: Any, samples: int, style: dict[str, Any]
) -> Any:
    """Draws a curve, its control points and data; returns the axes."""
    parameters = np.linspace(*curve.domain, samples)
    points, controls = curve.evaluate(parameters), curve.control_points
    if curve.dimension == 1:
        spline = curve.as_bspline()
        points = np.column_stack([parameters, points])
        controls = np.column_stack([_abscissas(spline.basis), spline.control_points])
    if curve.dimension > 3:
        return _coordinates(parameters, points, ax, data, style)
    ax = axes_of(ax, points.shape[-1])
    if net:
        ax.plot(*controls.T, "o--", **{**_NET, "markersize": 3, "label": "control points"})
    ax.plot(*points.T, **{"label": "curve", **style})
    _finish(ax, data, equal=curve.dimension > 1)
    ax.legend()
    return ax


def _coordinates(parameters: Any, points: Any, ax: Any, data: Any, style: dict[str, Any]) -> Any:
    """Draws each of more than three coordinates over the parameter."""
    if data is not None:
        raise ValueError("data with more than three coordinates have no place in a plot: leave data out")
    ax = axes_of(ax, 2)
    for i, values in enumerate(points.T):
        ax.plot(parameters, values, **{"label": f"x{i + 1}", **style})
    ax.set_xlabel("t")
    ax.legend()
    return ax


def surface_plot(
    surface: EvaluatedSurface, ax: Any, net: bool, data: Any, samples: int, style: dict[str, Any]
) -> Any:
    """Draws a surface, its control points and data; returns the axes."""
    u, v = (np.linspace(*interval, samples) for interval in surface.domain)
    points, controls = surface.evaluate(u, v), surface.control_points
    if surface.dimension == 1:
        spline = surface.as_bspline()
        points = _over(u, v, points)
        rows, columns = map(_abscissas, spline.bases)
        controls = _over(rows, columns, spline.control_points)
    ax = axes_of(ax, points.shape[-1])
    if points.shape[-1] == 2:
        # About ten lines in each direction.
        _lines(ax, points, max(1, samples // 10), style)
        if net:
            _lines(ax, controls, 1, {**_NET, "linestyle": "--"})
    else:
        ax.plot_surface(*np.moveaxis(points, -1, 0), **{"color": "C0", "alpha": 0.7, **style})
        if net:
            ax.plot_wireframe(*np.moveaxis(controls, -1, 0), **_NET)
    _finish(ax, data, equal=surface.dimension > 1)
    return ax


def axes_of(ax: Any, dimension: int) -> Any:
    """Creates axes for points of this dimension."""
    projection = "3d" if dimension == 3 else None
    pyplot = load("matplotlib.pyplot", "piad[plot]")
    if ax is None:
        return pyplot.figure().add_subplot(projection=projection)
    if projection is not None and ax.name != projection:
        raise ValueError('points in space need axes that are made with projection="3d"')
    return ax


def _finish(ax: Any, data: Any, *, equal: bool) -> None:
    if data is not None:
        points = np.asarray(data, dtype=float)
        ax.plot(*points.reshape(-1, points.shape[-1]).T, "k.", markersize=4, label="data")
    if equal:
        ax.set_aspect("equal")


def _lines(ax: Any, points: Any, step: int, style: dict[str, Any]) -> None:
    """Rows and columns of points in the plane; the last ones, too."""
    style = {"color": "C0", "linewidth": 1.0, **style}
    for grid in (points, np.swapaxes(points, 0, 1)):
        for i in sorted({*range(0, len(grid), step), len(grid) - 1}):
            ax.plot(*grid[i].T, **style)


def _over(u: Any, v: Any, values: Any) -> Any:
    """Values as heights over a grid of parameters."""
    return np.concatenate([np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1), values], axis=-1)


def _abscissas(basis: Basis) -> Any:
    """The Greville abscissae of control points of values: means of `degree` knots."""
    knots, degree = basis.full_knots(), basis.degree
    return np.array([np.mean(knots[i + 1 : i + degree + 1]) if degree else knots[i] for i in range(basis.count)])

"""Plots of curves, surfaces and errors with matplotlib, if it is installed."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Optional, Union

from ._arrays import np
from .geometry import Curve, Surface
from .geometry.plots import axes_of
from .iteration import Iteration, Result


def plot(
    what: Union[Curve, Surface, Iteration, Result, Iterable[Iteration]],
    *,
    ax: Any = None,
    net: bool = True,
    data: Any = None,
    samples: Optional[int] = None,
    tolerance: Optional[float] = None,
    **style: Any,
) -> Any:
    """Draws a curve, a surface, or the errors of iterations, and returns the axes of matplotlib.

    A curve or surface, also of an iteration or result, is drawn by `samples` points (200 of a curve, 40 in each
    direction of a surface), with its control points unless `net` is False, and with the fitted points `data`. Axes have
    equal scales. Values with one coordinate are drawn over their parameters, which come first in `data`.

    Several iterations are drawn as their largest and root mean square distance on a logarithmic scale, with the
    `tolerance`.

    `ax` are the axes to draw in, with `projection="3d"` for geometry in space; by default there is a new figure.
    `style`, such as `color="green"`, applies to the curve, the surface or the largest distances. Raises
    `MissingPackage` without matplotlib.
    """
    if isinstance(what, (Curve, Surface, Iteration, Result)):
        geometry = what if isinstance(what, (Curve, Surface)) else what.geometry
        return geometry.plot(ax=ax, net=net, data=data, samples=samples, **style)
    return _errors(list(what), ax, tolerance, style)


def _errors(iterations: list[Iteration], ax: Any, tolerance: Optional[float], style: dict[str, Any]) -> Any:
    if not iterations:
        raise ValueError("there are no iterations to draw the errors of")
    ax = axes_of(ax, 2)
    numbers = [iteration.number for iteration in iterations]
    # None means infinite; neither that nor zero can be drawn on a logarithmic scale.
    largest, rms = (
        np.array([getattr(it.error, name) or np.nan for it in iterations], dtype=float) for name in ("max", "rms")
    )
    ax.plot(numbers, largest, **{"marker": ".", "label": "max", **style})
    ax.plot(numbers, rms, marker=".", label="rms")
    if tolerance is not None:
        ax.axhline(tolerance, color="0.4", linestyle=":", label="tolerance")
    ax.set_yscale("log")
    ax.set(xlabel="iteration", ylabel="distance from the data")
    ax.legend()
    return ax

"""Boundaries of surfaces, as constraints of a neighbouring surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from .._arrays import Array, as_lists, size
from . import net
from .derivative import differentiated
from .shapes import SurfaceLike

Side = Literal["u_start", "u_end", "v_start", "v_end"]
"""A boundary: at the first or the last parameter of u or of v."""


@dataclass(frozen=True, eq=False)
class Boundary:
    """A boundary of a surface, and its derivative across it."""

    control_points: Array
    """Those of the boundary curve in the basis of the other direction, shape (n, dimension)."""
    cross_derivatives: Array
    """Those of the derivative with respect to the parameter that is constant there, in its direction."""

    def __repr__(self) -> str:
        return f"<piad.Boundary, control points {size(self.control_points)}>"

    def constraints(self, at: Side, *, scale: float = 1.0) -> list[dict[str, Any]]:
        """Constraints of a neighbour that joins at its boundary `at`, for the method `least_squares`.

        The neighbour has the same basis along the boundary. Its derivative across is that of this surface times
        `scale`: unless it is zero, both have the same tangent planes (G1). It is positive where an end joins a start,
        and negative where two ends or two starts join, since the parameters then run in opposite directions. If a unit
        of the neighbour's parameter is a times as long as one of this surface, set it to a.
        """
        if not scale:
            raise ValueError("with scale 0 the neighbour would stand still at the boundary")
        across = [[scale * x for x in vector] for vector in as_lists(self.cross_derivatives)]
        place = {"boundary": at}
        return [
            {"at": place, "control_points": as_lists(self.control_points)},
            {"at": place, "cross_derivatives": across},
        ]


def boundary(surface: SurfaceLike, side: Side) -> Boundary:
    """The boundary of a surface at a side."""
    if side not in ("u_start", "u_end", "v_start", "v_end"):
        raise ValueError(f"{side!r} is no boundary: there are u_start, u_end, v_start and v_end")
    axis, end = side.split("_")
    basis = surface.bases[0 if axis == "u" else 1]
    if basis.closed:
        raise ValueError(f"the surface is closed in {axis}, and has no boundary there")
    if surface.weights is not None:
        raise ValueError("the boundary of a rational surface is not linear in its control points")
    lines = surface.control_points if axis == "u" else net.swapped(surface.control_points)
    lines = net.in_bspline_basis(basis, lines)
    basis = basis.as_bspline()
    parameter = basis.domain[0 if end == "start" else 1]
    slope = differentiated(basis, lines, 1)
    return Boundary(net.combined(basis, parameter, lines), net.combined(slope[0], parameter, slope[1]))

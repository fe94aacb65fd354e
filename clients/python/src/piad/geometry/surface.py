"""Surfaces: evaluation, and conversions to other packages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import product
from typing import Any, Optional

from .._arrays import Array, as_array, depth, np, size
from . import geomdl, net, occ, rhino, scipy
from .basis import Basis
from .boundary import Boundary, Side, boundary
from .derivative import Orders, checked, differentiated, quotient
from .picture import surface_picture
from .plots import surface_plot
from .shown import Shown


@dataclass(frozen=True, eq=False)
class Surface(Shown):
    """A tensor-product surface: two bases, a net of control points and, if it is rational, weights.

    u runs over the rows of the net and v over its columns. Lengths are in data units. Lengths are in data units. Arrays
    are numpy arrays if numpy is installed, otherwise nested lists.
    """

    bases: tuple[Basis, Basis]
    """Those of u and v."""
    control_points: Array
    """Shape (rows, columns, dimension): positions, not multiplied by weights."""
    weights: Optional[Array] = None
    """Shape (rows, columns), or None if the surface is not rational."""

    def __repr__(self) -> str:
        rational = "" if self.weights is None else ", rational"
        degrees = " × ".join(map(str, self.degrees))
        return f"<piad.Surface of degree {degrees}, control points {size(self.control_points)}{rational}>"

    @property
    def degrees(self) -> tuple[int, int]:
        """The degrees in u and v."""
        u, v = self.bases
        return u.degree, v.degree

    @property
    def knots(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The knots in u and v; polynomial bases have those of a Bézier curve, 0 and 1."""
        u, v = self.bases
        return u.full_knots(), v.full_knots()

    @property
    def closed(self) -> tuple[bool, bool]:
        """For u and v: true if the surface is periodic."""
        u, v = self.bases
        return u.closed, v.closed

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The intervals of u and v."""
        u, v = self.bases
        return u.domain, v.domain

    @property
    def dimension(self) -> int:
        """The number of coordinates: 1, 2 or 3."""
        return len(self.control_points[0][0])

    @cached_property
    def _net(self) -> Array:
        """Homogeneous control points of the B-spline form."""
        net_ = net.homogeneous(self.control_points, self.weights)
        if not net.is_finite(net_):
            raise ValueError("a control point of weight 0 is at infinity")
        u, v = self.bases
        rows = net.in_bspline_basis(u, net_)
        return net.swapped(net.in_bspline_basis(v, net.swapped(rows)))

    def as_bspline(self) -> Surface:
        """The same surface with B-spline bases, exactly; see `Curve.as_bspline`."""
        u, v = self.bases
        if u.kind == v.kind == "bspline":
            return self
        points, weights = (self._net, None) if self.weights is None else net.projected(self._net)
        return Surface((u.as_bspline(), v.as_bspline()), points, weights)

    def derivative(self, u: int = 0, v: int = 0) -> Surface:
        """The derivative of order `u` in u and `v` in v, as a surface: its control points are vectors.

        Raises `ValueError` if the surface is rational: use `evaluate` with `derivative`.
        """
        orders = checked(u, v)
        if self.weights is not None:
            raise ValueError("the derivative of a rational surface is another kind of surface: ask evaluate for its values")
        basis_u, basis_v, points = self._differentiated(orders)
        return Surface((basis_u, basis_v), points)

    def _differentiated(self, orders: Orders) -> tuple[Basis, Basis, Array]:
        """Both bases and the net of a derivative of the homogeneous B-spline form."""
        bases, (u, v) = [basis.as_bspline() for basis in self.bases], orders
        basis_u, rows = differentiated(bases[0], self._net, u)
        basis_v, columns = differentiated(bases[1], net.swapped(rows), v)
        return basis_u, basis_v, net.swapped(columns)

    def evaluate(self, u: Any, v: Any, *, derivative: tuple[int, int] = (0, 0)) -> Array:
        """The points on the grid of parameters u and v, shape (len(u), len(v), dimension); with
        `derivative`, such as (1, 0), the derivative of these orders in u and v.

        A single number instead of a list drops its axis of the result: two numbers give one point. Parameters of closed
        directions are periodic.
        """
        order_u, order_v = derivative
        at = self._evaluator(checked(order_u, order_v))
        one_u, one_v = depth(u) == 0, depth(v) == 0
        if np is not None:
            return at(float(u) if one_u else as_array(u), float(v) if one_v else as_array(v))
        us, vs = ([u] if one_u else u), ([v] if one_v else v)
        rows: Any = [[at(float(x), float(y)) for y in vs] for x in us]
        if one_v:
            rows = [row[0] for row in rows]
        return rows[0] if one_u else rows  # type: ignore[no-any-return]

    def _evaluator(self, orders: Orders) -> Callable[[Any, Any], Array]:
        """A derivative as a function of the parameters."""
        if self.weights is None:
            return partial(_at, *self._differentiated(orders))
        below = product(*(range(order + 1) for order in orders))
        splines = {at: self._differentiated(at) for at in below}
        return lambda u, v: quotient(orders, lambda at: _at(*splines[at], u, v))

    def boundary(self, side: Side) -> Boundary:
        """The boundary at "u_start", "u_end", "v_start" or "v_end": its control points and cross derivative, to fit a
        neighbour to. Raises `ValueError` if the surface is closed there, or rational.
        """
        return boundary(self, side)

    def _picture(self) -> str:
        return surface_picture(self)

    def _plot(self, ax: Any, net: bool, data: Any, samples: Optional[int], style: dict[str, Any]) -> Any:
        return surface_plot(self, ax, net, data, samples or 40, style)

    def to_scipy(self, *, homogeneous: bool = False) -> Any:
        """A `scipy.interpolate.NdBSpline`, to be called with points (u, v).

        scipy has no rational splines: they raise `ValueError`, unless `homogeneous` is set, which returns the spline of
        (x w, y w, z w, w). Divide its values by their last coordinate.
        """
        return scipy.surface(self, homogeneous=homogeneous)

    def to_geomdl(self) -> Any:
        """A `geomdl.BSpline.Surface`, or `geomdl.NURBS.Surface` if it is rational."""
        return geomdl.surface(self)

    def to_rhino(self) -> Any:
        """A `rhino3dm.NurbsSurface`."""
        return rhino.surface(self)

    def to_occ(self) -> Any:
        """A `Geom_BSplineSurface` of OpenCASCADE, not periodic; of degrees 25 at most."""
        return occ.surface(self)


def _at(basis_u: Basis, basis_v: Basis, points: Array, u: Any, v: Any) -> Array:
    """The points of a tensor-product B-spline."""
    lines = net.combined(basis_u, u, points)
    if np is None or lines.ndim < 3:
        return net.combined(basis_v, v, lines)
    found = net.combined(basis_v, v, net.swapped(lines))
    return net.swapped(found) if found.ndim == 3 else found

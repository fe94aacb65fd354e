"""Curves: evaluation, and conversions to other packages."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Optional

from .._arrays import Array, as_array, depth, np, size
from . import geomdl, net, occ, rhino, scipy
from .basis import Basis
from .derivative import checked, differentiated, quotient
from .picture import curve_picture
from .plots import curve_plot
from .shown import Shown


@dataclass(frozen=True, eq=False)
class Curve(Shown):
    """A curve: a basis, control points and, if it is rational, weights.

    Lengths are in data units. Arrays are numpy arrays if numpy is installed, otherwise nested lists.
    """

    basis: Basis
    control_points: Array
    """Shape (n, dimension): positions, not multiplied by weights."""
    weights: Optional[Array] = None
    """Shape (n,), or None if the curve is not rational."""

    def __repr__(self) -> str:
        rational = "" if self.weights is None else ", rational"
        return f"<piad.Curve of degree {self.degree}, control points {size(self.control_points)}{rational}>"

    @property
    def degree(self) -> int:
        """The degree p."""
        return self.basis.degree

    @property
    def knots(self) -> tuple[float, ...]:
        """The n + p + 1 knots; polynomial bases have those of a Bézier curve, 0 and 1."""
        return self.basis.full_knots()

    @property
    def closed(self) -> bool:
        """True if the curve is periodic: its last p control points repeat the first ones."""
        return self.basis.closed

    @property
    def domain(self) -> tuple[float, float]:
        """The interval of parameters."""
        return self.basis.domain

    @property
    def dimension(self) -> int:
        """The number of coordinates: 1 to 16."""
        return len(self.control_points[0])

    @cached_property
    def _net(self) -> Array:
        """Homogeneous control points of the B-spline form."""
        net_ = net.homogeneous(self.control_points, self.weights)
        if not net.is_finite(net_):
            raise ValueError("a control point of weight 0 is at infinity")
        return net.in_bspline_basis(self.basis, net_)

    def as_bspline(self) -> Curve:
        """The same curve as a B-spline, exact for each basis.

        Polynomials get the knots 0 and 1, and control points of the Ball bases become Bézier
        points. A B-spline is returned unchanged.
        """
        if self.basis.kind == "bspline":
            return self
        points, weights = (self._net, None) if self.weights is None else net.projected(self._net)
        return Curve(self.basis.as_bspline(), points, weights)

    def derivative(self, order: int = 1) -> Curve:
        """The derivative with respect to the parameter, as a curve: its control points are vectors.

        Raises `ValueError` if the curve is rational: use `evaluate` with `derivative`.
        """
        (order,) = checked(order)
        if self.weights is not None:
            raise ValueError("the derivative of a rational curve is another kind of curve: ask evaluate for its values")
        return Curve(*differentiated(self.basis.as_bspline(), self._net, order))

    def evaluate(self, u: Any, *, derivative: int = 0) -> Array:
        """The point at a parameter, shape (dimension,), or those at m parameters, (m, dimension);
        with `derivative`, the derivative of this order.

        Parameters of closed curves are periodic; outside the domain of other curves they raise `ValueError`. At a knot
        where the derivative jumps, it is that from the right; at the last knot, that from the left.
        """
        at = self._evaluator(checked(derivative)[0])
        if depth(u) == 0:
            return at(float(u))
        if np is not None:
            return at(as_array(u))
        nested: Any = [at(float(x)) for x in u]
        return nested  # type: ignore[no-any-return]

    def _evaluator(self, order: int) -> Callable[[Any], Array]:
        """A derivative as a function of the parameter."""
        basis = self.basis.as_bspline()
        if self.weights is None:
            return partial(_at, *differentiated(basis, self._net, order))
        splines = [differentiated(basis, self._net, k) for k in range(order + 1)]
        return lambda u: quotient((order,), lambda at: _at(*splines[at[0]], u))

    def _picture(self) -> str:
        return curve_picture(self)

    def _plot(self, ax: Any, net: bool, data: Any, samples: Optional[int], style: dict[str, Any]) -> Any:
        return curve_plot(self, ax, net, data, samples or 200, style)

    def to_scipy(self, *, homogeneous: bool = False) -> Any:
        """A `scipy.interpolate.BSpline` (`extrapolate="periodic"` if the curve is closed).

        scipy has no rational splines: they raise `ValueError`, unless `homogeneous` is set, which returns the spline of
        (x w, y w, z w, w). Divide its values by their last coordinate.
        """
        return scipy.curve(self, homogeneous=homogeneous)

    def to_geomdl(self) -> Any:
        """A `geomdl.BSpline.Curve`, or `geomdl.NURBS.Curve` if it is rational."""
        return geomdl.curve(self)

    def to_rhino(self) -> Any:
        """A `rhino3dm.NurbsCurve`."""
        return rhino.curve(self)

    def to_occ(self) -> Any:
        """A `Geom_BSplineCurve` of OpenCASCADE, not periodic; of degree 25 at most."""
        return occ.curve(self)


def _at(basis: Basis, points: Array, u: Any) -> Array:
    """The points of a B-spline."""
    return net.combined(basis, u, points)

"""The basis of one direction: knots, and the B-spline functions that are not zero at a parameter."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from typing import Any, Literal, Optional

from .._arrays import np

BasisKind = Literal["bspline", "bernstein", "said_ball", "wang_ball"]


@dataclass(frozen=True)
class Basis:
    """The basis of a curve, or of one direction of a surface.

    `knots` are non-decreasing, `degree + 1` more than control points; polynomial bases have none
    and are defined on [0, 1]. A `closed` basis is periodic: its last `degree` control points are
    the first ones again; with corners it is clamped at one of them.
    """

    kind: BasisKind
    degree: int
    knots: Optional[tuple[float, ...]]
    closed: bool = False

    def __repr__(self) -> str:
        closed = ", closed" if self.closed else ""
        return f"<piad.Basis {self.kind} of degree {self.degree}, {len(self.full_knots())} knots{closed}>"

    def full_knots(self) -> tuple[float, ...]:
        """The knots; those of a Bézier curve for polynomial bases."""
        if self.knots is not None:
            return self.knots
        return (0.0,) * (self.degree + 1) + (1.0,) * (self.degree + 1)

    def as_bspline(self) -> Basis:
        """The B-spline basis that spans the same functions, with Bézier knots for polynomials."""
        return Basis("bspline", self.degree, self.full_knots(), self.closed)

    @property
    def count(self) -> int:
        """The number of control points."""
        return len(self.full_knots()) - self.degree - 1

    @property
    def domain(self) -> tuple[float, float]:
        """The interval of parameters."""
        knots = self.full_knots()
        return knots[self.degree], knots[len(knots) - self.degree - 1]


def multiplicities(knots: tuple[float, ...]) -> list[tuple[float, int]]:
    """The distinct knots with their multiplicities."""
    distinct: list[tuple[float, int]] = []
    for knot in knots:
        if distinct and distinct[-1][0] == knot:
            distinct[-1] = (knot, distinct[-1][1] + 1)
        else:
            distinct.append((knot, 1))
    return distinct


def inside(basis: Basis, u: Any) -> Any:
    """The parameters, moved into the domain by whole periods if the basis is closed.

    Raises `ValueError` for parameters outside of the domain of a basis that is not.
    """
    start, end = basis.domain
    array = np is not None and isinstance(u, np.ndarray)
    if basis.closed:
        # Parameters in the domain are unchanged, to the last bit.
        wrapped = start + (u - start) % (end - start)
        if array:
            return np.where((u < start) | (u > end), wrapped, u)
        return u if start <= u <= end else wrapped
    outside = u[~((start <= u) & (u <= end))] if array else [] if start <= u <= end else [u]
    if len(outside):
        raise ValueError(f"the parameter {float(outside[0])!r} is not between {start!r} and {end!r}")
    return u


def span(basis: Basis, u: Any) -> Any:
    """The index i of the non-empty knot interval [t_i, t_{i+1}) that contains a parameter of the domain, or indices for
    an array of parameters. The last interval includes its end.
    """
    knots = basis.full_knots()
    last = bisect_left(knots, basis.domain[1]) - 1
    if np is not None and isinstance(u, np.ndarray):
        return np.minimum(np.searchsorted(knots, u, side="right") - 1, last)
    return min(bisect_right(knots, u) - 1, last)


def functions(basis: Basis, u: Any) -> tuple[Any, list[Any]]:
    """The span of parameters and the `degree + 1` functions that are not zero there.

    The recursion of de Boor and Cox in the form of Piegl and Tiller (A2.2), which adds positive numbers only. For an
    array of parameters, all results are arrays of its length.
    """
    u = inside(basis, u)
    i = span(basis, u)
    knots: Any = basis.full_knots()
    one: Any = 1.0
    if np is not None and isinstance(u, np.ndarray):
        knots, one = np.asarray(knots), np.ones_like(u)
    values = [one]
    for degree in range(1, basis.degree + 1):
        saved = 0.0 * one
        for r in range(degree):
            left, right = knots[i + 1 - degree + r], knots[i + 1 + r]
            part = values[r] / (right - left)
            values[r] = saved + (right - u) * part
            saved = (u - left) * part
        values.append(saved)
    return i, values

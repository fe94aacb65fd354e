"""Derivatives with respect to parameters.

The derivative of a B-spline is a B-spline of one degree less, whose control points are differences. The derivative of a
rational curve or surface C = A / w has higher degrees; its values follow from those of A and w by the Leibniz rule
(Piegl and Tiller, eq. 4.8 and 4.20).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from math import comb
from operator import index
from typing import Any

from .._arrays import Array, as_array, as_lists, mix, np
from .basis import Basis

Orders = tuple[int, ...]
"""The order of a derivative: one number for a curve, two for a surface."""


def checked(*orders: Any) -> Orders:
    """Checks orders of a derivative; raises `ValueError`, or `TypeError` if one is not an integer."""
    whole = tuple(map(index, orders))
    if min(whole) < 0:
        raise ValueError(f"a derivative has orders from 0 on, not {min(whole)}")
    return whole


def differentiated(basis: Basis, net: Array, order: int) -> tuple[Basis, Array]:
    """The basis and the net, along its first axis, of a derivative of a B-spline."""
    for _ in range(order):
        if basis.degree == 0:
            return basis, _differences(net, [0.0] * basis.count, 0)
        knots, degree = basis.full_knots(), basis.degree
        lengths = [knots[i + degree + 1] - knots[i + 1] for i in range(basis.count - 1)]
        # A function with empty support is zero, and its control point has no effect.
        net = _differences(net, [degree / length if length else 0.0 for length in lengths], 1)
        basis = Basis("bspline", degree - 1, knots[1:-1], basis.closed)
    return basis, net


def _differences(net: Array, factors: list[float], lag: int) -> Array:
    """Differences of elements a lag apart, times factors."""
    if np is not None:
        column = np.asarray(factors).reshape(-1, *[1] * (net.ndim - 1))
        scaled: Array = column * (net[lag:] - net[: len(net) - lag])
        return scaled
    rows = as_lists(net)
    return as_array([mix([factor, -factor], [rows[i + lag], rows[i]]) for i, factor in enumerate(factors)])


def quotient(orders: Orders, numerators: Callable[[Orders], Any]) -> Any:
    """The derivative of A / w, from the derivatives of the homogeneous points (A, w) up to its order."""
    found: dict[Orders, Any] = {}
    values: dict[Orders, Any] = {}
    for at in product(*(range(order + 1) for order in orders)):
        values[at] = numerators(at)
        weight = _weight(values[tuple(0 for _ in orders)])
        factors, terms = [1.0 / weight], [values[at][..., :-1] if np is not None else values[at][:-1]]
        for step in product(*(range(order + 1) for order in at)):
            if any(step):
                ways = 1
                for order, taken in zip(at, step):
                    ways *= comb(order, taken)
                factors.append(-ways * _weight(values[step]) / weight)
                terms.append(found[tuple(order - taken for order, taken in zip(at, step))])
        found[at] = mix(factors, terms)
    return found[orders]


def _weight(point: Any) -> Any:
    return point[..., -1:] if np is not None else point[-1]

"""Control nets in homogeneous coordinates: points times weights, and the weights.

A net of a curve is an array of shape (n, d), of a surface (rows, columns, d). The functions work
along its first axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Optional

from .._arrays import Array, mix, np
from .ball import to_bezier
from .basis import Basis, functions


def homogeneous(points: Array, weights: Optional[Array]) -> Array:
    """The net (x w, y w, z w, w) of a rational curve or surface, otherwise the points."""
    if weights is None:
        return points
    if np is not None:
        joined: Array = np.concatenate([points * weights[..., None], weights[..., None]], axis=-1)
        return joined
    nested: Any = _pairwise(lambda point, w: [x * w for x in point] + [w], points, weights)
    return nested  # type: ignore[no-any-return]


def projected(net: Array) -> tuple[Array, Array]:
    """The points and the weights of a homogeneous net; the converse of `homogeneous`."""
    if np is not None:
        return net[..., :-1] / net[..., -1:], net[..., -1]
    points: Any = _leaves(net, lambda point: [x / point[-1] for x in point[:-1]])
    weights: Any = _leaves(net, lambda point: point[-1])
    return points, weights


def is_finite(net: Array) -> bool:
    """True if all numbers are finite; control points of weight zero are at infinity."""
    if np is not None:
        return bool(np.isfinite(net).all())
    flat: list[bool] = []
    _leaves(net, lambda point: flat.append(all(map(math.isfinite, point))))
    return all(flat)


def in_bspline_basis(basis: Basis, net: Array) -> Array:
    """The net of the same curve in the basis `basis.as_bspline()`."""
    if basis.kind in ("bspline", "bernstein"):
        return net
    matrix = to_bezier(basis.kind, basis.degree)
    if np is not None:
        converted: Array = np.tensordot(np.array(matrix), net, axes=(1, 0))
        return converted
    nested: Any = [mix(row, net) for row in matrix]
    return nested  # type: ignore[no-any-return]


def combined(basis: Basis, u: Any, net: Array) -> Array:
    """Evaluates the net along its first axis, which is dropped for a single parameter."""
    i, values = functions(basis, u)
    first = i - basis.degree
    if np is None:
        items: Any = net
        at: Any = mix(values, items[first : i + 1])
        return at  # type: ignore[no-any-return]
    spread = (...,) + (None,) * (net.ndim - 1)
    total: Array = sum(np.asarray(value)[spread] * net[first + j] for j, value in enumerate(values))
    return total


def swapped(net: Array) -> Array:
    """Transposes the net of a surface."""
    if np is not None:
        return np.swapaxes(net, 0, 1)  # type: ignore[no-any-return]
    nested: Any = [list(column) for column in zip(*net)]
    return nested  # type: ignore[no-any-return]


def in_space(point: Any) -> tuple[float, float, float]:
    """A point of two or three coordinates as x, y, z; those of the plane have z = 0."""
    if len(point) < 2:
        raise ValueError("values with one coordinate have no place in space")
    if len(point) > 3:
        raise ValueError(f"points with {len(point)} coordinates have no place in space")
    x, y, z = (*map(float, point), 0.0)[:3]
    return x, y, z


def _pairwise(function: Callable[[Any, Any], Any], points: Any, weights: Any) -> Any:
    if isinstance(weights[0], list):
        return [_pairwise(function, row, line) for row, line in zip(points, weights)]
    return [function(point, weight) for point, weight in zip(points, weights)]


def _leaves(net: Any, function: Callable[[Any], Any]) -> Any:
    """Applies a function to each point of nested lists."""
    if isinstance(net[0], list):
        return [_leaves(row, function) for row in net]
    return function(net)

"""From the Ball bases to the Bernstein basis of the same degree, exactly.

Every function of a Ball basis is a multiple of some t^a (1-t)^b with a + b <= m. Multiplied by
1 = (t + (1-t))^(m-a-b) it is a sum of Bernstein polynomials,

    t^a (1-t)^b = sum over k = a … m-b of C(m-a-b, k-a) / C(m, k) B_k(t),

so that Bézier points are means of Ball points, with weights that are not negative.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb
from typing import NamedTuple

from .basis import BasisKind


class _Term(NamedTuple):
    """factor · t^up (1-t)^down"""

    factor: int
    up: int
    down: int


@lru_cache(maxsize=8)
def to_bezier(kind: BasisKind, degree: int) -> tuple[tuple[float, ...], ...]:
    """The matrix from control points of a Ball basis to Bézier points, a row for each of these.

    The entries are quotients of integers, rounded once.
    """
    terms = _said_ball(degree) if kind == "said_ball" else _wang_ball(degree)
    total = [comb(degree, k) for k in range(degree + 1)]
    matrix = [[0.0] * (degree + 1) for _ in range(degree + 1)]
    for column, (factor, up, down) in enumerate(terms):
        rest = degree - up - down
        part = factor
        for i in range(rest + 1):
            matrix[up + i][column] = part / total[up + i]
            part = part * (rest - i) // (i + 1) if i < rest else part
    return tuple(map(tuple, matrix))


def _said_ball(degree: int) -> list[_Term]:
    half = degree // 2
    left = [_Term(comb(half + i, i), i, half + 1) for i in range((degree + 1) // 2)]
    middle = [_Term(comb(degree, half), half, half)] if degree % 2 == 0 else []
    return _mirrored(left, middle)


def _wang_ball(degree: int) -> list[_Term]:
    half = degree // 2
    left = [_Term(2**i, i, i + 2) for i in range(half)]
    if degree % 2 == 0:
        return _mirrored(left, [_Term(2**half, half, half)])
    return _mirrored([*left, _Term(2**half, half, half + 1)], [])


def _mirrored(left: list[_Term], middle: list[_Term]) -> list[_Term]:
    """Mirrors half of a symmetric basis."""
    right = [_Term(factor, down, up) for factor, up, down in reversed(left)]
    return left + middle + right

"""Coordinates of scattered points in the plane nearest to them, along the smallest rectangle around them.

A surface is defined on a rectangle of parameters. The principal axes of a square cloud can be its
diagonals: then the corners of the rectangle are far from all points, and the surface is
undetermined there. The sides of the smallest rectangle lie along the border of the cloud.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from .points import Point

Pair = tuple[float, float]


def parameters(points: Sequence[Point]) -> list[Pair]:
    """The coordinates of each point, in millimetres."""
    x, y = _plane(points)
    flat = [(_dot(x, p), _dot(y, p)) for p in points]
    c, s = _direction(_hull(flat))
    return [(c * u + s * v, c * v - s * u) for u, v in flat]


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _plane(points: Sequence[Point]) -> tuple[list[float], list[float]]:
    """The two principal axes with the largest spread."""
    n = len(points)
    mean = [sum(column) / n for column in zip(*points)]
    spread = [[0.0] * 3 for _ in range(3)]
    for p in points:
        d = (p[0] - mean[0], p[1] - mean[1], p[2] - mean[2])
        for i in range(3):
            for j in range(i, 3):
                spread[i][j] += d[i] * d[j]
    for i in range(3):
        for j in range(i):
            spread[i][j] = spread[j][i]
    values, axes = _eigen(spread)
    order = sorted(range(3), key=lambda k: -values[k])
    return [axes[i][order[0]] for i in range(3)], [axes[i][order[1]] for i in range(3)]


def _eigen(a: list[list[float]]) -> tuple[list[float], list[list[float]]]:
    """Eigenvalues of a symmetric matrix, and its eigenvectors as columns: Jacobi's rotations."""
    axes = [[float(i == j) for j in range(3)] for i in range(3)]
    for _ in range(30):
        p, q = max(((0, 1), (0, 2), (1, 2)), key=lambda at: abs(a[at[0]][at[1]]))
        if abs(a[p][q]) <= 1e-15 * (a[0][0] + a[1][1] + a[2][2]):
            break
        angle = 0.5 * math.atan2(2 * a[p][q], a[q][q] - a[p][p])
        c, s = math.cos(angle), math.sin(angle)
        for matrix in (a, axes):
            for row in matrix:
                row[p], row[q] = c * row[p] - s * row[q], s * row[p] + c * row[q]
        a[p], a[q] = (
            [c * x - s * y for x, y in zip(a[p], a[q])],
            [s * x + c * y for x, y in zip(a[p], a[q])],
        )
    return [a[i][i] for i in range(3)], axes


def _hull(points: Sequence[Pair]) -> list[Pair]:
    """The corners of the convex hull, around it (Andrew's chains)."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return ordered
    chains = [_chain(ordered), _chain(ordered[::-1])]
    return chains[0][:-1] + chains[1][:-1]


def _chain(points: Sequence[Pair]) -> list[Pair]:
    chain: list[Pair] = []
    for x, y in points:
        while len(chain) > 1:
            (ax, ay), (bx, by) = chain[-2:]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                break
            chain.pop()
        chain.append((x, y))
    return chain


def _direction(hull: Sequence[Pair]) -> Pair:
    """Cosine and sine of the longer side of the smallest rectangle: one side lies along an edge of the hull."""
    best, found = math.inf, (1.0, 0.0)
    for (ax, ay), (bx, by) in zip(hull, [*hull[1:], *hull[:1]]):
        length = math.hypot(bx - ax, by - ay)
        if length == 0:
            continue
        c, s = (bx - ax) / length, (by - ay) / length
        us, vs = [c * x + s * y for x, y in hull], [c * y - s * x for x, y in hull]
        width, height = max(us) - min(us), max(vs) - min(vs)
        if width * height < best:
            best, found = width * height, (c, s) if width >= height else (-s, c)
    return found

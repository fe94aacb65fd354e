"""The B-spline of a JSON result, computed independently of piad."""

import json
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import comb

import numpy as np
from scipy.interpolate import BSpline


@dataclass
class Spline:
    """A curve (one degree, one knot vector) or a surface (two)."""

    degrees: list[int]
    knots: list[np.ndarray]
    closed: list[bool]
    poles: np.ndarray  # (rows, 3) or (rows, columns, 3)
    weights: np.ndarray | None
    exact: bool  # the poles are those of the JSON, without conversion
    error: float

    @property
    def is_surface(self) -> bool:
        return len(self.degrees) == 2

    @cached_property
    def extent(self) -> float:
        """The extent of the curve or surface; control points can be far outside."""
        parameters = [self.parameters(axis, 50) for axis in range(len(self.degrees))]
        points = self.evaluate(*parameters).reshape(-1, 3)
        return float(np.linalg.norm(np.ptp(points, axis=0)))

    @property
    def magnitude(self) -> float:
        return float(np.abs(self.poles).max())

    def domain(self, axis: int) -> tuple[float, float]:
        knots, degree = self.knots[axis], self.degrees[axis]
        return float(knots[degree]), float(knots[-degree - 1])

    def parameters(self, axis: int, count: int) -> np.ndarray:
        return np.linspace(*self.domain(axis), count)

    def homogeneous(self) -> np.ndarray:
        weights = np.ones(self.poles.shape[:-1]) if self.weights is None else self.weights
        return np.concatenate([self.poles * weights[..., None], weights[..., None]], axis=-1)

    def evaluate(self, *parameters: np.ndarray) -> np.ndarray:
        """Points at parameters, for surfaces on their grid."""
        points = self.homogeneous()
        for axis, (t, knots, degree) in enumerate(zip(parameters, self.knots, self.degrees)):
            points = np.moveaxis(points, axis, 0)
            points = BSpline(knots, points, degree)(t)
            points = np.moveaxis(points, 0, axis)
        return points[..., :3] / points[..., 3:]


def load(path: str) -> Spline:
    """Reads a result."""
    with open(path, encoding="utf-8") as file:
        return from_result(json.load(file))


def from_result(result: dict) -> Spline:
    surface = result["kind"] == "surface"
    each = (lambda value: [value["u"], value["v"]]) if surface else (lambda value: [value])
    degrees, bases = each(result["degree"]), each(result["basis"])
    knots = [
        np.array(knots if knots is not None else [0.0] * (p + 1) + [1.0] * (p + 1))
        for knots, p in zip(each(result["knots"]), degrees)
    ]
    poles = np.array(result["control_points"], dtype=float)
    missing = 3 - poles.shape[-1]
    poles = np.pad(poles, [(0, 0)] * (poles.ndim - 1) + [(0, missing)])
    weights = net_weights(result, surface)
    exact = not any(basis.endswith("_ball") for basis in bases)
    if not exact:
        for axis, (basis, degree) in enumerate(zip(bases, degrees)):
            if basis.endswith("_ball"):
                poles, weights = to_bezier(basis, degree, axis, poles, weights)
    closed = each(result["closed"])
    return Spline(degrees, knots, closed, poles, weights, exact, result["error"]["max"])


def net_weights(result: dict, surface: bool) -> np.ndarray | None:
    """One weight for each control point, for each kind of rational fit."""
    weights = result.get("weights")
    if weights is None:
        return None
    if result["rational"] == "homogeneous":
        return np.array(weights, dtype=float)
    if not surface:
        return np.array(weights, dtype=float)
    u, v = weights["u"], weights["v"]
    return np.outer(np.array(u), np.array(v))


def ball(basis: str, degree: int) -> list[list[int]]:
    """Integer coefficients c, i, j of the terms c t^i (1-t)^j of a Ball basis."""
    half, left = degree // 2, (degree + 1) // 2
    terms: list[list[int]] = []
    if basis == "said_ball":
        terms = [[comb(half + i, i), i, half + 1] for i in range(left)]
        middle = [[comb(degree, half), half, half]] if degree % 2 == 0 else []
    else:
        terms = [[2**i, i, i + 2] for i in range(half)]
        if degree % 2:
            terms.append([2**half, half, half + 1])
        middle = [[2**half, half, half]] if degree % 2 == 0 else []
    return terms + middle + [[c, j, i] for c, i, j in reversed(terms)]


def conversion(basis: str, degree: int) -> list[list[Fraction]]:
    """Bezier points in terms of Ball points, in exact arithmetic: polynomials in powers of t, the
    Bernstein coefficients of which are sum_i C(k, i) / C(m, i) a_i."""
    columns = []
    for c, i, j in ball(basis, degree):
        power = [Fraction(0)] * (degree + 1)
        for k in range(j + 1):
            power[i + k] += c * (-1) ** k * comb(j, k)
        columns.append(
            [
                sum(Fraction(comb(k, i), comb(degree, i)) * power[i] for i in range(k + 1))
                for k in range(degree + 1)
            ]
        )
    return [list(row) for row in zip(*columns)]


def to_bezier(basis, degree, axis, poles, weights):
    matrix = conversion(basis, degree)
    rational = weights is not None
    weights = weights if rational else np.ones(poles.shape[:-1])
    exact = np.vectorize(Fraction, otypes=[object])
    lifted = np.concatenate(
        [exact(poles) * exact(weights)[..., None], exact(weights)[..., None]], axis=-1
    )
    lifted = np.moveaxis(np.tensordot(np.array(matrix, dtype=object), lifted, (1, axis)), 0, axis)
    places = (lifted[..., :3] / lifted[..., 3:]).astype(float)
    return places, lifted[..., 3].astype(float) if rational else None

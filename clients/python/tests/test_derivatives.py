"""Derivatives against those of scipy and OpenCASCADE, quotients of jets, and differences."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from shapes import CURVE, FITS

import piad

CURVES = [name for name, fit in FITS.items() if isinstance(fit["points"][0][0], (int, float))]
SURFACES = [name for name in FITS if name not in CURVES]


def quotients(tops: Any, bottoms: Any) -> Any:
    """Derivatives of A / w from those of A and w: Taylor series are divided."""
    series: list[Any] = []
    for k, top in enumerate(tops):
        rest = top / math.factorial(k)
        for i in range(1, k + 1):
            rest = rest - bottoms[i] / math.factorial(i) * series[k - i]
        series.append(rest / bottoms[0])
    return [part * math.factorial(k) for k, part in enumerate(series)]


@pytest.mark.parametrize("name", CURVES)
def test_curves_against_scipy(client: piad.Client, name: str) -> None:
    curve = client.fit(**FITS[name]).curve
    spline = curve.to_scipy(homogeneous=True)
    # At the end of a closed curve scipy continues in the first interval, where the highest derivative may differ.
    u = np.linspace(*curve.domain, 41)[: 40 if curve.closed else 41]
    values = [spline(u, k) for k in range(curve.degree + 2)]
    if curve.weights is not None:
        values = quotients([it[:, :-1] for it in values], [it[:, -1:] for it in values])
    for order, expected in enumerate(values):
        found = curve.evaluate(u, derivative=order)
        assert np.abs(found - expected).max() <= 1e-11 * max(1.0, np.abs(expected).max()), order
        assert np.array_equal(curve.evaluate(float(u[7]), derivative=order), found[7])


@pytest.mark.parametrize("name", SURFACES)
def test_surfaces_against_scipy(client: piad.Client, name: str) -> None:
    surface = client.fit(**FITS[name]).surface
    spline = surface.to_scipy(homogeneous=True)
    us, vs = (np.linspace(*interval, 11) for interval in surface.domain)
    grid = np.stack(np.meshgrid(us, vs, indexing="ij"), axis=-1)
    for orders in [(0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (2, 1), (2, 2), (0, 3)]:
        found = surface.evaluate(us, vs, derivative=orders)
        if surface.weights is None:
            expected = spline(grid, nu=orders)
            assert np.abs(found - expected).max() <= 1e-11 * max(1.0, np.abs(expected).max())
        one = surface.evaluate(float(us[3]), vs, derivative=orders)
        assert np.allclose(one, found[3], rtol=1e-12, atol=1e-12 * np.abs(found).max())
        assert np.allclose(surface.evaluate(us, float(vs[4]), derivative=orders), found[:, 4], rtol=1e-12, atol=1e-12 * np.abs(found).max())


@pytest.mark.parametrize("name", CURVES)
def test_curves_against_opencascade(client: piad.Client, name: str) -> None:
    curve = client.fit(**FITS[name]).curve
    other = curve.to_occ()
    for u in np.linspace(*curve.domain, 17)[1:-1]:
        for order in (1, 2, 3):
            vector = other.DN(float(u), order)
            expected = np.array([vector.X(), vector.Y(), vector.Z()])[: curve.dimension]
            found = curve.evaluate(u, derivative=order)
            assert np.abs(found - expected).max() <= 1e-10 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("name", SURFACES)
def test_surfaces_against_opencascade(client: piad.Client, name: str) -> None:
    surface = client.fit(**FITS[name]).surface
    other = surface.to_occ()
    us, vs = (np.linspace(*interval, 7)[1:-1] for interval in surface.domain)
    for orders in [(1, 0), (0, 1), (1, 1), (2, 0), (1, 2)]:
        found = surface.evaluate(us, vs, derivative=orders)
        vectors = [[other.DN(float(u), float(v), *orders) for v in vs] for u in us]
        expected = np.array([[(it.X(), it.Y(), it.Z()) for it in row] for row in vectors])
        assert np.abs(found - expected).max() <= 1e-10 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("name", CURVES)
def test_curves_against_differences(client: piad.Client, name: str) -> None:
    """For all bases, from values only."""
    job = client.create(**FITS[name])
    job.wait()
    curve = job.iteration(0).geometry
    assert isinstance(curve, piad.Curve)
    low, high = curve.domain
    u, step = low + (high - low) * np.linspace(0.03, 0.97, 23), 1e-6 * (high - low)
    for order in (1, 2):
        before, after = (curve.evaluate(it, derivative=order - 1) for it in (u - step, u + step))
        expected = (after - before) / (2 * step)
        assert np.abs(curve.evaluate(u, derivative=order) - expected).max() <= 1e-5 * np.abs(expected).max()


@pytest.mark.parametrize("name", [name for name in FITS if "weights" not in FITS[name]])
def test_derivatives_are_geometry(client: piad.Client, name: str) -> None:
    geometry = client.fit(**FITS[name]).geometry
    if isinstance(geometry, piad.Curve):
        u = np.linspace(*geometry.domain, 13)
        slope = geometry.derivative()
        assert (slope.degree, slope.closed, slope.domain) == (geometry.degree - 1, geometry.closed, geometry.domain)
        assert np.array_equal(slope.evaluate(u), geometry.evaluate(u, derivative=1))
        assert np.allclose(slope.derivative().evaluate(u), geometry.derivative(2).evaluate(u), rtol=1e-15)
        assert np.allclose(slope.to_scipy()(u), slope.evaluate(u), rtol=1e-11, atol=1e-11)
        assert not geometry.derivative(geometry.degree + 3).evaluate(u).any()
        assert np.array_equal(geometry.derivative(0).evaluate(u), geometry.evaluate(u))
    else:
        u, v = (np.linspace(*interval, 5) for interval in geometry.domain)
        twist = geometry.derivative(1, 1)
        assert twist.degrees == tuple(degree - 1 for degree in geometry.degrees)
        assert np.array_equal(twist.evaluate(u, v), geometry.evaluate(u, v, derivative=(1, 1)))
        assert not geometry.derivative(v=9).evaluate(u, v).any()


def test_a_circle_has_the_curvature_of_a_circle() -> None:
    """A quarter of a circle, as a rational curve of degree 2."""
    points, weights = np.array([[2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]), np.array([1.0, math.sqrt(0.5), 1.0])
    circle = piad.Curve(piad.Basis("bernstein", 2, None), points, weights)
    u = np.linspace(0, 1, 33)
    one, two = (circle.evaluate(u, derivative=order) for order in (1, 2))
    curvature = (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0]) / np.linalg.norm(one, axis=1) ** 3
    assert np.abs(curvature - 0.5).max() < 1e-14
    assert np.abs((circle.evaluate(u) * one).sum(axis=1)).max() < 1e-14


def test_derivatives_are_exact_to_rounding() -> None:
    """Against rational numbers, of a B-spline with a double knot and steep steps."""
    knots = (0.0, 0.0, 0.0, 0.0, 0.125, 1.0, 1.0, 3.5, 4.0, 4.0, 4.0, 4.0)
    points = np.array([[1.0], [-3.0], [0.1], [1000.0], [7.0], [-2.5], [0.3], [8.0]])
    curve = piad.Curve(piad.Basis("bspline", 3, knots), points)
    for order in (1, 2, 3):
        for u in (0.0, 0.125, 0.7, 1.0, 3.75, 4.0):
            exact = spline([Fraction(k) for k in knots], [Fraction(float(p[0])) for p in points], 3, Fraction(u), order)
            size = np.abs(curve.derivative(order).control_points).max()
            assert abs(float(curve.evaluate(u, derivative=order)[0]) - float(exact)) <= 4e-16 * size


def spline(knots: list[Fraction], points: list[Fraction], degree: int, u: Fraction, order: int) -> Fraction:
    """De Boor's recursion in exact arithmetic; the last interval includes its end."""
    last = max(i for i in range(degree, len(knots) - degree - 1) if knots[i] < knots[i + 1])
    span = min(max(i for i in range(len(knots)) if knots[i] <= u), last)

    def value(i: int, p: int, k: int) -> Fraction:
        if p == 0:
            return Fraction(int(i == span)) if k == 0 else Fraction(0)
        left, right = knots[i + p] - knots[i], knots[i + p + 1] - knots[i + 1]
        if k > 0:
            a = p * value(i, p - 1, k - 1) / left if left else Fraction(0)
            return a - (p * value(i + 1, p - 1, k - 1) / right if right else Fraction(0))
        a = (u - knots[i]) * value(i, p - 1, 0) / left if left else Fraction(0)
        return a + ((knots[i + p + 1] - u) * value(i + 1, p - 1, 0) / right if right else Fraction(0))

    return sum((point * value(i, degree, order) for i, point in enumerate(points)), Fraction(0))


def test_where_derivatives_jump() -> None:
    """At a knot of multiplicity `degree` both derivatives are those from the right."""
    basis = piad.Basis("bspline", 2, (0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0))
    curve = piad.Curve(basis, np.array([[0.0], [1.0], [0.0], [3.0], [0.0]]))
    assert curve.evaluate([1.0 - 1e-9, 1.0], derivative=1).ravel() == pytest.approx([-2.0, 6.0])
    assert curve.evaluate([0.5, 1.0, 2.0], derivative=2).ravel().tolist() == [-4.0, -12.0, -12.0]
    assert curve.derivative(2).evaluate([0.5, 1.5]).ravel().tolist() == [-4.0, -12.0]


def test_what_has_no_derivative(client: piad.Client) -> None:
    curve, surface = client.fit(CURVE).curve, client.fit(**FITS["surface"]).surface
    for wrong in (lambda: curve.evaluate(0.5, derivative=-1), lambda: surface.derivative(1, -1)):
        with pytest.raises(ValueError, match="from 0 on"):
            wrong()
    with pytest.raises(TypeError):
        curve.derivative(0.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError):
        surface.evaluate(0.5, 0.5, derivative=(1, 0, 0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="not between"):
        curve.evaluate(curve.domain[1] + 1, derivative=1)
    for name in ("homogeneous", "fixed_surface"):
        with pytest.raises(ValueError, match="ask evaluate"):
            client.fit(**FITS[name]).geometry.derivative()
    assert np.array_equal(curve.evaluate(0.5, derivative=np.int64(1)), curve.evaluate(0.5, derivative=1))  # type: ignore[arg-type]

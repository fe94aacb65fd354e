"""Curves and surfaces equal those of the server, here and in other packages."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from shapes import CURVE, FITS

import piad
from piad.geometry import occ
from piad.geometry._optional import load
from piad.geometry.ball import to_bezier

KINDS = ["piad", "scipy", "geomdl", "rhino", "occ"]


def in_space(points: Any) -> Any:
    points = np.asarray(points)
    missing = 3 - points.shape[-1]
    return np.concatenate([points, np.zeros((*points.shape[:-1], missing))], axis=-1)


def projected(values: Any, rational: bool) -> Any:
    return values[..., :-1] / values[..., -1:] if rational else values


def of_curve(kind: str, curve: piad.Curve, parameters: Any) -> Any:
    rational = curve.weights is not None
    if kind == "piad":
        return curve.evaluate(parameters)
    if kind == "scipy":
        return projected(curve.to_scipy(homogeneous=rational)(parameters), rational)
    if kind == "geomdl":
        made = curve.to_geomdl()
        return [made.evaluate_single(float(u)) for u in parameters]
    if kind == "rhino":
        made = curve.to_rhino()
        assert made.IsValid
        points = [made.PointAt(float(u)) for u in parameters]
        return [(p.X, p.Y, p.Z) for p in points]
    made = curve.to_occ()
    points = [made.Value(float(u)) for u in parameters]
    return [(p.X(), p.Y(), p.Z()) for p in points]


def of_surface(kind: str, surface: piad.Surface, us: Any, vs: Any) -> Any:
    rational = surface.weights is not None
    if kind == "piad":
        return surface.evaluate(us, vs)
    if kind == "scipy":
        grid = np.stack(np.meshgrid(us, vs, indexing="ij"), axis=-1)
        return projected(surface.to_scipy(homogeneous=rational)(grid), rational)
    if kind == "geomdl":
        made = surface.to_geomdl()
        return [[made.evaluate_single((float(u), float(v))) for v in vs] for u in us]
    if kind == "rhino":
        made = surface.to_rhino()
        assert made.IsValid
        return [[(p.X, p.Y, p.Z) for p in (made.PointAt(float(u), float(v)) for v in vs)] for u in us]
    made = surface.to_occ()
    return [[(p.X(), p.Y(), p.Z()) for p in (made.Value(float(u), float(v)) for v in vs)] for u in us]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", FITS)
def test_points_are_those_of_the_server(client: piad.Client, name: str, kind: str) -> None:
    job = client.create(**FITS[name])
    geometry = job.result().geometry
    if isinstance(geometry, piad.Curve):
        samples = job.samples(57)
        points = of_curve(kind, geometry, samples.parameters[0])
    else:
        samples = job.samples((17, 13))
        points = of_surface(kind, geometry, *samples.parameters)
    expected = in_space(samples.points)
    difference = np.abs(in_space(points) - expected).max()
    assert difference <= 1e-12 * np.abs(expected).max()


def test_iterations_are_geometry_too(client: piad.Client) -> None:
    job = client.create(**FITS["homogeneous"])
    job.wait()
    curve = job.iteration(3).geometry
    samples = job.samples(20, 3)
    assert np.allclose(curve.evaluate(samples.parameters[0]), samples.points, rtol=1e-12, atol=1e-12)


def test_single_parameters_have_no_axis(client: piad.Client) -> None:
    surface = client.fit(**FITS["surface"]).surface
    assert surface.evaluate(1.0, 1.0).shape == (3,)
    assert surface.evaluate([1.0, 2.0], 1.0).shape == (2, 3)
    assert surface.evaluate(1.0, [1.0, 2.0, 3.0]).shape == (3, 3)
    grid = surface.evaluate([1.0, 2.0], [1.0, 2.0, 3.0])
    assert grid.shape == (2, 3, 3)
    assert np.allclose(grid[1, 2], surface.evaluate(2.0, 3.0), rtol=1e-15)


def test_closed_curves_go_round_and_others_end(client: piad.Client) -> None:
    ring = client.fit(**FITS["closed"]).curve
    start, end = ring.domain
    turned = ring.evaluate([start + 1 + 3 * (end - start), start + 1 - (end - start)])
    assert np.allclose(turned, ring.evaluate(start + 1), rtol=1e-12)
    curve = client.fit(CURVE).curve
    with pytest.raises(ValueError, match="not between"):
        curve.evaluate([0.0, curve.domain[1] + 1])
    with pytest.raises(ValueError, match="not between"):
        curve.evaluate(float("nan"))


def test_what_packages_cannot_say_is_refused(client: piad.Client) -> None:
    with pytest.raises(ValueError, match="rational"):
        client.fit(**FITS["fixed"]).curve.to_scipy()
    values = client.fit([[1.0], [2.0], [4.0], [3.0]], parameters="uniform").curve
    for convert in (values.to_rhino, values.to_occ):
        with pytest.raises(ValueError, match="one coordinate"):
            convert()
    points = [[i, i % 3] for i in range(30)]
    with pytest.raises(ValueError, match="degree 29"):
        client.fit(points, basis="bernstein", method="direct").curve.to_occ()


@pytest.mark.parametrize("name", ["fixed", "fixed_surface"])
def test_arrays_have_other_names_in_ocp_8(client: piad.Client, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    geometry = client.fit(**FITS[name]).geometry
    arrays = ModuleType("OCP.collections")
    for newer, (module, former) in occ._ARRAYS.items():
        setattr(arrays, newer, getattr(import_module(module), former))
        monkeypatch.delattr(f"{module}.{former}")
    monkeypatch.setitem(sys.modules, "OCP.collections", arrays)
    made = geometry.to_occ()
    assert made.IsRational() if isinstance(geometry, piad.Curve) else made.IsURational()


def test_a_package_that_cannot_be_loaded_is_not_called_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "kernel_without_screen.py").write_text("raise ImportError('libGL.so.1: cannot open')")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(piad.MissingPackage, match=r"libGL\.so\.1: cannot open$"):
        load("kernel_without_screen", "kernel")
    with pytest.raises(piad.MissingPackage, match="pip install kernel$"):
        load("kernel_that_is_not_there", "kernel")


@pytest.mark.parametrize("kind", ["said_ball", "wang_ball"])
@pytest.mark.parametrize("degree", [1, 2, 3, 4, 7, 30, 1000])
def test_bezier_points_are_means_of_ball_points(kind: Any, degree: int) -> None:
    matrix = np.array(to_bezier(kind, degree))
    assert (matrix >= 0).all()
    assert np.allclose(matrix.sum(axis=1), 1, rtol=0, atol=1e-13)


def test_cubic_ball_points() -> None:
    for kind in ("said_ball", "wang_ball"):
        bezier = np.array(to_bezier(kind, 3)) @ [1, 2, 4, 8]  # type: ignore[arg-type]
        assert np.allclose(bezier, [1, 5 / 3, 16 / 3, 8], rtol=1e-15)


def test_heights_get_a_place(client: piad.Client) -> None:
    heights = np.sin(np.arange(5.0))[:, None] + np.arange(3.0) ** 2
    surface = client.fit(heights, spacing=(10, -2), origin=(100, 50), method="direct").surface
    places = surface.evaluate(*(np.linspace(*domain, count) for domain, count in zip(surface.domain, (5, 3))))
    x, y = np.meshgrid(100 + 10 * np.arange(3), 50 - 2 * np.arange(5))
    assert np.allclose(places, np.stack([x, y, heights], axis=-1), atol=1e-9)
    with pytest.raises(ValueError, match="heights with a spacing"):
        client.create(heights[0], spacing=(1, 1))


def test_surfaces_turn_across_creases(client: piad.Client) -> None:
    x, y = np.meshgrid(np.arange(21.0), np.arange(9.0), indexing="ij")
    points = np.stack([x, y, -np.abs(x - 8)], axis=-1)
    surface = client.fit(points, creases={"u": [8]}, control_points={"u": 5, "v": 4}).geometry
    assert isinstance(surface, piad.Surface)
    (low, high), v = surface.domain
    on = surface.evaluate(np.linspace(low, high, 200), np.linspace(*v, 20)).reshape(-1, 3)
    assert np.abs(on[:, 2] + np.abs(on[:, 0] - 8)).max() < 1e-6


@pytest.mark.parametrize("corners", ["auto", {"angle": 60}, np.array([4, 8, 12])])
def test_curves_turn_at_corners(client: piad.Client, corners: Any) -> None:
    x = np.arange(17.0)
    points = np.stack([x, np.abs(x % 8 - 4)], axis=1)
    curve = client.fit(points, corners=corners, method="direct").geometry
    assert isinstance(curve, piad.Curve)
    low, high = curve.domain
    on = curve.evaluate(np.linspace(low, high, 1000))
    assert np.abs(on[:, 1] - np.abs(on[:, 0] % 8 - 4)).max() < 1e-13


def test_the_edges_of_a_polyline_are_data(client: piad.Client) -> None:
    square = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]])
    curve = client.fit(square, polyline=True, closed=True, tolerance=1e-9).geometry
    assert isinstance(curve, piad.Curve)
    assert curve.closed and len(curve.control_points) == 13
    low, high = curve.domain
    t = np.linspace(low - 1.0, high + 1.0, 1001)
    on = curve.evaluate(t)
    assert np.abs(np.abs(on - 1.5).max(axis=1) - 1.5).max() < 1e-12
    assert np.allclose(curve.to_scipy()(t), on, rtol=0, atol=1e-12)


def test_data_choose_their_fairness(client: piad.Client) -> None:
    random = np.random.default_rng(1)
    s = np.linspace(0, 1, 150)
    truth = np.stack([100 * s, 20 * np.sin(7 * s)], axis=1)
    method = {"kind": "least_squares", "control_points": 50, "fairness": "auto"}
    noisy = truth + random.normal(0, 1.0, truth.shape)
    curve = client.fit(noisy, parameters="uniform", method=method).geometry
    assert isinstance(curve, piad.Curve)
    low, high = curve.domain
    off = curve.evaluate(np.linspace(low, high, 150)) - truth
    assert np.sqrt((off**2).sum(axis=1).mean()) < 0.6


def test_points_in_any_order_are_put_in_order(client: piad.Client) -> None:
    angle = np.linspace(0, 5, 100)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    mixed = points[np.random.default_rng(1).permutation(100)]
    fit = client.fit(mixed, order="nearest")
    low, high = fit.curve.domain
    on = fit.curve.evaluate(np.linspace(low, high, 500))
    assert np.abs(np.hypot(on[:, 0], on[:, 1]) - 1).max() < 1e-5


def test_outliers_are_left_out(client: piad.Client) -> None:
    s = np.linspace(0, 1, 150)
    points = np.stack([100 * s, 20 * np.sin(7 * s)], axis=1)
    points[[31, 77]] += [0, 15]
    fit = client.fit(points, method={"kind": "least_squares", "control_points": 25, "robust": True})
    assert fit.outliers == (31, 77)
    low, high = fit.curve.domain
    on = fit.curve.evaluate(np.linspace(low, high, 500))
    assert np.abs(on[:, 1] - 20 * np.sin(0.07 * on[:, 0])).max() < 0.05


def test_surfaces_are_trimmed_to_their_data(client: piad.Client) -> None:
    k = np.arange(3000)
    x, y = 2 * (k * 0.754877666 % 1) - 1, 2 * (k * 0.56984029 % 1) - 1
    points = np.stack([x, y, 0 * x], axis=1)[(np.hypot(x, y) < 0.9) & (np.hypot(x, y) > 0.4)]
    fit = client.fit(points, scattered=True, parameters="project", trim={"distance": 0.1}, control_points=4)
    assert fit.trim is not None and fit.trim.area is not None
    assert (len(fit.trim.loops), fit.trim.faces, fit.trim.distance) == (2, ((0, 1),), 0.1)
    areas = []
    for loop in fit.trim.loops:
        low, high = loop.domain
        u, v = np.asarray(loop.evaluate(np.linspace(low, high, 2000))).T
        areas.append(0.5 * float((u[:-1] * v[1:] - u[1:] * v[:-1]).sum()))
    assert areas[0] > 0 > areas[1]
    assert abs(sum(areas) / fit.trim.area - 1) < 1e-3


def test_ends_have_the_derivatives_that_are_given(client: piad.Client) -> None:
    angle = np.linspace(0, np.pi, 9)
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    start = {"derivative": np.array([0.0, 1.0])}
    curve = client.fit(points, ends={"start": start, "end": "natural"}, method="direct").geometry
    assert isinstance(curve, piad.Curve)
    spline = curve.to_scipy()
    low, high = curve.domain
    assert np.allclose(spline(low, 1), [0, 1], atol=1e-12)
    assert np.allclose(spline(high, 2), 0, atol=1e-12)
    repeated = client.fit(points, ends="repeated", method="direct").geometry
    assert isinstance(repeated, piad.Curve)
    assert np.allclose(repeated.to_scipy()(low, 1), 0, atol=1e-12)
    # The default is more than ten times nearer to the circle.
    usual = client.fit(points, method="direct").geometry
    far = [np.abs(np.linalg.norm(it.evaluate(np.linspace(low, high, 200)), axis=1) - 1).max() for it in (usual, repeated)]
    assert 10 * far[0] < far[1]

"""Jobs from their beginning to their end."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from conftest import Server
from shapes import CURVE, FITS, SURFACE

import piad

# Fits that take a while.
SLOW = {"basis": "bernstein", "relative_tolerance": 1e-15, "max_iterations": 1_000_000}
MANY = [[float(i), float(i % 7)] for i in range(200)]


def test_fits_go_through_the_points(client: piad.Client) -> None:
    result = client.fit(np.array(CURVE), tolerance=1e-9, name="arc")
    assert (result.state, result.name) == ("converged", "arc")
    curve = result.curve
    assert np.allclose(curve.evaluate(curve.domain[1]), CURVE[-1], atol=1e-9)
    surface = client.fit(np.array(SURFACE), parameters="uniform", tolerance=1e-9).surface
    assert surface.degrees == (3, 3)
    with pytest.raises(TypeError):
        _ = result.surface


def test_fits_choose_their_knots(client: piad.Client) -> None:
    angles = np.linspace(-np.pi / 2, np.pi / 2, 500)
    points = np.column_stack([np.cos(angles), np.sin(angles) * np.cos(angles)])
    job = client.create(points, method={"kind": "least_squares", "control_points": "auto"}, tolerance=1e-4)
    parameters = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    counts = []
    for iteration in job.iterations():
        curve = iteration.geometry
        distances = np.linalg.norm(curve.evaluate(parameters) - points, axis=1)
        # Parameters differ by rounding of sums of 500 chords.
        assert abs(distances.max() - iteration.error.max) < 1e-12
        counts.append(len(curve.control_points))
    assert counts[0] == 4 and counts[-1] <= 19
    assert job.iteration(10).geometry.knots != job.iteration("last").geometry.knots
    result = job.result()
    assert result.curve.knots == iteration.geometry.knots
    resumed = list(job.iterations(after=12))
    assert resumed[0].geometry.knots == job.iteration(13).geometry.knots


def test_scattered_points_are_fitted(client: piad.Client) -> None:
    random = np.random.default_rng(7)
    uv = random.random((400, 2))
    points = np.column_stack([uv, 0.2 * np.sin(3 * uv[:, 0]) * uv[:, 1]])
    method = {"kind": "least_squares", "control_points": 7, "variant": "direct"}
    for parameters in (uv, "auto", None, "project", {"project": "xy"}):
        result = client.fit(points, scattered=True, parameters=parameters, method=method)
        assert result.surface.degrees == (3, 3)
        assert result.error.max < 0.002
        assert isinstance(result.error.at, int)
    rough = client.create(points, scattered=True, parameters=uv, method=method)
    assert rough.wait(60).ended
    base = {"foot_points": {"job": rough.id}}
    assert client.fit(points, scattered=True, parameters=base, method=method).error.max < 0.002
    job = client.create(points, scattered=True, parameters=uv, method=method)
    assert np.array_equal(job.input()["surface"]["scattered"], points)
    with pytest.raises(ValueError):
        client.create(points.reshape(20, 20, 3), scattered=True, parameters=uv, method=method)


def test_data_are_measured_from_the_nearest_points(client: piad.Client) -> None:
    angles = np.linspace(0, np.pi, 60)
    points = np.column_stack([np.cos(angles), np.sin(angles)]) * (1 + 0.01 * (-1) ** np.arange(60))[:, None]
    job = client.create(points, method={"kind": "least_squares", "control_points": 7})
    result = job.result(60)
    deviation = job.deviation(distances=True)
    assert deviation.max <= result.error.max and deviation.rms <= result.error.rms
    assert deviation.distances.shape == (60,) and deviation.distances[deviation.at] == deviation.max
    assert list(deviation.percentiles) == [50, 90, 95, 99]
    places = result.curve.evaluate(np.linspace(*result.curve.domain, 20001))
    nearest = np.linalg.norm(places[None, :, :] - points[:, None, :], axis=2).min(axis=1)
    # Samples are 1.6e-4 apart.
    assert np.abs(nearest - deviation.distances).max() < 2e-4
    first = job.deviation(0)
    assert (first.iteration, first.distances) == (0, None)
    grid = np.array(SURFACE)
    surface = client.create(grid, parameters="uniform")
    assert surface.wait(60).ended
    surface = surface.deviation(distances=True)
    assert surface.distances.shape == grid.shape[:2] and isinstance(surface.at, tuple)


def test_curvature_of_curves_and_surfaces(client: piad.Client) -> None:
    angles = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    circle = 2 * np.column_stack([np.cos(angles), np.sin(angles)])
    job = client.create(circle, closed=True, method="direct")
    assert job.wait(60).ended
    shape = job.curvature(samples=50)
    assert isinstance(shape, piad.CurveShape)
    assert (shape.points.shape, shape.parameters.shape) == ((50, 2), (50,))
    assert np.abs(shape.curvature - 0.5).max() < 2e-3
    assert abs(shape.length - 4 * np.pi) < 1e-4
    assert shape.extremes.largest is not None and abs(shape.extremes.largest.value - 0.5) < 2e-3
    assert len(shape.knots) == 40
    assert {(knot.guaranteed, knot.geometric) for knot in shape.knots} == {(2, 2)}
    spaced = job.curvature(0, spacing=0.5)
    assert isinstance(spaced, piad.CurveShape) and spaced.iteration == 0
    steps = np.linalg.norm(np.diff(spaced.points, axis=0), axis=1)
    assert np.ptp(steps) < 0.02 and steps.max() < 0.5
    still = client.create(CURVE, ends="repeated")
    assert still.wait(60).ended
    ends = still.curvature(samples=5, by_length=True)
    assert np.isnan(ends.curvature[[0, -1]]).all() and len(ends.degenerate) == 2
    grid = client.create(np.array(SURFACE), parameters="uniform")
    assert grid.wait(60).ended
    shape = grid.curvature(samples=(7, 9))
    assert isinstance(shape, piad.SurfaceShape)
    assert shape.points.shape == (7, 9, 3) and [len(line) for line in shape.parameters] == [7, 9]
    assert np.allclose(shape.gaussian, shape.k1 * shape.k2)
    assert set(shape.extremes) == {"k1", "k2", "gaussian", "mean"}
    largest = shape.extremes["k1"].largest
    assert largest is not None and largest.value >= np.nanmax(shape.k1) - 1e-12
    assert isinstance(largest.parameter, tuple) and len(largest.point) == 3
    with pytest.raises(piad.ApiError, match="40x40"):
        grid.curvature(samples=7)


def test_jobs_are_found_waited_for_and_deleted(client: piad.Client) -> None:
    job = client.create(CURVE, name="one")
    assert job.wait(30).ended
    again = client.job(job.id)
    assert again.status.name == "one"
    assert again.input()["curve"]["points"] == CURVE
    again.delete()
    with pytest.raises(piad.ApiError) as refused:
        job.refresh()
    assert refused.value.status == 404
    assert refused.value.problem.type == "/problems/unknown-job"


def test_servers_may_ask_for_a_token(client: piad.Client, tmp_path: Path) -> None:
    token = f"piad_{'0123456789abcdef' * 4}"
    server = Server(str(tmp_path / "data"), token=token)
    with piad.Client(server.url) as anonymous, piad.Client(server.url, token=token) as owner:
        with pytest.raises(piad.ApiError) as refused:
            anonymous.create(CURVE)
        assert refused.value.problem.type == "/problems/unauthenticated"
        job = owner.create(CURVE)
        assert job.wait(30).ended
        events = f"{server.url}/v1/jobs/{job.id}/events"
        assert httpx.get(events).status_code == 401
        assert "event: end" in httpx.get(events, params={"ticket": job.ticket()}).text
    server.kill()
    with pytest.raises(piad.ApiError) as needless:
        client.create(CURVE).ticket()
    assert needless.value.problem.type == "/problems/no-tickets"


def test_cancelled_jobs_have_a_result(client: piad.Client) -> None:
    job = client.create(MANY, **SLOW)
    with pytest.raises(piad.WaitTimeout):
        job.wait(0.05)
    next(iter(job.iterations(view="errors")))
    assert job.cancel().state == "cancelled"
    assert job.result().state == "cancelled"
    ended = client.create(CURVE).wait(30)
    with pytest.raises(piad.ApiError) as refused:
        client.job(ended.id).cancel()
    assert refused.value.status == 409


def test_what_is_doubtful_is_a_warning(client: piad.Client) -> None:
    job = client.create(CURVE[:3], degree=5, ends="repeated")
    (warning,) = job.wait().warnings
    assert (warning.code, warning.pointer) == ("few_points", "/curve/basis/degree")
    assert "degree 5" in warning.detail
    assert client.create(CURVE).status.warnings == ()


def test_edits_start_from_the_job(client: piad.Client) -> None:
    job = client.create(CURVE)
    job.wait()
    edit = job.edit({3: [1.0, 2.0, 3.0]}, method={"kind": "local", "indices": np.array([2, 3, 4])}, iteration=2)
    assert edit.status.parent == {"id": job.id, "iteration": 2}
    edit.wait()
    assert edit.input()["curve"]["points"][3] == [1.0, 2.0, 3.0]
    surface = client.create(**FITS["homogeneous_surface"])
    surface.wait()
    moved = surface.edit({(1, 2): np.array([1.0, 2.0, 0.5])}, point_weights={(1, 2): 2.0, (0, 0): 1.5})
    moved.wait()
    asked = moved.input()["surface"]
    assert asked["points"][1][2] == [1.0, 2.0, 0.5]
    assert (asked["weights"][1][2], asked["weights"][0][0]) == (2.0, 1.5)


@pytest.mark.parametrize(
    ("format", "start"),
    [("step", b"ISO-10303-21"), ("gltf", b"glTF"), ("svg", b"<"), ("csv", b""), ("iges", b""), ("obj", b""), ("dxf", b"999")],
)
def test_downloads(client: piad.Client, tmp_path: Path, format: str, start: bytes) -> None:
    job = client.create(CURVE)
    job.wait()
    path = job.download(format, tmp_path / "file")  # type: ignore[arg-type]
    assert path.read_bytes().startswith(start) and path.stat().st_size > 100
    assert job.download(format, tmp_path / "first", iteration=0).exists()  # type: ignore[arg-type]
    assert len(list(tmp_path.iterdir())) == 2


def test_lists_go_over_pages(client: piad.Client) -> None:
    made = [client.create(CURVE).id for _ in range(7)]
    for id in made:
        client.job(id).wait()
    listed = [job.id for job in client.jobs("converged", page=3)]
    assert [id for id in listed if id in made] == made[::-1]
    assert len(listed) == len(set(listed))


def test_errors_point_at_what_is_wrong(client: piad.Client) -> None:
    with pytest.raises(piad.ApiError) as refused:
        client.fit([[0, 0], [1, 1], [1, 1], [2, 0]])
    problem = refused.value.problem
    assert (problem.status, problem.type) == (422, "/problems/invalid-fit")
    assert problem.pointers == ("/curve/points/2",)
    assert problem.request_id and "point 2 equals point 1" in str(refused.value)
    with pytest.raises(ValueError, match="dimensions"):
        client.fit([1.0, 2.0])
    with pytest.raises(ValueError):
        client.fit([[0.0, float("nan")], [1.0, 1.0]])


def test_failed_jobs_say_why(client: piad.Client) -> None:
    points = [[i, math.sin(i)] for i in range(900)]
    method = {"kind": "extended", "start": "data"}
    job = client.create(points, parameters="uniform", basis="bernstein", method=method)
    assert job.wait().state == "failed"
    with pytest.raises(piad.JobFailed) as failed:
        job.result()
    assert failed.value.problem is not None
    assert failed.value.problem.type == "/problems/overflow"


def test_keys_make_one_job(client: piad.Client) -> None:
    first, second = (client.create(CURVE, idempotency_key="one-key") for _ in range(2))
    assert first.id == second.id
    assert client.create(CURVE).id != first.id
    with pytest.raises(piad.ApiError) as refused:
        client.create(CURVE, degree=2, idempotency_key="one-key")
    assert refused.value.problem.type == "/problems/key-taken"


def test_a_tube_is_closed(client: piad.Client) -> None:
    random = np.random.default_rng(11)
    angle, height = random.uniform(0, 2 * np.pi, 900), random.uniform(0, 40, 900)
    points = np.column_stack([10 * np.cos(angle), 10 * np.sin(angle), height])
    for parameters in (None, {"project": "cylinder", "axis": np.array([0.0, 0.0, 1.0])}):
        result = client.fit(points, scattered=True, parameters=parameters, control_points="auto", tolerance=0.01)
        (start, end), (low, high) = result.surface.domain
        rows = result.surface.evaluate([start, end], np.linspace(low, high, 9))
        assert np.allclose(rows[0], rows[1], atol=1e-10)


def test_sections_have_any_number_of_points(client: piad.Client) -> None:
    def ring(count: int, height: float, start: float) -> Any:
        angle = start + 2 * np.pi * np.arange(count) / count
        return np.stack([3 * np.cos(angle), 2 * np.sin(angle), np.full(count, height)], axis=1)

    sections = [ring(20, 0, 0), ring(31, 2, 1)[::-1], ring(24, 4, 2), ring(26, 6, 5)]
    result = client.fit(sections, sections=True, tolerance=0.001)
    assert result.state == "converged"
    (low, high), (start, end) = result.surface.domain
    columns = result.surface.evaluate(np.linspace(low, high, 9), [start, end])
    assert np.allclose(columns[:, 0], columns[:, 1], atol=1e-10)
    x, y, _ = columns[4, 0]
    assert abs((x / 3) ** 2 + (y / 2) ** 2 - 1) < 0.01
    with pytest.raises(piad.PiadError, match="section 1 is the same"):
        client.fit([sections[0], sections[0]], sections=True)

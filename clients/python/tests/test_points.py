"""Files of points that the server reads."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import piad

WING = "Größe 12\n1 0.0013\n0.5 0.04\n0 0\n0.5 -0.03\n\nfrom somebody\n"
CLOUD = "0 0 1\n1 0 2\n2 0 3\n0 1 1\n1 1.5 2\n2 1 3\n"


def test_curves_are_read_and_fitted(client: piad.Client) -> None:
    wing = client.read_points(WING)
    assert np.array_equal(wing.points, [[1, 0.0013], [0.5, 0.04], [0, 0], [0.5, -0.03]])
    assert wing.name == "Größe 12"
    (notice,) = wing.notices
    assert "from line 7 on" in notice
    encoded = client.read_points(WING.encode())
    assert (encoded.points.tolist(), encoded.name) == (wing.points.tolist(), wing.name)
    result = client.fit(wing.points, name=wing.name, tolerance=1e-9)
    assert (result.state, result.name) == ("converged", wing.name)


def test_surfaces_are_said_or_seen(client: piad.Client) -> None:
    assert client.read_points(CLOUD).points.shape == (6, 3)
    rows = client.read_points(CLOUD, size="2x3")
    assert rows.points.shape == (2, 3, 3)
    assert rows.points[1, 1].tolist() == [1, 1.5, 2]
    assert client.read_points(CLOUD.replace("1.5", "1")).points.shape == (2, 3, 3)
    assert len(client.fit(rows.points, degree={"u": 1, "v": 2}).surface.control_points) == 2


def test_errors_have_lines(client: piad.Client) -> None:
    with pytest.raises(piad.ApiError) as refused:
        client.read_points("x,y\n1,2\n3,oops\n4\n")
    problem = refused.value.problem
    assert (problem.status, [error.line for error in problem.errors]) == (422, [3, 4])
    assert problem.errors[0].detail == 'column 2: "oops" is no number'
    with pytest.raises(piad.ApiError) as refused:
        client.read_points(CLOUD, size="many")
    assert [error.parameter for error in refused.value.problem.errors] == ["surface.size"]


def test_one_of_several_curves_is_read(client: piad.Client, tmp_path: Path) -> None:
    file = tmp_path / "two.csv"
    file.write_text("id,x,y\n7,0,0\n8,1,2\n9,2,1\n\n1,5,5\n2,6,7\n3,7,9\n4,8,6\n")
    with pytest.raises(piad.ApiError) as refused:
        client.read_points(file)
    assert [error.parameter for error in refused.value.problem.errors] == ["part"]
    second = client.read_points(file, part=2)
    assert second.points.tolist() == [[5, 5], [6, 7], [7, 9], [8, 6]]
    assert any("(id) is not read" in notice for notice in second.notices)
    swapped = client.read_points(file, part=1, columns="y,x")
    assert swapped.points.tolist() == [[0, 0], [2, 1], [1, 2]]


def test_files_are_fitted(client: piad.Client) -> None:
    timed = b"time,j1,j2,j3\n0,0,1,2\n1,1,2,1\n3,2,1,0\n4,3,0,4\n"
    result = client.fit_file(timed, tolerance=1e-9)
    assert result.state == "converged"
    assert result.parameters[0].tolist() == [0, 1, 3, 4]


def test_sections_and_meshes_are_fitted_as_they_are_read(client: piad.Client) -> None:
    angles = [2 * np.pi * np.arange(count) / count for count in (12, 15, 11)]
    rings = [np.column_stack([3 * np.cos(a), 2 * np.sin(a), np.full(len(a), 4.0 * k)]) for k, a in enumerate(angles)]
    text = "\n".join("".join(f"{x} {y} {z}\n" for x, y, z in ring) for ring in rings)
    sections = client.read_points(text)
    assert sections.scattered and sections.parameters == {"sections": [12, 15, 11]}
    result = client.fit(sections.points, scattered=True, parameters=sections.parameters, tolerance=0.01)
    assert result.state == "converged"
    with pytest.raises(piad.ApiError, match="3 parts"):
        client.read_points(text, sections=False)
    places = [(x, y, x * y / 10) for x in range(5) for y in range(6)]
    faces = [(6 * i + j + 1, 6 * i + j + 7, 6 * i + j + 8, 6 * i + j + 2) for i in range(4) for j in range(5)]
    lines = ["v %g %g %g" % place for place in places] + ["f %d %d %d %d" % face for face in faces]
    mesh = client.read_points("\n".join(lines) + "\n")
    assert mesh.scattered and isinstance(mesh.parameters, dict) and len(mesh.parameters["triangles"]) == 40
    assert client.fit(mesh.points, scattered=True, parameters=mesh.parameters, tolerance=0.01).state == "converged"
    with pytest.raises(piad.ApiError, match="piece"):
        client.read_points("\n".join(lines) + "\n", piece=2)


def test_files_of_surfaces_are_fitted(client: piad.Client) -> None:
    """Point clouds on request, sections and meshes automatically."""
    cloud = "\n".join(f"{37 * i % 20 / 7:.4f} {53 * i % 17 / 5:.4f} {0.1 * (37 * i % 20) * (i % 17):.4f}" for i in range(200))
    with pytest.raises(piad.ApiError, match="order"):
        client.fit_file(cloud, tolerance=10.0)
    method = {"kind": "least_squares", "control_points": 4}
    result = client.fit_file(cloud, scattered=True, method=method)
    assert result.surface.control_points.shape == (4, 4, 3)
    counts = [24, 30, 27, 33, 25]
    around = [[2 * math.pi * i / count for i in range(count)] for count in counts]
    rings = [[(5 * math.cos(a), 3 * math.sin(a), 2.0 * k) for a in angles] for k, angles in enumerate(around)]
    sections = "\n\n".join("\n".join("%.6f,%.6f,%.6f" % point for point in ring) for ring in rings)
    read = client.read_points(sections)
    assert read.scattered and read.parameters == {"sections": counts}
    assert client.fit_file(sections, tolerance=1e-3).error.max <= 1e-3
    mesh = "".join(f"v {i % 6} {i // 6} {(i % 6) * (i // 6) / 9}\n" for i in range(36))
    mesh += "".join(f"f {i + 1} {i + 2} {i + 8} {i + 7}\n" for i in range(29) if i % 6 < 5)
    assert client.fit_file(mesh, tolerance=1e-3).surface is not None

"""Surfaces that join along a boundary to which one is constrained."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from shapes import CURVE, FITS, SURFACE, TUBE

import piad

SIDES = ["u_start", "u_end", "v_start", "v_end"]


def patch(first: float) -> Any:
    u, v = np.meshgrid(first + np.linspace(0, 2, 21), np.linspace(0, 3, 17), indexing="ij")
    height = np.sin(1.3 * u) * np.cos(v) + 0.01 * np.sin(37 * u + 41 * v)
    return np.stack([u, v, height], axis=-1)


def derivative(surface: piad.Surface, side: str, along: Any, step: float = 1e-5) -> Any:
    """Computed by one-sided differences of second order."""
    axis, end = side.split("_")
    low, high = surface.domain[0 if axis == "u" else 1]
    at, inward = (low, step) if end == "start" else (high, -step)
    places = [at, at + inward, at + 2 * inward]
    if axis == "u":
        values = surface.evaluate(places, along)
    else:
        values = np.swapaxes(surface.evaluate(along, places), 0, 1)
    return (-3 * values[0] + 4 * values[1] - values[2]) / (2 * inward)


@pytest.mark.parametrize("name", ["surface", "mixed_surface"])
@pytest.mark.parametrize("side", SIDES)
def test_boundaries_are_those_of_the_surface(client: piad.Client, name: str, side: str) -> None:
    result = client.fit(**FITS[name])
    surface, found = result.surface, piad.boundary(result, side)
    other = surface.bases[1 if side.startswith("u") else 0]
    low, high = other.domain
    along = np.linspace(low, high, 7)
    curve = piad.Curve(other, found.control_points).evaluate(along)
    start, end = surface.domain[0 if side.startswith("u") else 1]
    at = start if side.endswith("start") else end
    points = surface.evaluate(at, along) if side.startswith("u") else surface.evaluate(along, at)
    assert np.abs(curve - points).max() < 1e-12
    across = piad.Curve(other, found.cross_derivatives).evaluate(along)
    assert np.abs(across - derivative(surface, side, along)).max() < 1e-6


@pytest.mark.parametrize(("mine", "theirs", "turn"), [("u_end", "u_start", 1.0), ("v_end", "u_start", 1.0), ("u_end", "u_end", -1.0)])
def test_neighbours_join(client: piad.Client, mine: str, theirs: str, turn: float) -> None:
    method = {"kind": "least_squares", "control_points": 9, "variant": "cg"}
    first = patch(0.0)
    if mine.startswith("v"):
        first = np.swapaxes(first, 0, 1)
    left = client.fit(first, method=method, parameters="uniform")
    second = patch(2.0)
    if turn < 0:
        second = second[::-1]
    constraints = piad.boundary(left, mine).constraints(theirs, scale=turn)
    job = client.create(
        second,
        method={**method, "constraints": constraints},
        parameters="uniform",
        max_iterations=5,
        tolerance=0,
    )
    along = np.linspace(*left.surface.domain[1 if mine.startswith("u") else 0], 9)
    for iteration in job.iterations():
        right = iteration.geometry
        assert isinstance(right, piad.Surface)
        got = piad.boundary(iteration, theirs)
        wanted = piad.boundary(left, mine)
        assert np.abs(got.control_points - wanted.control_points).max() < 1e-12
        assert np.abs(got.cross_derivatives - turn * wanted.cross_derivatives).max() < 1e-10
        # The tangent planes are the same.
        normals = []
        for surface, side in ((left.surface, mine), (right, theirs)):
            low, high = surface.domain[0 if side.startswith("u") else 1]
            at = low if side.endswith("start") else high
            points = surface.evaluate(at, along) if side.startswith("u") else surface.evaluate(along, at)
            tangents = np.gradient(points, axis=0)
            normal = np.cross(tangents, derivative(surface, side, along))
            normals.append(normal / np.linalg.norm(normal, axis=-1, keepdims=True))
        angles = np.linalg.norm(np.cross(*normals), axis=-1)
        assert angles.max() < 1e-5 and math.isfinite(angles.max())


def test_what_has_no_boundary(client: piad.Client) -> None:
    with pytest.raises(TypeError, match="curve"):
        piad.boundary(client.fit(CURVE), "u_end")
    tube = client.fit(TUBE, closed={"u": True, "v": False})
    with pytest.raises(ValueError, match="closed in u"):
        piad.boundary(tube, "u_end")
    assert len(piad.boundary(tube, "v_end").control_points) == tube.surface.bases[0].count
    rational = client.fit(**FITS["homogeneous_surface"])
    with pytest.raises(ValueError, match="rational"):
        piad.boundary(rational, "v_start")
    found = piad.boundary(client.fit(SURFACE), "v_start")
    with pytest.raises(ValueError, match="scale 0"):
        found.constraints("u_start", scale=0)
    with pytest.raises(ValueError, match="u_top"):
        piad.boundary(client.fit(SURFACE), "u_top")  # type: ignore[arg-type]

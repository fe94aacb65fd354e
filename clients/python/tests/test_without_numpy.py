"""The client with only httpx installed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from conftest import Server

PROGRAM = """
import sys

for name in ("numpy", "scipy", "geomdl", "rhino3dm", "OCP", "matplotlib"):
    sys.modules[name] = None  # importing it is an ImportError

from shapes import FITS

import piad


def close(points, expected):
    if isinstance(points, list):
        return len(points) == len(expected) and all(map(close, points, expected))
    return abs(points - expected) <= 1e-11


def apart(points, expected):
    if isinstance(points, list):
        return max(map(apart, points, expected))
    return abs(points - expected)


def derived(geometry, parameters):
    # In the first parameter, by differences.
    step, order = 1e-6, 1 if isinstance(geometry, piad.Curve) else (1, 0)
    middle, others = parameters[0][3], [line[2] for line in parameters[1:]]
    before, after = (geometry.evaluate(u, *others) for u in (middle - step, middle + step))
    found = geometry.evaluate(middle, *others, derivative=order)
    assert isinstance(found, list)
    assert all(abs(d - (b - a) / (2 * step)) <= 1e-6 for d, a, b in zip(found, before, after))
    if geometry.weights is None:
        assert close(geometry.derivative(1).evaluate(middle, *others), found)


with piad.Client(sys.argv[1]) as client:
    for name, arguments in FITS.items():
        job = client.create(**arguments)
        for encoding in (None, "base64"):
            level = list(job.iterations(encoding=encoding))[-1]
            assert isinstance(level.control_points, list)
            count = 9 if job.status.kind == "curve" else (5, 4)
            samples = job.samples(count)
            assert close(level.geometry.evaluate(*samples.parameters), samples.points), name
        for exact, near in zip(job.iterations(encoding="base64"), job.iterations(encoding="delta")):
            assert apart(exact.control_points, near.control_points) <= exact.error.max / 64 + 1e-13, name
            assert exact.weights is None or apart(exact.weights, near.weights) <= exact.error.max
        geometry = job.result().geometry
        derived(geometry, samples.parameters)
        assert close(geometry.as_bspline().evaluate(*samples.parameters), samples.points), name
        shape = job.curvature(samples=count)
        assert isinstance(shape.points, list) and isinstance(shape, (piad.CurveShape, piad.SurfaceShape))
    local = client.create(FITS["curve"]["points"], method={"kind": "local", "indices": [2]})
    pairs = zip(local.iterations(changed=True), local.iterations())
    assert all(a.control_points == b.control_points for a, b in pairs)
    curve = local.result().curve
    assert isinstance(curve.evaluate(0.5), list)
    for convert in (curve.to_scipy, curve.to_geomdl, curve.to_rhino, curve.to_occ):
        try:
            convert()
        except piad.MissingPackage as error:
            assert "pip install" in str(error)
        else:
            raise AssertionError(convert)
"""


def test_nothing_but_httpx_is_needed(server: Server) -> None:
    command = [sys.executable, "-c", PROGRAM, server.url]
    done = subprocess.run(command, cwd=Path(__file__).parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr

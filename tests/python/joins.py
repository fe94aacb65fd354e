"""Joins surfaces fitted one after the other by a real server, and measures the seam in OpenCASCADE.

    joins.py PROGRAM                # the server to start, such as target/debug/piad

The second patch is constrained to the boundary of the first one and to its derivative across it, so
both have the same tangent planes there at each iteration. Needs the packages of requirements.txt.
"""

import json
import os
import sys
import tempfile

import numpy as np
from OCP.GeomAbs import GeomAbs_G1
from OCP.LocalAnalysis import LocalAnalysis_SurfaceContinuity

import cad
from offsets import peaks
from over_http import fetch, server

# Distances and angles of the seam caused by rounding.
TOLERANCE = 1e-9


def patch(low: float, high: float, rows: int, columns: int) -> list:
    """Part of `peaks` as scanned, with deterministic noise."""
    x, y = np.meshgrid(np.linspace(low, high, rows), np.linspace(-3, 3, columns), indexing="ij")
    noise = 0.02 * np.sin(91 * x + 57 * y) * np.cos(73 * x - 31 * y)
    return np.stack([x, y, peaks(x, y) + noise], axis=2).tolist()


def job(points: list, degree: dict, constraints: list, variant: str) -> dict:
    basis = {axis: {"kind": "bspline", "degree": p} for axis, p in degree.items()}
    method = {"kind": "least_squares", "control_points": {"u": 14, "v": 12}, "variant": variant}
    if constraints:
        method["constraints"] = constraints
    return {
        "surface": {"points": points, "basis": basis, "parameters": "uniform"},
        "method": method,
        "stop": {"tolerance": 0, "max_iterations": 12},
    }


def fit(base: str, asked: dict) -> dict:
    resource = json.loads(fetch(f"{base}/v1/jobs", json.dumps(asked).encode()))
    assert resource["state"] in ("converged", "exhausted") or resource["reason"] == "minimum", resource
    return resource


def boundary(result: dict, degree: int) -> list:
    """The last row of a net, and the derivative across it, as constraints at the first row of another one."""
    net, knots = np.array(result["control_points"]), result["knots"]["u"]
    across = degree * (net[-1] - net[-2]) / (knots[-1] - knots[-degree - 2])
    at = {"boundary": "u_start"}
    return [{"at": at, "control_points": net[-1].tolist()}, {"at": at, "cross_derivatives": across.tolist()}]


def surface(base: str, path: str, folder: str):
    file = os.path.join(folder, "patch.step")
    with open(file, "wb") as target:
        target.write(fetch(f"{base}{path}"))
    return cad.CadFile(file).geometry()


def seam(first, second) -> tuple[float, float]:
    """The largest distance and the largest angle between two surfaces along the end and the start of u."""
    distance = angle = 0.0
    _, end, low, high = first.Bounds()
    start, _, other_low, other_high = second.Bounds()
    for s in np.linspace(0, 1, 101):
        v, w = low + s * (high - low), other_low + s * (other_high - other_low)
        seam = LocalAnalysis_SurfaceContinuity(first, end, v, second, start, w, GeomAbs_G1)
        assert seam.IsDone(), f"at {s}"
        distance, angle = max(distance, seam.C0Value()), max(angle, seam.G1Angle())
    return distance, angle


def main() -> int:
    wrong, seams = [], 0
    with tempfile.TemporaryDirectory() as folder, server(sys.argv[1]) as base:
        for degree in ({"u": 3, "v": 3}, {"u": 2, "v": 4}, {"u": 5, "v": 3}):
            resource = fit(base, job(patch(-3, 0, 41, 60), degree, [], "direct"))
            links = resource["links"]
            first = surface(base, f"{links['result']}/step", folder)
            constraints = boundary(json.loads(fetch(f"{base}{links['result']}")), degree["u"])
            for variant in ("diagonal", "cg", "direct"):
                resource = fit(base, job(patch(0, 3, 37, 53), degree, constraints, variant))
                for k in range(resource["iteration"] + 1):
                    path = f"{resource['links']['self']}/iterations/{k}/step"
                    distance, angle = seam(first, surface(base, path, folder))
                    seams += 1
                    if max(distance, angle) > TOLERANCE:
                        wrong.append(f"{degree}, {variant}, iteration {k}: {distance:.1e} apart, angle {angle:.1e}")
            # The test is effective: without constraints there is a gap.
            resource = fit(base, job(patch(0, 3, 37, 53), degree, [], "direct"))
            distance, angle = seam(first, surface(base, f"{resource['links']['result']}/step", folder))
            if min(distance, angle) < 1e-4:
                wrong.append(f"{degree}: patches join by themselves, {distance:.1e} apart, angle {angle:.1e}")
    print("\n".join(wrong) or f"ok: {seams} seams are smooth to {TOLERANCE} in OpenCASCADE")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

"""Offsets curves and thickens surfaces of a real server in OpenCASCADE, which needs regular ends.

    offsets.py PROGRAM              # the server to start, such as target/debug/piad

With copies of the end points (ends: "repeated") the first derivative vanishes there, and
OpenCASCADE fails or returns wrong offsets; with the default end conditions it succeeds. Needs the
packages of requirements.txt.
"""

import json
import os
import sys
import tempfile

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepOffset import BRepOffset_MakeOffset, BRepOffset_Mode
from OCP.Geom import Geom_OffsetCurve
from OCP.GeomAbs import GeomAbs_Arc
from OCP.gp import gp_Dir, gp_Pnt, gp_Vec
from OCP.Standard import Standard_Failure
from OCP.TopAbs import TopAbs_FACE
from OCP.TopoDS import TopoDS

import cad
from over_http import fetch, server


def naca2412(count: int) -> list[list[float]]:
    """A closed trailing edge, from it over the upper side to the nose and back."""
    angle = np.linspace(0, 2 * np.pi, count)
    x = (1 + np.cos(angle)) / 2
    half = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    front = x < 0.4
    camber = np.where(front, 0.02 / 0.16 * (0.8 * x - x**2), 0.02 / 0.36 * (0.2 + 0.8 * x - x**2))
    slope = np.where(front, 0.04 / 0.16 * (0.4 - x), 0.04 / 0.36 * (0.4 - x))
    side = np.where(angle <= np.pi, 1, -1) * half
    turn = np.arctan(slope)
    return np.c_[x - side * np.sin(turn), camber + side * np.cos(turn)].tolist()


def grid(count: int, height) -> list:
    x, y = np.meshgrid(np.linspace(-3, 3, count), np.linspace(-3, 3, count), indexing="ij")
    return np.stack([x, y, height(x, y)], axis=2).tolist()


def scattered(count: int, height) -> list:
    """Pseudo-random positions: multiples of the inverses of the plastic number and of its
    square."""
    i = np.arange(1, count + 1)
    x, y = (6 * ((i * step) % 1) - 3 for step in (0.754877666246693, 0.569840290998053))
    return np.c_[x, y, height(x, y)].tolist()


def peaks(x, y):
    return (
        3 * (1 - x) ** 2 * np.exp(-(x**2) - (y + 1) ** 2)
        - 10 * (x / 5 - x**3 - y**5) * np.exp(-(x**2) - y**2)
        - np.exp(-((x + 1) ** 2) - y**2) / 3
    )


def saddle(x, y):
    return (x**2 - y**2) / 6


def shape(base: str, job: dict, folder: str):
    """The edge or face of a fit, as OpenCASCADE reads it from STEP."""
    resource = json.loads(fetch(f"{base}/v1/jobs", json.dumps(job).encode()))
    assert resource["state"] == "converged", resource
    path = os.path.join(folder, "fit.step")
    with open(path, "wb") as file:
        file.write(fetch(f"{base}{resource['links']['result']}/step"))
    return cad.CadFile(path)


def curvature(curve, t: float) -> float:
    point, first, second = gp_Pnt(), gp_Vec(), gp_Vec()
    curve.D2(t, point, first, second)
    return first.Crossed(second).Magnitude() / first.Magnitude() ** 3 if first.Magnitude() > 0 else np.inf


def offset_curve(file: cad.CadFile, distance: float) -> None:
    """The offset exists and keeps its distance everywhere, the ends included; the curvature is finite there."""
    curve = file.geometry()
    low, high = curve.FirstParameter(), curve.LastParameter()
    for t in (low, high):
        assert curvature(curve, t) < 1e3, f"curvature {curvature(curve, t)} at an end"
    offset = Geom_OffsetCurve(curve, distance, gp_Dir(0, 0, 1))
    for t in np.linspace(low, high, 501):
        there = offset.Value(float(t)).Distance(curve.Value(float(t)))
        assert abs(there - distance) < 1e-9, f"the offset at {t} is {there}"


def made(shape, thickness: float, solid: bool):
    maker = BRepOffset_MakeOffset()
    skin = BRepOffset_Mode.BRepOffset_Skin
    maker.Initialize(shape, thickness, 1e-6, skin, False, False, GeomAbs_Arc, solid, False)
    maker.MakeThickSolid() if solid else maker.MakeOffsetShape()
    assert maker.IsDone(), f"{maker.Error()}, solid: {solid}"
    assert BRepCheck_Analyzer(maker.Shape()).IsValid(), f"not valid, solid: {solid}"
    return maker.Shape()


def thicken(file: cad.CadFile, thickness: float) -> None:
    """The offset exists and keeps its distance everywhere, the border included, and there is a solid between."""
    made(file.shape, thickness, solid=True)
    [face] = cad.explore(made(file.shape, thickness, solid=False), TopAbs_FACE)
    here, moved = file.geometry(), BRep_Tool.Surface_s(TopoDS.Face_s(face))
    low_u, high_u, low_v, high_v = here.Bounds()
    for u in np.linspace(low_u, high_u, 31):
        for v in np.linspace(low_v, high_v, 31):
            there = moved.Value(float(u), float(v)).Distance(here.Value(float(u), float(v)))
            assert abs(there - thickness) < 1e-6, f"the offset at {u}, {v} is {there}"


def automatic(geometry: dict, tolerance: float) -> dict:
    """The fewest control points that meet the tolerance: knots that are not at the data."""
    method = {"kind": "least_squares", "control_points": "auto"}
    return geometry | {"method": method, "stop": {"tolerance": tolerance}}


def fails(check, *arguments) -> bool:
    try:
        check(*arguments)
    except (AssertionError, Standard_Failure, RuntimeError):
        return True
    return False


def main() -> int:
    cases = [
        ("NACA 2412, 61 points", {"curve": {"points": naca2412(61)}}, offset_curve, 0.01),
        ("half circle, 15 points", {"curve": {"points": [[np.cos(a), np.sin(a)] for a in np.linspace(0, np.pi, 15)]}}, offset_curve, 0.1),
        ("NACA 2412, degree 5", {"curve": {"points": naca2412(61), "degree": 5}}, offset_curve, 0.01),
        ("peaks, 25 x 25", {"surface": {"points": grid(25, peaks)}}, thicken, 0.02),
        ("saddle, 11 x 11", {"surface": {"points": grid(11, saddle)}}, thicken, 0.1),
        ("saddle, 12 x 7, weights", {"surface": {"points": [row[:7] for row in grid(12, saddle)], "weights": [[1 + 0.02 * (i + j) for j in range(7)] for i in range(12)]}}, thicken, 0.05),
    ]
    within = [
        ("NACA 2412 within 1e-4", automatic({"curve": {"points": naca2412(401)}}, 1e-4), offset_curve, 0.01),
        ("peaks within 0.01", automatic({"surface": {"points": grid(41, peaks)}}, 0.01), thicken, 0.02),
        ("scattered peaks within 0.01", automatic({"surface": {"scattered": scattered(1500, peaks), "parameters": {"project": "xy"}}}, 0.01), thicken, 0.02),
    ]
    wrong = []
    with tempfile.TemporaryDirectory() as folder, server(sys.argv[1]) as base:
        for name, job, check, distance in cases:
            try:
                check(shape(base, job, folder), distance)
            except (AssertionError, Standard_Failure, RuntimeError) as error:
                wrong.append(f"{name}: {error}")
            for geometry in job.values():
                geometry["ends"] = "repeated"
            # The checks are effective: repeated ends do not pass them.
            if not fails(check, shape(base, job, folder), distance):
                wrong.append(f"{name}: repeated ends pass, too")
        for name, job, check, distance in within:
            try:
                check(shape(base, job, folder), distance)
            except (AssertionError, Standard_Failure, RuntimeError) as error:
                wrong.append(f"{name}: {error}")
    print("\n".join(wrong) or f"ok: {len(cases) + len(within)} fits are offset and thickened by OpenCASCADE")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

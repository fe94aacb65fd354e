"""Compares sections of a body by piad and OpenCASCADE's ThruSections: area, distances between the
points, control points, time.

Run with the program and numpy, scipy and cadquery-ocp: python benches/sections/compare.py target/release/piad
Five ellipses with 24 to 57 points, as given and rotated, every other one reversed. `between` is the
largest distance of the surface from 60 positions on each ellipse, most of which are not data
points.
"""

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeVertex, BRepBuilderAPI_MakeWire
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.GProp import GProp_GProps
from OCP.STEPControl import STEPControl_Reader
from OCP.TColgp import TColgp_HArray1OfPnt
from OCP.gp import gp_Pnt

COUNTS = [24, 40, 31, 57, 36]


def ellipse(k: int, angle: np.ndarray) -> np.ndarray:
    a, b = 6 + 1.5 * np.sin(k), 4 + 0.8 * k
    return np.column_stack([a * np.cos(angle) + 0.4 * k, b * np.sin(angle), np.full(len(angle), 5.0 * k)])


def sections(turned: bool) -> list[np.ndarray]:
    rows = []
    for k, count in enumerate(COUNTS):
        angle = 2 * np.pi * np.arange(count) / count + (0.7 * k if turned else 0)
        rows.append(ellipse(k, angle[::-1] if turned and k % 2 else angle))
    return rows


def by_piad(program: str, rows: list[np.ndarray], tolerance: float, folder: Path):
    job, step = folder / "job.json", folder / "out.step"
    surface = {"sections": [row.tolist() for row in rows]}
    job.write_text(json.dumps({"surface": surface, "stop": {"tolerance": tolerance}}))
    start = time.perf_counter()
    subprocess.run([program, "fit", "-q", job, "-o", step, "-o", folder / "out.json"], check=True)
    seconds = time.perf_counter() - start
    reader = STEPControl_Reader()
    reader.ReadFile(str(step))
    reader.TransferRoots()
    net = np.array(json.loads((folder / "out.json").read_text())["control_points"])
    return reader.OneShape(), net.shape[0] * net.shape[1], seconds


def by_opencascade(rows: list[np.ndarray]):
    start = time.perf_counter()
    lofter = BRepOffsetAPI_ThruSections(False, False, 1e-6)
    for row in rows:
        array = TColgp_HArray1OfPnt(1, len(row))
        for k, point in enumerate(row):
            array.SetValue(k + 1, gp_Pnt(*map(float, point)))
        curve = GeomAPI_Interpolate(array, True, 1e-9)
        curve.Perform()
        lofter.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve.Curve()).Edge()).Wire())
    lofter.Build()
    return lofter.Shape(), None, time.perf_counter() - start


def main() -> None:
    program = sys.argv[1] if len(sys.argv) > 1 else "target/release/piad"
    between = [ellipse(k, np.linspace(0, 2 * np.pi, 61)[:-1] + 0.02) for k in range(len(COUNTS))]
    print(f"{'':28}{'valid':>6}{'area':>11}{'between':>10}{'control points':>16}{'s':>8}")
    for turned in (False, True):
        rows = sections(turned)
        with tempfile.TemporaryDirectory() as name:
            fits = {f"piad, {t:g}": by_piad(program, rows, t, Path(name)) for t in (0.01, 0.001)}
        fits["ThruSections"] = by_opencascade(rows)
        for what, (shape, count, seconds) in fits.items():
            properties = GProp_GProps()
            BRepGProp.SurfaceProperties_s(shape, properties)
            vertex = lambda p: BRepBuilderAPI_MakeVertex(gp_Pnt(*map(float, p))).Vertex()
            distance = max(
                BRepExtrema_DistShapeShape(vertex(p), shape).Value() for row in between for p in row
            )
            title = f"{'turned' if turned else 'straight'}, {what}"
            is_valid = BRepCheck_Analyzer(shape).IsValid()
            print(f"{title:28}{is_valid!s:>6}{properties.Mass():11.3f}{distance:10.1e}{count or '':>16}{seconds:8.3f}")


if __name__ == "__main__":
    main()

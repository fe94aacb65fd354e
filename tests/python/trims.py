"""Trims surfaces of a real server to their data, and measures the files with OpenCASCADE and
trimesh.

    trims.py PROGRAM                # the server to start, such as target/debug/piad

STEP and IGES files are valid, with the area of the result and of the mesh, and no data point is further outside than the
distance of the trim. Needs the packages of requirements.txt.
"""

import json
import os
import sys
import tempfile

import numpy as np
import trimesh
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_FACE, TopAbs_WIRE

import cad
from over_http import fetch, server

# Deviations of areas of exact surfaces and of triangles, relative to the area of the result.
EXACT, MESH = 3e-4, 1e-2
# The number of points whose distances are measured, which takes milliseconds each.
MEASURED = 300


def scattered(count: int) -> np.ndarray:
    """Points of the square from −1 to 1 in a sequence of low discrepancy."""
    k = np.arange(count)
    return np.stack([2 * (k * 0.754877666 % 1) - 1, 2 * (k * 0.56984029 % 1) - 1], axis=1)


def scan(inside, count: int = 3000) -> list:
    """A scan of a curved sheet, turned in space, where it is inside."""
    x, y = scattered(count).T
    kept = inside(x, y)
    x, y = x[kept], y[kept]
    z = 0.3 * np.sin(2 * x) * np.cos(y)
    turn = np.array([[0.8, -0.6, 0.0], [0.48, 0.64, -0.6], [0.36, 0.48, 0.8]])
    return (50 * np.stack([x, y, z], axis=1) @ turn + [100, 0, 20]).tolist()


def ragged(x, y):
    angle = np.arctan2(y, x)
    return (np.hypot(x, y) < 0.75 + 0.1 * np.sin(5 * angle)) & (np.hypot(x - 0.2, y - 0.1) > 0.25)


def islands(x, y):
    return (np.hypot(x - 0.5, y) < 0.35) | (np.hypot(x + 0.5, y - 0.2) < 0.4)


def wavy(x, y):
    return (x < 0.3 + 0.15 * np.sin(6 * y)) & ((np.abs(x + 0.3) > 0.2) | (np.abs(y) > 0.3))


def tube(end) -> list:
    """A tube of radius 10 with an end that is not straight."""
    a, z = scattered(4000).T
    a, z = np.pi * (a + 1), 15 * (z + 1)
    kept = z > end(a)
    return np.stack([10 * np.cos(a), 10 * np.sin(a), z], axis=1)[kept].tolist()


def terrain() -> dict:
    """Heights with two gaps, one of them at a corner."""
    i, j = np.meshgrid(np.arange(45), np.arange(60), indexing="ij")
    heights = 20 * np.sin(i / 9) * np.cos(j / 12)
    gap = (np.hypot(i - 30, j - 40) < 6) | (i + j < 14)
    rows = [[None if out else float(h) for h, out in zip(*row)] for row in zip(heights, gap)]
    return {"points": rows, "spacing": [10, 10]}


SURFACES = {
    "ragged scan with a hole": {"scattered": scan(ragged)},
    "islands": {"scattered": scan(islands)},
    "sheet with a straight side": {"scattered": scan(wavy)},
    "all of a sheet": {"scattered": scan(lambda x, y: x < 2)},
    "oblique tube": {"scattered": tube(lambda a: 6 + 4 * np.cos(a))},
    "terrain with gaps": terrain(),
}


def area(shape) -> float:
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, properties, 1e-6)
    return abs(properties.Mass())


def places(surface: dict) -> np.ndarray:
    if "scattered" in surface:
        return np.array(surface["scattered"])
    dx, dy = surface["spacing"]
    rows = surface["points"]
    return np.array([[dx * j, dy * i, h] for i, row in enumerate(rows) for j, h in enumerate(row) if h is not None])


def measure(path: str, trim: dict, points: np.ndarray, error: float, name: str) -> str:
    """Checks a CAD file and describes it."""
    file = cad.CadFile(path, None)
    faces, wires = (cad.explore(file.shape, kind) for kind in (TopAbs_FACE, TopAbs_WIRE))
    assert BRepCheck_Analyzer(file.shape).IsValid(), f"{name}: {path} is not valid"
    assert len(faces) == max(len(trim["faces"]), 1), (name, path, len(faces))
    found = area(file.shape)
    assert abs(found / trim["area"] - 1) < EXACT, (name, path, found, trim["area"])
    some = points[:: max(len(points) // MEASURED, 1)]
    furthest = max(file.distance(place) for place in some)
    assert furthest <= trim["distance"] + error, (name, path, furthest, trim["distance"])
    return f"{len(faces)} faces, {len(wires)} wires, area {found:.6g}, points at most {furthest:.3g} away"


def check(base: str, name: str, surface: dict, folder: str) -> None:
    asked = {
        "surface": {**surface, "trim": True},
        "method": {"kind": "least_squares", "control_points": {"u": 12, "v": 12}},
    }
    job = json.loads(fetch(f"{base}/v1/jobs", json.dumps(asked).encode()))
    link = base + job["links"]["result"]
    result = json.loads(fetch(link))
    trim, points = result["trim"], places(surface)
    print(f"{name}: {len(trim['loops'])} loops, area {trim['area']:.6g}, distance {trim['distance']:.3g}")
    paths = {}
    for format in ("step", "iges", "stl", "ply", "gltf"):
        paths[format] = os.path.join(folder, f"trim.{'glb' if format == 'gltf' else format}")
        with open(paths[format], "wb") as file:
            file.write(fetch(f"{link}/{format}"))
    for format in ("stl", "ply", "gltf"):
        mesh = trimesh.load(paths[format], force="mesh")
        assert abs(mesh.area / trim["area"] - 1) < MESH, (name, format, mesh.area, trim["area"])
    for format in ("step", "iges"):
        print(f"  {format}:", measure(paths[format], trim, points, result["error"]["max"], name))


def main() -> None:
    with tempfile.TemporaryDirectory() as folder, server(sys.argv[1]) as base:
        for name, surface in SURFACES.items():
            check(base, name, surface, folder)


if __name__ == "__main__":
    main()

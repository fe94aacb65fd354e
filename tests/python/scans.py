"""Fits typical files of surfaces with the command, and measures the whole surface.

    scans.py PROGRAM                # such as target/debug/piad

Scans around an axis and a centre, a scan with ragged borders and a hole, elevations with gaps,
sections with any start point, a piece of a mesh in three formats, ridges and spiky heights. *Away*
is the largest distance of points of the exact surface from the fit, by the tangent planes at 400 ×
400 samples; *outside* is the excess of the whole rectangle over the bounding box of the data, relative to its diagonal.
OpenCASCADE checks the face of the STEP file. Needs the packages of requirements.txt.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import trimesh
from OCP.BRepCheck import BRepCheck_Analyzer
from scipy.spatial import KDTree

import cad
import expected

RANDOM = np.random.default_rng(5)
NOISE = 0.02
SIDE = 400


@dataclass
class Kind:
    """A file, the arguments of the command, and the required result."""

    name: str
    text: str | bytes
    words: list[str]
    # Points of the exact surface, and the allowed distance of the fit from them.
    exact: np.ndarray
    away: float
    outside: float
    control_points: int
    suffix: str = ".xyz"
    closed: tuple[bool, bool] = (False, False)


def rows(points: np.ndarray, head: str = "") -> str:
    """Lines of numbers, with blank lines between lists of points."""
    lists = points if isinstance(points, list) else [points]
    separate = "," if head else " "
    blocks = ["\n".join(separate.join(f"{x:.6f}" for x in point) for point in part) for part in lists]
    return (head + "\n" if head else "") + "\n\n".join(blocks) + "\n"


def noisy(points: np.ndarray) -> np.ndarray:
    return points + RANDOM.normal(0, NOISE, points.shape)


def auto(tolerance: float, *more: str) -> list[str]:
    return ["--control-points", "auto", "--tolerance", str(tolerance), *more]


# ---------------------------------------------------------------- scans


def tube(count: int) -> np.ndarray:
    angle, height = RANDOM.uniform(0, 2 * np.pi, count), RANDOM.uniform(0, 80, count)
    radius = 15 + 1.5 * np.sin(3 * angle) + 0.05 * height
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def pipe(count: int, opening: float) -> np.ndarray:
    angle, height = np.radians(RANDOM.uniform(0, opening, count)), RANDOM.uniform(0, 60, count)
    return np.stack([20 * np.cos(angle), 20 * np.sin(angle), height], axis=1)


def sphere(count: int, radius: float) -> np.ndarray:
    directions = RANDOM.normal(size=(count, 3))
    return radius * directions / np.linalg.norm(directions, axis=1)[:, None]


def turned(points: np.ndarray, axis: tuple[float, float, float], degrees: float) -> np.ndarray:
    return trimesh.transform_points(points, trimesh.transformations.rotation_matrix(np.radians(degrees), axis, [9, 4, 7]))


def ragged(count: int, height: float) -> np.ndarray:
    """A sheet with a round hole and a border that is cut off."""
    u, v = RANDOM.uniform(-1, 1, (2, count))
    kept = (np.hypot(u + 0.1, v - 0.2) > 0.25) & (u + v < 1.1) & (np.hypot(u, v) < 1.05)
    u, v = u[kept], v[kept]
    return np.stack([50 * u, 50 * v, height * np.sin(1.5 * u) * np.cos(v)], axis=1)


def steep(count: int) -> np.ndarray:
    """Heights that fold on the plane nearest to them (Franke's function)."""
    x, y = RANDOM.uniform(0, 1, (2, count))
    a, b = 9 * x, 9 * y
    z = 0.75 * np.exp(-((a - 2) ** 2 + (b - 2) ** 2) / 4) + 0.75 * np.exp(-((a + 1) ** 2) / 49 - (b + 1) / 10)
    z += 0.5 * np.exp(-((a - 7) ** 2 + (b - 3) ** 2) / 4) - 0.2 * np.exp(-((a - 4) ** 2) - (b - 7) ** 2)
    return np.stack([x, y, 1.2 * z], axis=1)


def scans() -> list[Kind]:
    def scan(name: str, make: Callable[[int], np.ndarray], limits: tuple, closed=(False, False)) -> Kind:
        return Kind(name, rows(noisy(make(3000))), auto(5 * NOISE), make(400), *limits, closed=closed)

    axis = (1.0, 2.0, 0.5)
    return [
        scan("tube", tube, (4 * NOISE, 0.03, 200), (True, False)),
        scan("tube, turned", lambda n: turned(tube(n), axis, 70), (4 * NOISE, 0.03, 200), (True, False)),
        scan("pipe of 220°", lambda n: pipe(n, 220), (4 * NOISE, 0.03, 60)),
        scan("pipe of 300°, turned", lambda n: turned(pipe(n, 300), axis, 40), (4 * NOISE, 0.03, 60)),
        scan("sphere", lambda n: sphere(n, 25), (4 * NOISE, 0.03, 120), (True, False)),
        scan("ragged", lambda n: ragged(n, 12), (4 * NOISE, 0.03, 60)),
        # The plane nearest to them is not that of x and y, and corners of its rectangle are above
        # the highest point.
        scan("ragged, higher", lambda n: ragged(n, 25), (4 * NOISE, 0.07, 80)),
        Kind("steep heights", rows(steep(4000)), auto(0.005), steep(400), 0.01, 0.03, 400),
    ]


# ---------------------------------------------------------------- grids


def peaks(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    z = 3 * (1 - x) ** 2 * np.exp(-(x**2) - (y + 1) ** 2) - np.exp(-((x + 1) ** 2) - y**2) / 3
    return 300 + 40 * (z - 10 * (x / 5 - x**3 - y**5) * np.exp(-(x**2) - y**2))


def terrain() -> list[Kind]:
    """Elevations with gaps as an ESRI grid, and as a table."""
    x, y = np.meshgrid(np.linspace(-3, 3, 60), np.linspace(-3, 3, 45))
    z = peaks(x, y)
    gap = (np.hypot(x - 1.2, y + 0.8) < 0.9) | (x + y > 4.2) | (np.hypot(x + 2, y - 1) < 0.5)
    cells = [" ".join("-9999" if g else f"{v:.2f}" for v, g in zip(*line)) for line in zip(z[::-1], gap[::-1])]
    head = "ncols 60\nnrows 45\nxllcorner 4000\nyllcorner 7000\ncellsize 10\nNODATA_value -9999"
    table = [f"{a:.4f},{b:.4f},{'nan' if g else f'{v:.3f}'}" for a, b, v, g in zip(*(m.ravel() for m in (x, y, z, gap)))]
    kept = ~gap.ravel()
    easting, northing = np.meshgrid(4005 + 10 * np.arange(60), 7005 + 10 * np.arange(45))
    grid = np.stack([easting, northing, z], axis=2)
    places = np.stack([x, y, z], axis=2)
    return [
        Kind("elevations", "\n".join([head, *cells]) + "\n", auto(1), grid.reshape(-1, 3)[kept], 1.01, 0.03, 800, ".asc"),
        Kind("elevations as a table", "\n".join(["x,y,z", *table]), auto(1), places.reshape(-1, 3)[kept], 1.01, 0.03, 800, ".csv"),
    ]


# ---------------------------------------------------------------- sections


def sections(turn: float, mixed: bool) -> Kind:
    """Closed sections with different numbers of points, start points and directions."""

    def section(k: float, angle: np.ndarray) -> np.ndarray:
        a, b = 6 + 1.5 * np.sin(k), 4 + 0.8 * k
        return np.stack([a * np.cos(angle) + 0.4 * k, b * np.sin(angle), np.full(len(angle), 5.0 * k)], axis=1)

    def angles(k: int, count: int) -> np.ndarray:
        angle = np.linspace(0, 2 * np.pi, count, endpoint=False) + turn * k
        return angle[::-1] if mixed and k % 2 else angle

    counts = [24, 40, 31, 57, 36]
    parts = [section(k, angles(k, count)) for k, count in enumerate(counts)]
    exact = np.concatenate([section(k, np.linspace(0, 6, 40)) for k in range(5)])
    name = "sections, turned" if turn else "sections"
    return Kind(name, rows(parts, "x,y,z"), auto(0.01), exact, 0.03, 0.03, 400, ".csv", (False, True))


# ---------------------------------------------------------------- meshes


def cap(radius: float) -> trimesh.Trimesh:
    """The part of a sheet within a radius."""
    side = np.linspace(-1, 1, 25)
    u, v = (it.ravel() for it in np.meshgrid(side, side, indexing="ij"))
    points = np.stack([30 * u, 30 * v, 10 * (1 - u**2) * (1 - 0.5 * v**2)], axis=1)
    i = (np.arange(24)[:, None] * 25 + np.arange(24)).ravel()
    faces = np.concatenate([np.stack([i, i + 25, i + 26], axis=1), np.stack([i, i + 26, i + 1], axis=1)])
    mesh = trimesh.Trimesh(points, faces[np.hypot(*points[faces, :2].mean(axis=1).T) < radius], process=False)
    mesh.remove_unreferenced_vertices()
    return mesh


def caps() -> list[Kind]:
    kinds = []
    for suffix, radius in [("obj", 29), ("ply", 29), ("stl", 29), ("ply", 22)]:
        mesh = cap(radius)
        text = mesh.export(file_type=suffix)
        kinds.append(Kind(f"cap, {suffix}", text, auto(1e-3), mesh.vertices, 1e-3, 0.03, 144, "." + suffix))
    return kinds


# ---------------------------------------------------------------- measures


class Fit:
    """A result, sampled on its rectangle."""

    def __init__(self, path: str):
        self.surface = expected.load(path)
        with open(path, encoding="utf-8") as file:
            self.result = json.load(file)
        u, v = (self.surface.parameters(axis, SIDE) for axis in (0, 1))
        self.samples = self.surface.evaluate(u, v)

    def away(self, points: np.ndarray) -> float:
        """The largest distance of points from the tangent planes at the samples nearest to them."""
        normals = np.cross(np.gradient(self.samples, axis=0), np.gradient(self.samples, axis=1)).reshape(-1, 3)
        some = points[:: max(1, len(points) // 400)]
        gap, nearest = KDTree(self.samples.reshape(-1, 3)).query(some)
        normal = normals[nearest]
        lengths = np.linalg.norm(normal, axis=1)
        along = np.abs(((some - self.samples.reshape(-1, 3)[nearest]) * normal).sum(axis=1)) / np.maximum(lengths, 1e-300)
        # At a pole there is no normal, and beyond a border the distance is that from the border.
        beyond = (lengths < 1e-12) | (gap > 3 * np.sqrt(lengths) + along)
        return float(np.where(beyond, gap, along).max())

    def outside(self, points: np.ndarray) -> float:
        """The excess of the surface over the bounding box of points, relative to its diagonal."""
        low, high = points.min(axis=0), points.max(axis=0)
        samples = self.samples.reshape(-1, 3)
        beyond = np.maximum(low - samples.min(axis=0), samples.max(axis=0) - high)
        return float(max(beyond.max(), 0) / np.linalg.norm(high - low))


def check(program: str, folder: str, kind: Kind) -> list[str]:
    """The errors of the fit of a file."""
    source, stem = os.path.join(folder, "points" + kind.suffix), os.path.join(folder, "result")
    with open(source, "wb") as file:
        file.write(kind.text if isinstance(kind.text, bytes) else kind.text.encode())
    for format in ("json", "step"):
        words = [program, "fit", source, *kind.words, "--surface", "-o", f"{stem}.{format}", "--quiet"]
        done = subprocess.run(words, capture_output=True, text=True)
        if done.returncode:
            return [f"ends with {done.returncode}: {done.stderr.strip()[-300:]}"]
    fit = Fit(f"{stem}.json")
    count, away, outside = fit.surface.poles[..., 0].size, fit.away(kind.exact), fit.outside(kind.exact)
    print(f"{kind.name:22} {count:4} control points, away by {away:.2g}, outside by {outside:.2g}", flush=True)
    wrong = []
    if away > kind.away:
        wrong.append(f"away by {away:.3g}, at most {kind.away:g}")
    if outside > kind.outside:
        wrong.append(f"outside by {outside:.3g}, at most {kind.outside:g}")
    if count > kind.control_points:
        wrong.append(f"{count} control points, at most {kind.control_points}")
    if tuple(fit.surface.closed) != kind.closed:
        wrong.append(f"closed {fit.surface.closed}, not {kind.closed}")
    if not BRepCheck_Analyzer(cad.CadFile(f"{stem}.step").shape).IsValid():
        wrong.append("the STEP file is not valid")
    return wrong


def main() -> None:
    program = sys.argv[1]
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        for kind in [*scans(), *terrain(), sections(0, False), sections(0.7, True), *caps()]:
            wrong += [f"{kind.name}: {what}" for what in check(program, folder, kind)]
    sys.exit("\n".join(wrong) or None)


if __name__ == "__main__":
    main()

"""The scans and grids of compare.py: computed, except for the elevations of matplotlib and, on
request, a scan of G+Smo."""

import re
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tolerance"))
import shapes

# The number of test points between the data.
PLACES = 20_000


@dataclass
class Scan:
    """Scattered points, mostly heights over x and y, and exact points at other positions."""

    name: str
    points: np.ndarray
    between: np.ndarray
    tolerances: tuple[float, ...]


def franke() -> Scan:
    points = shapes.franke(10_000)
    points[:, 2] += 0.01 * np.random.default_rng(11).standard_normal(len(points))
    return Scan("Franke's function, noise .01, 10,000 points", points, shapes.franke(PLACES)[10_000:], (0.05, 0.04))


CENTRES = np.array([[140, 210], [260, 700], [430, 340], [560, 870], [650, 520], [780, 150], [860, 760], [350, 520]])


def hill_heights(places: np.ndarray) -> np.ndarray:
    squared = ((places[:, None] - CENTRES) ** 2).sum(axis=2)
    return (40 * np.exp(-squared / (2 * 12.0**2))).sum(axis=1)


def hills() -> Scan:
    """A plane with eight hills of height 40, each covering a thousandth of it."""
    places = np.random.default_rng(12).uniform(0, 1000, (30_000 + PLACES, 2))
    points = np.c_[places, hill_heights(places)]
    return Scan("eight hills, 30,000 points", points[:30_000], points[30_000:], (1.0,))


def is_inside(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """True inside a ragged border and outside a hole."""
    border = 1.02 + 0.06 * np.sin(9 * np.arctan2(v, u))
    return (np.hypot(u - 0.2, v + 0.1) > 0.28) & (u - 0.8 * v < 1.05) & (np.hypot(u, v) < border)


def ragged() -> Scan:
    random = np.random.default_rng(13)

    def inside(count: int) -> np.ndarray:
        u, v = random.uniform(-1, 1, (2, count))
        points = np.c_[50 * u, 50 * v, 10 * np.cos(1.7 * u) * np.sin(1.3 * v + 0.3)]
        return points[is_inside(u, v)]

    points, between = inside(5000), inside(PLACES)
    points[:, 2] += 0.02 * random.standard_normal(len(points))
    return Scan(f"ragged border and a hole, noise .02, {len(points):,} points", points, between, (0.1, 0.08))


def terrain() -> Scan:
    return Scan("100,000 elevations of a terrain, m", shapes.terrain(), shapes.terrain(rest=True), (200.0,))


SCANS = [franke, ragged, hills, terrain]


def grids() -> list[tuple[str, np.ndarray, tuple[float, ...]]]:
    """Name, rows of points, tolerances."""
    x, y = np.meshgrid(np.linspace(0, 1, 40), np.linspace(0, 1, 40), indexing="ij")
    function = np.stack([x, y, shapes.franke_heights(x, y)], axis=-1)
    return [
        ("Franke's function, 40 × 40", function, (1e-2, 1e-3)),
        ("elevations, 60 × 45, m", shapes.elevations(60, 45), (100.0, 60.0)),
    ]


def tube(random: np.random.Generator, count: int) -> np.ndarray:
    """A tube with three lobes that gets wider."""
    angle, height = random.uniform(0, 2 * np.pi, count), random.uniform(0, 70, count)
    radius = 14 + 1.2 * np.sin(3 * angle) + 0.06 * height
    return np.c_[radius * np.cos(angle), radius * np.sin(angle), height]


def sphere(random: np.random.Generator, count: int) -> np.ndarray:
    away = random.standard_normal((count, 3))
    return 25 * away / np.linalg.norm(away, axis=1)[:, None]


def around() -> list[Scan]:
    """Scans around an axis or a centre, with noise in each coordinate."""
    random = np.random.default_rng(14)
    scans = []
    for name, make in (("tube with three lobes", tube), ("sphere", sphere)):
        points = make(random, 3000) + 0.02 * random.standard_normal((3000, 3))
        scans.append(Scan(f"{name}, noise .02, 3,000 points", points, make(random, 1000), (0.1, 0.08)))
    return scans


def deep_drawing(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """The points of G+Smo's scan of a deep-drawn part, and their parameters."""
    text = (folder / "filedata" / "fitting" / "deepdrawingC.xml").read_text()
    found = {}
    for rows, index, numbers in re.findall(r'<Matrix rows="(\d+)" cols="\d+" id="(\d)">([^<]*)', text):
        found[index] = np.array(numbers.split(), float).reshape(int(rows), -1).T
    return found["1"], found["0"]

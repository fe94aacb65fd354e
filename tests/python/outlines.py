"""Fits typical files of curves with the command, and measures the distance of the whole curve from
the original.

    outlines.py PROGRAM             # such as target/debug/piad

Each kind occurs twice, with different sizes. *Leaves* is the largest distance of 20,000 samples of
the curve from the polygon of the points, or from the original curve. Needs the packages of
requirements.txt.
"""

import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

import expected

# The numbers of samples of a fit and of an original curve.
SAMPLES, DENSE = 20_000, 200_001


@dataclass
class Kind:
    """A file, the arguments of the command, and the required result."""

    name: str
    points: np.ndarray
    words: list[str]
    leaves: float
    control_points: int
    # Dense samples of the original curve; the polygon of the points if there is none.
    drawn: np.ndarray | None = None
    head: str = ""
    suffix: str = ".csv"
    separate: str = ","

    def text(self) -> str:
        rows = [self.separate.join(f"{number:.9f}" for number in point) for point in self.points]
        return "\n".join([*filter(None, [self.head]), *rows]) + "\n"


def arc(center: tuple[float, float], radius: float, start: float, end: float, steps: int) -> np.ndarray:
    angles = np.radians(np.linspace(start, end, steps + 1))
    return np.stack([center[0] + radius * np.cos(angles), center[1] + radius * np.sin(angles)], axis=1)


def plate(width: float, height: float, radius: float, steps: int) -> np.ndarray:
    """A plate with round corners; its long edges have two points each."""
    right, top = width - radius, height - radius
    corners = [(right, radius), (right, top), (radius, top), (radius, radius)]
    arcs = [arc(center, radius, 90 * k - 90, 90 * k, steps) for k, center in enumerate(corners)]
    return np.concatenate([*arcs, arcs[0][:1]])


def bracket(side: float, thickness: float, radius: float) -> np.ndarray:
    """An angle with sharp corners and a fillet, closed."""
    inner = thickness + radius
    fillet = arc((inner, inner), radius, 270, 180, 9)
    before = [[0, 0], [side, 0], [side, thickness]]
    return np.concatenate([before, fillet, [[thickness, side * 0.75], [0, side * 0.75], [0, 0]]])


def zigzag(pieces: int, points: int) -> np.ndarray:
    x = np.linspace(0, pieces, pieces * points + 1)
    return np.stack([x, np.abs(x % 2 - 1)], axis=1)


def blunt(thickness: float, points: int) -> np.ndarray:
    """An airfoil that is closed by its blunt trailing edge."""
    x = (1 + np.cos(np.linspace(0, np.pi, points))) / 2
    y = 5 * thickness * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1015 * x**4)
    lower = np.stack([x, -y], axis=1)[::-1][1:]
    return np.concatenate([np.stack([x, y], axis=1), lower, [[x[0], y[0]]]])


def chirp(count: int, rate: float) -> np.ndarray:
    x = np.linspace(0, 1, count)
    return np.stack([x, 0.2 * np.sin(rate * x * x)], axis=1)


def uneven(near: int) -> np.ndarray:
    """Points far apart, and close together where the curve bends."""
    return step(np.sort(np.concatenate([np.linspace(0, 10, 30), 10 - np.geomspace(1e-3, 0.3, near)])))


def step(x: np.ndarray) -> np.ndarray:
    return np.stack([x, np.tanh(3 * (x - 9.9))], axis=1)


def spiral(count: int) -> np.ndarray:
    angle = np.linspace(0, 5.5, count)
    return (2 + 0.3 * angle)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def airfoil(digits: str, thickness: float, points: int) -> Kind:
    name = f"NACA {digits}"
    drawn = refined(blunt(thickness, DENSE // 2))
    words = auto(1e-4, "--corners", "auto")
    return Kind(name, blunt(thickness, points), words, 1.1e-4, 40, drawn, name, ".dat", " ")


def auto(tolerance: float, *more: str) -> list[str]:
    return ["--control-points", "auto", "--tolerance", str(tolerance), *more]


def kinds() -> list[Kind]:
    mixed = np.random.default_rng(7).permutation
    polyline = ["--polyline"]
    corners = ["--corners", "auto"]
    squares = [np.array([[0, 0], [a, 0], [a, b], [0, b], [0, 0]], float) for a, b in [(10, 10), (7, 30)]]
    return [
        Kind("plate", plate(120, 70, 15, 12), auto(0.01), 0.35, 60),
        Kind("plate, thin", plate(300, 40, 12, 10), auto(0.01), 0.4, 60),
        Kind("plate, 0.1", plate(120, 70, 15, 12), auto(0.1), 0.35, 36),
        Kind("plate as polyline", plate(120, 70, 15, 12), [*polyline, "--tolerance", "0.1"], 0.15, 200),
        Kind("bracket", bracket(80, 20, 10), auto(0.05, *corners), 0.1, 24),
        Kind("bracket, fine", bracket(80, 20, 10), auto(0.005, *corners), 0.055, 40),
        Kind("bracket, thick", bracket(200, 45, 30), auto(0.05, *corners), 0.2, 28),
        Kind("v", zigzag(2, 20) - [1, 0], auto(1e-6, *corners), 1e-9, 7),
        Kind("zigzag", zigzag(5, 60), auto(1e-6, *corners), 1e-8, 16),
        Kind("zigzag, longer", zigzag(8, 35), auto(1e-6, *corners), 1e-8, 25),
        *(Kind("rectangle", square, polyline, 1e-9, 13) for square in squares),
        *(airfoil(*words) for words in [("0012", 0.12, 61), ("0021", 0.21, 45)]),
        # The crests have a radius of half the distance between their points.
        Kind("chirp", chirp(1500, 60), auto(1e-5), 6e-5, 400, chirp(DENSE, 60)),
        Kind("chirp, slow", chirp(900, 35), auto(1e-5), 6e-5, 260, chirp(DENSE, 35)),
        Kind("uneven", uneven(8), auto(1e-3), 0.02, 30, step(np.linspace(0, 10, DENSE))),
        Kind("in any order", mixed(spiral(200)), auto(1e-3, "--order", "nearest"), 2e-3, 20, spiral(DENSE)),
        Kind("in any order, few", mixed(spiral(60)), auto(1e-3, "--order", "nearest"), 3e-3, 20, spiral(DENSE)),
    ]


def refined(polygon: np.ndarray) -> np.ndarray:
    """Points of a polygon, 50,000 to its length."""
    lengths = np.linalg.norm(np.diff(polygon, axis=0), axis=1)
    along = np.concatenate([[0], np.cumsum(lengths)])
    places = np.union1d(np.linspace(0, along[-1], 50_000), along)
    return np.stack([np.interp(places, along, coordinate) for coordinate in polygon.T], axis=1)


def distance(samples: np.ndarray, drawn: np.ndarray) -> float:
    """The largest distance of samples from a polygon of short edges."""
    _, nearest = KDTree(drawn).query(samples)
    away = np.full(len(samples), np.inf)
    for step in (-1, 0):
        start = drawn[np.clip(nearest + step, 0, len(drawn) - 2)]
        edge = drawn[np.clip(nearest + step, 0, len(drawn) - 2) + 1] - start
        along = ((samples - start) * edge).sum(axis=1) / np.maximum((edge**2).sum(axis=1), 1e-300)
        foot = start + np.clip(along, 0, 1)[:, None] * edge
        away = np.minimum(away, np.linalg.norm(samples - foot, axis=1))
    return float(away.max())


def check(program: str, folder: str, kind: Kind) -> list[str]:
    """The errors of the fit of a file."""
    source, result = os.path.join(folder, "points" + kind.suffix), os.path.join(folder, "result.json")
    with open(source, "w", encoding="utf-8") as file:
        file.write(kind.text())
    done = subprocess.run([program, "fit", source, *kind.words, "-o", result, "--quiet"], capture_output=True, text=True)
    if done.returncode:
        return [f"ends with {done.returncode}: {done.stderr.strip()[-300:]}"]
    curve = expected.load(result)
    samples = curve.evaluate(curve.parameters(0, SAMPLES))[:, :2]
    leaves = distance(samples, refined(kind.points) if kind.drawn is None else kind.drawn)
    count = len(curve.poles)
    print(f"{kind.name:20} {count:4} control points, leaves by {leaves:.2g}")
    wrong = []
    if leaves > kind.leaves:
        wrong.append(f"leaves by {leaves:.3g}, at most {kind.leaves:g}")
    if count > kind.control_points:
        wrong.append(f"{count} control points, at most {kind.control_points}")
    return wrong


def main() -> None:
    program = sys.argv[1]
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        for kind in kinds():
            wrong += [f"{kind.name}: {what}" for what in check(program, folder, kind)]
    sys.exit("\n".join(wrong) or None)


if __name__ == "__main__":
    main()

"""What compare.py fits: curves by formulas, airfoils, Franke's function, and the elevations of a real terrain."""

import io
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline


def naca2412() -> np.ndarray:
    """401 points, a closed trailing edge, from it over the upper side to the nose and back."""
    angle = np.linspace(0, 2 * np.pi, 401)
    x = (1 + np.cos(angle)) / 2
    half = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    front = x < 0.4
    camber = np.where(front, 0.02 / 0.16 * (0.8 * x - x**2), 0.02 / 0.36 * (0.2 + 0.8 * x - x**2))
    turn = np.arctan(np.where(front, 0.04 / 0.16 * (0.4 - x), 0.04 / 0.36 * (0.4 - x)))
    side = np.where(angle <= np.pi, 1, -1) * half
    return np.c_[x - side * np.sin(turn), camber + side * np.cos(turn)]


def lemniscate() -> np.ndarray:
    """Half a lemniscate of Gerono."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 500)
    return np.c_[np.cos(angle), np.sin(angle) * np.cos(angle)]


def rose() -> np.ndarray:
    """Lin, Cao, Zhang 2018: r = 2 + 4 cos(2θ + π/4) + cos(3θ + π/4)."""
    angle = np.linspace(0, 2 * np.pi, 1501)
    r = 2 + 4 * np.cos(2 * angle + np.pi / 4) + np.cos(3 * angle + np.pi / 4)
    return np.c_[r * np.cos(angle), r * np.sin(angle)]


def helix() -> np.ndarray:
    """Three turns."""
    angle = np.linspace(0, 6 * np.pi, 1000)
    return np.c_[np.cos(angle), np.sin(angle), angle / 2]


def step() -> np.ndarray:
    x = np.linspace(-2, 2, 400)
    return np.c_[x, np.tanh(50 * x)]


def chirp() -> np.ndarray:
    x = np.linspace(0, 1, 1500)
    return np.c_[x, 0.2 * np.sin(60 * x**2)]


def long_chirp() -> np.ndarray:
    x = np.linspace(0, 1, 20_000)
    return np.c_[x, np.sin(800 * x**2)]


# Name, points, tolerances.
CURVES = [
    ("NACA 2412, 401 points", naca2412, (1e-3, 1e-4, 1e-5)),
    ("half a lemniscate, 500", lemniscate, (1e-3, 1e-4, 1e-5)),
    ("r = 2 + 4 cos(2θ + π/4) + cos(3θ + π/4), 1501", rose, (1e-2, 1e-3, 1e-4, 1e-5)),
    ("helix, three turns, 1000", helix, (1e-2, 1e-3, 1e-4, 1e-5)),
    ("(x, tanh 50x), 400", step, (1e-2, 1e-3, 1e-4, 1e-5)),
    ("(x, .2 sin 60x²), 1500", chirp, (1e-3, 1e-5)),
    ("(x, sin 800x²), 20,000", long_chirp, (1e-2, 1e-4)),
]

# The knots between the ends of cubics.
SPLINES = [
    [0.13, 0.31, 0.52, 0.58, 0.83],
    [0.08, 0.13, 0.21, 0.31, 0.4, 0.52, 0.58, 0.71, 0.83, 0.95],
    [0.02, 0.04, 0.07, 0.2, 0.25, 0.3, 0.33, 0.46, 0.47, 0.5, 0.66, 0.7, 0.78, 0.9, 0.91, 0.96],
]


def few_knots(knots: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """400 parameters at equal steps, and points of a plane cubic with these knots there, about as wide as control points."""
    knots = np.r_[[0] * 4, knots, [1] * 4]
    index = np.arange(len(knots) - 4)
    control_points = np.sin(np.outer(index, [3.7, 5.1])) + 0.3 * index[:, None]
    t = np.linspace(0, 1, 400)
    return t, BSpline(knots, control_points, 3)(t)


def spiral(count: int, noise: float) -> np.ndarray:
    """A rippled spiral in space, as in ../scipy, each coordinate with normal noise of this deviation."""
    t = 60.0 * np.arange(count) / count
    r = 1.0 + t / 10.0 + 0.05 * np.sin(20.0 * t)
    exact = np.stack([r * np.cos(t), r * np.sin(t), 0.3 * t], axis=1)
    return exact + noise * np.random.default_rng(1).standard_normal(exact.shape)


def airfoils() -> list[tuple[str, np.ndarray]]:
    """All airfoils of UIUC in the package aerosandbox that are one list of at least 21 points around the section,
    scaled to the chord 1. Its wheel is downloaded and read as a zip file, nothing of it is installed."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", folder, "aerosandbox==4.2.9"]
        subprocess.run(command, check=True)
        [wheel] = Path(folder).glob("*.whl")
        archive = zipfile.ZipFile(io.BytesIO(wheel.read_bytes()))
    found = []
    for name in sorted(archive.namelist()):
        if not name.endswith(".dat"):
            continue
        lines = archive.read(name).decode("latin-1").splitlines()
        rows = [re.findall(r"[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?", line) for line in lines[1:] if line.strip()]
        if len(rows) < 21 or any(len(row) != 2 for row in rows):
            continue
        points = np.array(rows, float)
        # A point that stands twice in a row is one point.
        points = points[np.r_[True, np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9]]
        chord = np.ptp(points[:, 0])
        # Lists that jump from one side to the other are not ordered around the airfoil.
        if len(points) >= 21 and chord > 0 and np.linalg.norm(np.diff(points, axis=0), axis=1).max() < 0.3 * chord:
            found.append((Path(name).stem, points / chord))
    return found


def franke_heights(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return (
        0.75 * np.exp(-((9 * x - 2) ** 2 + (9 * y - 2) ** 2) / 4)
        + 0.75 * np.exp(-((9 * x + 1) ** 2) / 49 - (9 * y + 1) / 10)
        + 0.5 * np.exp(-((9 * x - 7) ** 2 + (9 * y - 3) ** 2) / 4)
        - 0.2 * np.exp(-((9 * x - 4) ** 2) - (9 * y - 7) ** 2)
    )


def franke(count: int = 1500) -> np.ndarray:
    """Scattered points of Franke's function: multiples of the inverses of the plastic number and its square."""
    i = np.arange(1, count + 1)
    x, y = (i * 0.754_877_666_246_693) % 1, (i * 0.569_840_290_998_053) % 1
    return np.c_[x, y, franke_heights(x, y)]


def elevations(rows: int = 200, columns: int = 150) -> np.ndarray:
    """Elevations of the same model, at places between its rows and columns (bilinear): x, y and z in metres."""
    from matplotlib import cbook
    from scipy.interpolate import RegularGridInterpolator

    elevation = cbook.get_sample_data("jacksboro_fault_dem.npz")["elevation"].astype(float)
    lines = [np.arange(count) for count in elevation.shape]
    wanted = [np.linspace(0, line[-1], count) for line, count in zip(lines, (rows, columns))]
    places = np.meshgrid(*wanted, indexing="ij")
    heights = RegularGridInterpolator(lines, elevation)(tuple(places))
    return np.stack([90.0 * places[0], 74.0 * places[1], heights], axis=-1)


def terrain(rest: bool = False) -> np.ndarray:
    """100,000 of the 138,632 elevations of the Jacksboro fault that come with matplotlib, or the rest of them, in whole
    metres from 236 to 1076, as x, y and z in metres: rows are 90 m apart, columns 74 m."""
    from matplotlib import cbook

    elevation = cbook.get_sample_data("jacksboro_fault_dem.npz")["elevation"]
    order = np.random.default_rng(2024).permutation(elevation.size)
    i, j = np.divmod(order[100_000:] if rest else order[:100_000], elevation.shape[1])
    return np.column_stack([90.0 * i, 74.0 * j, elevation[i, j].astype(float)])

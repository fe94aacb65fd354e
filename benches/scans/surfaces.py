"""The surfaces of compare.py: of piad, scipy's smoothing splines, geomdl, and with uniform
knots."""

import json
import subprocess
import time
import warnings
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from geomdl import fitting
from scipy.interpolate import BSpline, NdBSpline, SmoothBivariateSpline
from scipy.sparse import csr_array
from scipy.sparse.linalg import lsqr

from data import shapes  # noqa: F401, it finds fits
import fits


@dataclass
class Surface:
    """A B-spline surface of degree 3, or a height at each position, and the time taken.

    For piad the final state, and the parameters of its data: pairs, or those of rows and
    columns."""

    knots: tuple[np.ndarray, np.ndarray]
    net: np.ndarray
    seconds: float
    ended: str = ""
    parameters: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def count(self) -> int:
        return self.net.shape[0] * self.net.shape[1]

    def at(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        return NdBSpline(self.knots, self.net, 3)(np.stack([u, v], axis=-1))

    def on_rectangle(self, count: int) -> np.ndarray:
        """Evaluates on a uniform grid with this number of rows and columns."""
        ends = [np.linspace(knots[3], knots[-4], count) for knots in self.knots]
        return self.at(*np.meshgrid(*ends, indexing="ij"))


# ---------------------------------------------------------------- piad


def piad(program: str, job: dict, limit: float, step: Path | None = None) -> Surface | None:
    """Fits with `piad fit`, from reading the job to the written result; `None` after this many
    seconds."""
    with TemporaryDirectory() as name:
        given, result = Path(name) / "job.json", Path(name) / "result.json"
        given.write_text(json.dumps(job))
        command = [program, "fit", "-q", given, "-o", result]
        begin = time.perf_counter()
        try:
            subprocess.run(command + (["-o", step] if step else []), timeout=limit, stderr=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            return None
        seconds = time.perf_counter() - begin
        found = json.loads(result.read_text())
    knots, parameters = (tuple(np.array(found[of][axis]) for axis in "uv") for of in ("knots", "parameters"))
    return Surface(knots, np.array(found["control_points"]), seconds, found["state"], parameters)


# ---------------------------------------------------------------- scipy


def smoothed(points: np.ndarray, factor: float) -> Surface:
    """Of degree 3, over x and y; the sum of squared distances is at most this factor."""
    begin = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        spline = SmoothBivariateSpline(*points.T, s=factor)
    seconds = time.perf_counter() - begin
    knots = spline.get_knots()
    net = spline.get_coeffs().reshape([len(line) - 4 for line in knots])
    return Surface(knots, net, seconds)


@dataclass
class Search:
    """The surface with the fewest control points within the tolerance, the number of runs, their
    seconds, and the largest distance of the last run."""

    best: Surface | None
    runs: int
    seconds: float
    last: float
    in_time: bool


def bisected(points: np.ndarray, tolerance: float, limit: float) -> Search:
    """Smoothing factors by bisection, of root mean squares from a thirtieth of the tolerance to the tolerance, until they
    differ by 2 %. All runs together respect the time limit."""
    low, high = tolerance / 30, tolerance
    search, begin = Search(None, 0, 0.0, np.inf, True), time.perf_counter()
    while high > 1.02 * low:
        middle = np.sqrt(low * high)
        left = limit - (time.perf_counter() - begin)
        surface = fits.limited(max(left, 0), smoothed, points, len(points) * middle**2)
        search.seconds = time.perf_counter() - begin
        if surface is None:
            search.in_time = False
            break
        search.runs += 1
        away = surface.at(points[:, 0], points[:, 1]) - points[:, 2]
        search.last = np.abs(away).max()
        if search.last <= tolerance:
            low = middle
            if search.best is None or surface.count <= search.best.count:
                search.best = surface
        elif np.sqrt((away**2).mean()) > 1.01 * middle:
            # Below the noise there may be no spline with this factor.
            low = middle
        else:
            high = middle
    return search


def uniform(parameters: np.ndarray, points: np.ndarray, shape: tuple[int, int]) -> Surface:
    """Least squares of degree 3 with these numbers of control points and knots at equal distances."""
    begin = time.perf_counter()
    knots, bases = [], []
    for place, count in zip(parameters.T, shape):
        ends = place.min(), place.max()
        knots.append(np.r_[[ends[0]] * 3, np.linspace(*ends, count - 2), [ends[1]] * 3])
        bases.append(BSpline.design_matrix(place, knots[-1], 3).toarray())
    rows = csr_array(np.einsum("pi,pj->pij", *bases).reshape(len(points), -1))
    net = [lsqr(rows, column, atol=1e-12, btol=1e-12, iter_lim=5000)[0] for column in points.T]
    return Surface(tuple(knots), np.stack(net, axis=-1).reshape(*shape, -1), time.perf_counter() - begin)


# ---------------------------------------------------------------- geomdl


def geomdl(grid: np.ndarray, shape: tuple[int, int]) -> Surface:
    """`approximate_surface` with these numbers of control points, at its parameters: means of chord lengths."""
    rows, columns = grid.shape[:2]
    points = grid.reshape(-1, 3).tolist()
    begin = time.perf_counter()
    sizes = {"ctrlpts_size_u": shape[0], "ctrlpts_size_v": shape[1]}
    surface = fitting.approximate_surface(points, rows, columns, 3, 3, **sizes)
    seconds = time.perf_counter() - begin
    u, v = fitting.compute_params_surface(points, rows, columns)
    knots = np.array(surface.knotvector_u), np.array(surface.knotvector_v)
    net = np.array(surface.ctrlpts).reshape(*shape, 3)
    return Surface(knots, net, seconds, parameters=(np.array(u), np.array(v)))

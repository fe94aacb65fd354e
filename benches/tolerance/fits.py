"""The fits of compare.py, each with its number of control points, largest distance and seconds.

Distances of piad's and scipy's fits are measured at the parameters of the data; those of
OpenCASCADE's curves, whose parameters are unknown, from the nearest points, which are never larger.
"""

import math
import multiprocessing
import time
import urllib.request
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import orjson
from OCP.GeomAbs import GeomAbs_C2
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Pnt
from OCP.TColgp import TColgp_Array1OfPnt
from scipy.interpolate import BSpline, NdBSpline, RectBivariateSpline, SmoothBivariateSpline, splprep
from scipy.spatial import KDTree


@dataclass
class Fit:
    """Control points in each direction, the largest distance from the data, and the time taken.

    For piad the final state, and the arrival time and control points of the first iteration within
    the tolerance. For scipy the seconds of all runs until one was within the tolerance."""

    shape: tuple[int, ...]
    largest: float
    seconds: float
    ended: str = ""
    first: float | None = None
    first_count: int | None = None
    searched: float | None = None

    @property
    def count(self) -> int:
        return math.prod(self.shape)


def limited(seconds: float, work: Callable, *arguments) -> Fit | None:
    """Calls a function in a separate process with a time limit in seconds."""
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=lambda: sender.send(work(*arguments)))
    process.start()
    sender.close()
    try:
        return receiver.recv() if receiver.poll(seconds) else None
    except EOFError:
        return None
    finally:
        process.kill()
        process.join()



# ---------------------------------------------------------------- piad


def piad(base: str, geometry: dict, tolerance: float) -> Fit:
    """From writing the request to the last event. Asserts with scipy that the largest distance at
    the parameters of the data is the reported one."""
    method = {"kind": "least_squares", "control_points": "auto"}
    job = geometry | {"method": method, "stop": {"tolerance": tolerance}, "stream": {"view": "errors"}}
    headers = {"Content-Type": "application/json", "Accept": "text/event-stream"}
    begin = time.perf_counter()
    body = orjson.dumps(job, option=orjson.OPT_SERIALIZE_NUMPY)
    with urllib.request.urlopen(urllib.request.Request(f"{base}/v1/jobs", body, headers)) as answer:
        lines = [(time.perf_counter() - begin, line[5:]) for line in answer if line.startswith(b"data:")]
    seconds = time.perf_counter() - begin
    opening, *iterations, end = [(at, orjson.loads(line)) for at, line in lines]
    opening, end = opening[1], end[1]
    first, first_count, knots, degree = seconds, None, opening["knots"], opening["degree"]
    for at, event in iterations:
        knots = event.get("knots", knots)
        if event["error"]["max"] <= tolerance:
            first, first_count = at, functions(knots, degree)
            break
    path = base + opening["links"]["self"]
    with urllib.request.urlopen(f"{path}/result") as answer:
        result = orjson.loads(answer.read())
    urllib.request.urlopen(urllib.request.Request(path, method="DELETE")).close()

    [described] = geometry.values()
    points = described["points" if "points" in described else "scattered"]
    parameters, knots, degree = opening["parameters"], result["knots"], result["degree"]
    net = np.array(result["control_points"])
    if net.ndim == 2:
        there = BSpline(np.array(knots), net, degree)(parameters)
    else:
        spline = NdBSpline(tuple(np.array(knots[axis]) for axis in "uv"), net, tuple(degree[axis] for axis in "uv"))
        u, v = (np.array(parameters[axis]) for axis in "uv")
        if "points" in described:  # The parameters of the rows and columns of a grid.
            u, v = np.meshgrid(u, v, indexing="ij")
        there = spline(np.stack([u, v], axis=-1))
    measured, said = np.linalg.norm(there - points, axis=-1).max(), end["error"]["max"]
    assert abs(measured - said) <= 1e-9 * said + 1e-12 * np.abs(points).max(), f"{measured}, and piad says {said}"
    ended = end["reason"] or end["state"]
    assert ended != "converged" or said <= tolerance, f"{said} is above {tolerance}"
    return Fit(net.shape[:-1], measured, seconds, ended, first, first_count)


def functions(knots: list | dict, degree: int | dict) -> int:
    """The number of control points of a curve or surface with these knots."""
    if isinstance(knots, dict):
        return math.prod(functions(knots[axis], degree[axis]) for axis in "uv")
    return len(knots) - degree - 1


# ---------------------------------------------------------------- scipy


def chord_length(points: np.ndarray) -> np.ndarray:
    return np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]


def smoothed(points: np.ndarray, factor: float, parameters: np.ndarray | None = None) -> Fit:
    """Cubic, over chord lengths as piad without parameters; the sum of squared distances is at most this factor."""
    begin = time.perf_counter()
    t = chord_length(points) if parameters is None else parameters
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        (knots, coefficients, degree), _ = splprep(points.T, u=t, s=factor, k=3)
    seconds = time.perf_counter() - begin
    there = BSpline(knots, np.array(coefficients).T, degree)(t)
    return Fit((len(knots) - 4,), np.linalg.norm(there - points, axis=1).max(), seconds)


def factors(count: int, tolerance: float) -> np.ndarray:
    """Twenty smoothing factors, for root mean squares between the tolerance and a thirtieth of it."""
    return count * (tolerance * np.geomspace(1, 1 / 30, 20)) ** 2


def fewest(fits: list[Fit], tolerance: float) -> Fit | None:
    within = [fit for fit in fits if fit.largest <= tolerance]
    return min(within, key=lambda fit: fit.count, default=None)


def scipy_curve(points: np.ndarray, tolerance: float, parameters: np.ndarray | None = None) -> Fit | None:
    """The fit with the fewest control points within the tolerance, with the seconds of its run."""
    return fewest([smoothed(points, factor, parameters) for factor in factors(len(points), tolerance)], tolerance)


def first_of_scipy(points: np.ndarray, tolerance: float) -> Fit | None:
    """The first fit within the tolerance, for data for which all twenty would take too long."""
    searched = 0.0
    for factor in factors(len(points), tolerance):
        fit = smoothed(points, factor)
        searched += fit.seconds
        if fit.largest <= tolerance:
            return replace(fit, searched=searched)
    return None


def smoothed_surface(points: np.ndarray, factor: float) -> Fit:
    """Bicubic, over x and y."""
    x, y, z = points.T
    begin = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        surface = SmoothBivariateSpline(x, y, z, s=factor)
    seconds = time.perf_counter() - begin
    shape = tuple(len(knots) - 4 for knots in surface.get_knots())
    return Fit(shape, np.abs(surface.ev(x, y) - z).max(), seconds)


def scipy_surface(points: np.ndarray, tolerance: float) -> Fit | None:
    """As `scipy_curve`."""
    return fewest([smoothed_surface(points, factor) for factor in factors(len(points), tolerance)], tolerance)


def bisected_grid(points: np.ndarray, tolerance: float) -> tuple[Fit, int, float]:
    """Bicubic, over rows and columns: the largest smoothing factor that bisection finds within the tolerance, the number
    of runs that this took, and their seconds in all."""
    x, y, z = points[:, 0, 0], points[0, :, 1], points[..., 2]
    low, high = 0.0, z.size * tolerance**2
    best, seconds, runs = None, 0.0, 0
    while best is None or high > 1.02 * low:
        factor = (low + high) / 2 if low == 0 else np.sqrt(low * high)
        begin = time.perf_counter()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            surface = RectBivariateSpline(x, y, z, s=factor)
        took = time.perf_counter() - begin
        seconds, runs = seconds + took, runs + 1
        largest = np.abs(surface(x, y) - z).max()
        if largest <= tolerance:
            low, best = factor, Fit(tuple(len(knots) - 4 for knots in surface.get_knots()), largest, took)
        else:
            high = factor
    return best, runs, seconds


# ---------------------------------------------------------------- OpenCASCADE


def opencascade_curve(points: np.ndarray, tolerance: float, degree: int) -> Fit:
    """Of degree 3 up to the one given, twice differentiable."""
    space = np.c_[points, np.zeros((len(points), 3 - points.shape[1]))]
    begin = time.perf_counter()
    array = TColgp_Array1OfPnt(1, len(points))
    for i, point in enumerate(space.tolist(), 1):
        array.SetValue(i, gp_Pnt(*point))
    # A call that hangs or throws ends with its process.
    curve = GeomAPI_PointsToBSpline(array, 3, degree, GeomAbs_C2, tolerance).Curve()
    seconds = time.perf_counter() - begin
    knots = np.repeat(list(curve.Knots()), [curve.Multiplicity(i) for i in range(1, curve.NbKnots() + 1)])
    poles = np.array([curve.Pole(i).Coord() for i in range(1, curve.NbPoles() + 1)])
    spline = BSpline(knots, poles, curve.Degree())
    return Fit((len(poles),), distances(space, spline).max(), seconds)


def distances(points: np.ndarray, spline: BSpline) -> np.ndarray:
    """Distances of points from a curve: by Newton's method from the nearest of many samples."""
    low, high = spline.t[spline.k], spline.t[-spline.k - 1]
    places = np.linspace(low, high, 20 * len(points))
    nearest, at = KDTree(spline(places)).query(points)
    t, first, second = places[at], spline.derivative(), spline.derivative(2)
    for _ in range(4):
        away, along = spline(t) - points, first(t)
        slope = (along**2).sum(axis=1) + (away * second(t)).sum(axis=1)
        step = np.divide((away * along).sum(axis=1), slope, out=np.zeros_like(t), where=slope > 0)
        t = np.clip(t - step, low, high)
        nearest = np.fmin(nearest, np.linalg.norm(spline(t) - points, axis=1))
    return nearest

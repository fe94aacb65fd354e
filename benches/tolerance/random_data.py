"""Fits of random data with as few control points as a tolerance needs, judged between the points.

    random_data.py PROGRAM [--fits 2000] [--seed 7]     # PROGRAM is target/release/piad

- polylines: open lines of 5 to 59 points, whose edges have lengths from 1 to 30, as outlines have them. *Leaves* is the
  largest distance of 4,000 samples of the curve from the line, by its longest edge. scipy is given the best of twenty
  smoothing factors, and interpolates where none of them is within the tolerance;
- monotone: smooth curves, noise, corners and steps of 20 to 400 points, each within ten tolerances: how often a larger
  tolerance has more control points than a smaller one.

Ends with code 1 where piad does not converge, leaves a line by more than its longest edge, or needs more control points
for a larger tolerance. Needs requirements.txt.
"""

import argparse
import json
import sys
import urllib.request
import warnings
from http.client import HTTPResponse
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline, splprep
from scipy.spatial import KDTree

import fits

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "python"))
from over_http import server

SAMPLES = 4000
TOLERANCES = 10


def polyline(random: np.random.Generator) -> np.ndarray:
    """A line that turns by up to a right angle, with a few long edges among short ones."""
    count = random.integers(5, 60)
    lengths = random.exponential(1, count - 1) + 0.2
    lengths[random.random(count - 1) < 0.15] *= 30
    directions = np.cumsum(random.normal(0, 0.5, count - 1))
    steps = lengths[:, None] * np.stack([np.cos(directions), np.sin(directions)], axis=1)
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def any_data(random: np.random.Generator) -> np.ndarray:
    """A smooth curve, with noise, corners or a step."""
    count = random.integers(20, 401)
    x = np.linspace(0, 1, count)
    waves = [random.normal() * np.sin(2 * np.pi * k * x + random.uniform(0, 6)) / k for k in range(1, 7)]
    y = np.sum(waves, axis=0)
    match random.integers(4):
        case 1:
            y += random.normal(0, 10 ** random.uniform(-4, -2), count)
        case 2:
            y += 3 * np.abs(x - random.uniform(0.2, 0.8))
        case 3:
            y += np.tanh(random.uniform(30, 200) * (x - random.uniform(0.2, 0.8)))
    return np.stack([4 * x, y], axis=1)


def fit(base: str, points: np.ndarray, tolerance: float) -> dict:
    """The result of a job, also of one that has not converged."""
    job = {
        "curve": {"points": points.tolist()},
        "method": {"kind": "least_squares", "control_points": "auto"},
        "stop": {"tolerance": tolerance},
    }
    with answer(f"{base}/v1/jobs", job) as created:
        url = base + created.headers["Location"]
    with answer(f"{url}/events?view=errors") as events:
        events.read()
    with answer(f"{url}/result") as result:
        return json.load(result)


def answer(url: str, body: dict | None = None) -> HTTPResponse:
    data = body and json.dumps(body).encode()
    return urllib.request.urlopen(urllib.request.Request(url, data, {"Content-Type": "application/json"}))


def leaves(points: np.ndarray, spline: BSpline) -> float:
    """The largest distance of samples of a curve from the line through points, by its longest edge."""
    edges = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0], np.cumsum(edges)])
    places = np.union1d(np.linspace(0, along[-1], 20 * SAMPLES), along)
    line = np.stack([np.interp(places, along, coordinate) for coordinate in points.T], axis=1)
    samples = spline(np.linspace(spline.t[spline.k], spline.t[-spline.k - 1], SAMPLES))
    return KDTree(line).query(samples)[0].max() / edges.max()


def of_scipy(points: np.ndarray, tolerance: float) -> BSpline:
    """The smoothing spline within the tolerance with the fewest control points, else that through all points."""
    t = fits.chord_length(points)

    def spline(factor: float) -> BSpline:
        with warnings.catch_warnings(action="ignore"):
            (knots, coefficients, degree), _ = splprep(points.T, u=t, s=factor, k=3)
        return BSpline(knots, np.array(coefficients).T, degree)

    splines = [spline(factor) for factor in fits.factors(len(points), tolerance)]
    within = [it for it in splines if np.linalg.norm(it(t) - points, axis=1).max() <= tolerance]
    return min(within, key=lambda it: len(it.c), default=None) or spline(0)


def polylines(base: str, random: np.random.Generator, count: int) -> list[str]:
    """Prints a row for each of two tolerances; returns the errors."""
    wrong = []
    print("| tolerance | | control points | leaves by more than the longest edge | by more than a tenth of it | largest |")
    print("|---|---|---|---|---|---|")
    lines = [polyline(random) for _ in range(count)]
    for part in (1e-2, 1e-3):
        ours, theirs, points = [], [], [0, 0]
        for k, line in enumerate(lines):
            tolerance = part * np.linalg.norm(np.ptp(line, axis=0))
            result = fit(base, line, tolerance)
            spline = BSpline(np.array(result["knots"]), np.array(result["control_points"]), result["degree"])
            other = of_scipy(line, tolerance)
            ours.append(leaves(line, spline))
            theirs.append(leaves(line, other))
            points = [points[0] + len(spline.c), points[1] + len(other.c)]
            if result["state"] != "converged":
                wrong.append(f"line {k} within {part:g}: {result['state']}, {result.get('reason')}")
            if ours[-1] > 1:
                wrong.append(f"line {k} within {part:g}: leaves by {ours[-1]:.3g} of the longest edge")
        for name, all_of, total in (("piad", ours, points[0]), ("scipy", theirs, points[1])):
            far = np.array(all_of)
            print(f"| {part:g} of the size | {name} | {total:,} | {(far > 1).sum()} | {(far > 0.1).sum()} | {far.max():.3g} |", flush=True)
    return wrong


def monotone(base: str, random: np.random.Generator, count: int) -> list[str]:
    """Fits data within ten tolerances each; returns where a larger one has more control points."""
    wrong = []
    for k in range(count):
        points = any_data(random)
        size = np.linalg.norm(np.ptp(points, axis=0))
        before = None
        for tolerance in size * np.geomspace(3e-5, 3e-2, TOLERANCES):
            result = fit(base, points, tolerance)
            now = len(result["control_points"])
            if before is not None and now > before:
                wrong.append(f"data {k}, {len(points)} points: {now} control points within {tolerance:.3g}, {before} within less")
            before = now
    print(f"\n{count} data, {TOLERANCES} tolerances: {len(wrong)} times more control points for a larger one")
    return wrong


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--fits", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=7)
    arguments = parser.parse_args()
    with server(arguments.program) as base:
        wrong = polylines(base, np.random.default_rng(arguments.seed), arguments.fits)
        wrong += monotone(base, np.random.default_rng(arguments.seed + 1), arguments.fits // 4)
    sys.exit("\n".join(wrong[:40]) or None)


if __name__ == "__main__":
    main()

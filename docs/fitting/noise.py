"""The tables of docs/how-to/noisy-data.md: how far fits are from the curve that the points were taken of.

    docs/fitting/noise.py PROGRAM    # the server to start, such as target/release/piad

Three curves, normal errors in each coordinate, ten times each. Needs numpy and scipy.
"""

import json
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline, make_smoothing_spline

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "python"))
from over_http import fetch, server

COUNT, SIGMA, REPEATS = 150, 1.5, 10
FAIRNESS = [1e-9, 1e-8, 1e-7, 1e-6, 1e-4, "auto"]


def curves(t: np.ndarray) -> list[np.ndarray]:
    """An arc, two waves and a loop, about 100 wide."""
    turn = 2 * np.pi * t
    return [
        np.stack([50 * np.cos(turn / 2), 50 * np.sin(turn / 2)], axis=1),
        np.stack([100 * t, 20 * np.sin(2 * turn)], axis=1),
        np.stack([50 * np.cos(turn), 30 * np.sin(2 * turn)], axis=1),
    ]


def rms(address: str, truth: np.ndarray, points: np.ndarray, method: dict, tolerance: float | None) -> float:
    """The root mean square distance of a fit from the truth, at the parameters of the data."""
    job = {"curve": {"points": points.tolist(), "parameters": np.linspace(0, 1, len(points)).tolist()}, "method": {"kind": "least_squares", **method}}
    if tolerance is not None:
        job["stop"] = {"tolerance": tolerance}
    fit = json.loads(fetch(f"{address}/v1/fit", json.dumps(job).encode()))
    spline = BSpline(np.array(fit["knots"]), np.array(fit["control_points"]), fit["degree"])
    return float(np.sqrt(((spline(np.array(fit["parameters"])) - truth) ** 2).sum(axis=1).mean()))


def noise(address: str, random: np.random.Generator) -> None:
    """150 points with errors of 1.5 % of the size of the curve."""
    rows: dict[str, list[float]] = {}
    for truth in curves(np.linspace(0, 1, COUNT)):
        for _ in range(REPEATS):
            points = truth + random.normal(0, SIGMA, truth.shape)
            rows.setdefault("the data", []).append(float(np.sqrt(((points - truth) ** 2).sum(axis=1).mean())))
            for value in FAIRNESS:
                method = {"control_points": 60, "variant": "direct", "fairness": value}
                rows.setdefault(f"fairness {value}", []).append(rms(address, truth, points, method, None))
            for count in (8, 14, 25):
                rows.setdefault(f"{count} control points", []).append(rms(address, truth, points, {"control_points": count, "variant": "direct"}, None))
            for times in (2, 3, 4):
                rows.setdefault(f"auto within {times} σ", []).append(rms(address, truth, points, {"control_points": "auto"}, times * SIGMA))
    show(rows)


def levels(address: str, random: np.random.Generator) -> None:
    """Noise at four levels, with fairness "auto" and by scipy's smoothing spline, which has a knot at each datum."""
    rows: dict[str, list[float]] = {}
    t = np.linspace(0, 1, COUNT)
    for truth in curves(t):
        for _ in range(REPEATS):
            for sigma in (0.015, 0.15, 1.5, 5.0):
                points = truth + random.normal(0, sigma, truth.shape)
                smooth = np.stack([make_smoothing_spline(t, lane)(t) for lane in points.T], axis=1)
                rows.setdefault(f"σ {sigma}, `make_smoothing_spline`", []).append(float(np.sqrt(((smooth - truth) ** 2).sum(axis=1).mean())))
                method = {"control_points": "auto", "fairness": "auto"}
                rows.setdefault(f"σ {sigma}, `\"auto\"`", []).append(rms(address, truth, points, method, None))
    show(rows)


def outliers(address: str, random: np.random.Generator) -> None:
    """200 points with small errors, some of which are moved by 10 to 30."""
    rows: dict[str, list[float]] = {}
    for truth in curves(np.linspace(0, 1, 200)):
        for part in (0.01, 0.05, 0.15):
            for _ in range(REPEATS):
                points = truth + random.normal(0, 0.05, truth.shape)
                moved = random.permutation(200)[: int(200 * part)]
                angle, size = random.uniform(0, 2 * np.pi, len(moved)), random.uniform(10, 30, len(moved))
                wrong = points.copy()
                wrong[moved] += np.stack([size * np.cos(angle), size * np.sin(angle)], axis=1)
                method = {"control_points": 25, "variant": "direct"}
                rows.setdefault(f"{part:.0%}, none moved", []).append(rms(address, truth, points, method, None))
                rows.setdefault(f"{part:.0%}, moved", []).append(rms(address, truth, wrong, method, None))
                rows.setdefault(f"{part:.0%}, moved, `\"robust\"`", []).append(rms(address, truth, wrong, method | {"robust": True}, None))
    show(rows)


def show(rows: dict[str, list[float]]) -> None:
    for name, all_of in rows.items():
        arc, waves, loop = np.array(all_of).reshape(3, REPEATS).mean(axis=1)
        print(f"| {name} | {arc:.3g} | {waves:.3g} | {loop:.3g} |")


def main(program: str) -> None:
    with server(program) as address:
        for table in (noise, levels, outliers):
            table(address, np.random.default_rng(1))


main(sys.argv[1])

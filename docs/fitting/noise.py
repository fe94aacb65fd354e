"""The table of docs/FITTING.md about noise: how far fits of noisy points are from the curve that they were taken of.

    docs/fitting/noise.py PROGRAM    # the server to start, such as target/release/piad

Three curves, 150 points each, normal errors of 1.5 % of their size in each coordinate, ten times each. Needs numpy and
scipy.
"""

import json
import sys
from pathlib import Path

import numpy as np
from scipy.interpolate import BSpline

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "python"))
from over_http import fetch, server

COUNT, SIGMA, REPEATS = 150, 1.5, 10
FAIRNESS = [1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4]


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
    job = {"curve": {"points": points.tolist(), "parameters": np.linspace(0, 1, COUNT).tolist()}, "method": {"kind": "least_squares", **method}}
    if tolerance is not None:
        job["stop"] = {"tolerance": tolerance}
    fit = json.loads(fetch(f"{address}/v1/fit", json.dumps(job).encode()))
    spline = BSpline(np.array(fit["knots"]), np.array(fit["control_points"]), fit["degree"])
    return float(np.sqrt(((spline(np.array(fit["parameters"])) - truth) ** 2).sum(axis=1).mean()))


def main(program: str) -> None:
    t = np.linspace(0, 1, COUNT)
    random = np.random.default_rng(1)
    rows: dict[str, list[float]] = {}
    with server(program) as address:
        for truth in curves(t):
            for _ in range(REPEATS):
                points = truth + random.normal(0, SIGMA, truth.shape)
                rows.setdefault("the data", []).append(float(np.sqrt(((points - truth) ** 2).sum(axis=1).mean())))
                for value in FAIRNESS:
                    method = {"control_points": 60, "variant": "direct", "fairness": value}
                    rows.setdefault(f"fairness {value:g}", []).append(rms(address, truth, points, method, None))
                for count in (8, 14, 25):
                    rows.setdefault(f"{count} control points", []).append(rms(address, truth, points, {"control_points": count, "variant": "direct"}, None))
                for times in (2, 3, 4):
                    rows.setdefault(f"auto within {times} σ", []).append(rms(address, truth, points, {"control_points": "auto"}, times * SIGMA))
    for name, all_of in rows.items():
        arc, waves, loop = np.array(all_of).reshape(3, REPEATS).mean(axis=1)
        print(f"| {name} | {arc:.2f} | {waves:.2f} | {loop:.2f} |")


main(sys.argv[1])

"""Writes scattered.json: scattered points of Franke's function, and the least-squares surface near them by scipy.

    target/venv/bin/python tests/golden/scattered.py

1500 points, `numpy.random.default_rng(7).random((1500, 2))`, and bicubic splines of 14 × 14 coefficients on equal
spans of the unit square, by scipy.interpolate.LSQBivariateSpline. The same with a hole: without the points nearer than
0.12 to (0.7, 0.4), where the surface is still determined."""
import json
from pathlib import Path

import numpy as np
from scipy.interpolate import LSQBivariateSpline

COUNT, CONTROL_POINTS, DEGREE = 1500, 14, 3


def franke(x, y):
    return (0.75 * np.exp(-((9 * x - 2) ** 2 + (9 * y - 2) ** 2) / 4)
            + 0.75 * np.exp(-(9 * x + 1) ** 2 / 49 - (9 * y + 1) / 10)
            + 0.5 * np.exp(-((9 * x - 7) ** 2 + (9 * y - 3) ** 2) / 4)
            - 0.2 * np.exp(-(9 * x - 4) ** 2 - (9 * y - 7) ** 2))


def fit(x, y):
    interior = np.linspace(0, 1, CONTROL_POINTS - DEGREE + 1)[1:-1]
    surface = LSQBivariateSpline(x, y, franke(x, y), interior, interior, bbox=[0, 1, 0, 1])
    error = np.abs(franke(x, y) - surface.ev(x, y))
    return {"coefficients": surface.get_coeffs().tolist(), "largest": error.max(), "at": int(error.argmax())}


if __name__ == "__main__":
    x, y = np.random.default_rng(7).random((COUNT, 2)).T
    far = np.hypot(x - 0.7, y - 0.4) > 0.12
    golden = {
        "points": np.stack([x, y, franke(x, y)], 1).tolist(),
        "knots": np.r_[[0] * DEGREE, np.linspace(0, 1, CONTROL_POINTS - DEGREE + 1), [1] * DEGREE].tolist(),
        "whole": fit(x, y),
        "far": np.flatnonzero(far).tolist(),
        "hole": fit(x[far], y[far]),
    }
    Path(__file__).with_suffix(".json").write_text(json.dumps(golden, separators=(",", ":")) + "\n")

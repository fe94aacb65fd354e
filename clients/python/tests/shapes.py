"""Data to be fitted."""

import math
from typing import Any

CURVE = [[math.cos(0.7 * i) * (1 + 0.1 * i), math.sin(0.7 * i), 0.3 * i] for i in range(8)]
RING = [[3 * math.cos(0.7 * i), 2 * math.sin(0.7 * i), 0.2 * math.sin(2.1 * i)] for i in range(9)]
SURFACE = [[[i, j + 0.1 * i, math.sin(i) * math.cos(j)] for j in range(5)] for i in range(6)]
TUBE = [[[math.cos(0.9 * i), math.sin(0.9 * i), 0.5 * j] for j in range(5)] for i in range(7)]
WEIGHTS = [1.0, 1.2, 0.9, 1.1, 1.3, 1.0, 0.8, 1.0]
GRID = [[1 + 0.1 * ((i * j) % 3) for j in range(5)] for i in range(6)]

# Arguments of `fit`, by name.
FITS: dict[str, dict[str, Any]] = {
    "curve": {"points": CURVE},
    "plane": {"points": [point[:2] for point in CURVE]},
    "quintic": {"points": CURVE, "degree": 5, "knots": "averaged"},
    "closed": {"points": RING, "closed": True},
    "closed_even": {"points": RING, "closed": True, "degree": 2},
    "homogeneous": {"points": CURVE, "weights": WEIGHTS},
    "fixed": {"points": CURVE, "weights": WEIGHTS, "rational": "fixed"},
    "bernstein": {"points": CURVE, "basis": "bernstein", "method": "direct"},
    "said_ball": {"points": CURVE, "basis": "said_ball", "method": "direct"},
    "wang_ball": {"points": CURVE, "basis": "wang_ball", "method": "direct"},
    "said_ball_fixed": {
        "points": CURVE,
        "basis": "said_ball",
        "method": "direct",
        "weights": WEIGHTS,
        "rational": "fixed",
    },
    "surface": {"points": SURFACE},
    "mixed_surface": {
        "points": SURFACE,
        "basis": {"u": "bspline", "v": "said_ball"},
        "degree": {"u": 2, "v": None},
        "method": "direct",
    },
    "tube": {"points": TUBE, "closed": {"u": True, "v": False}},
    "homogeneous_surface": {"points": SURFACE, "weights": GRID},
    "fixed_surface": {
        "points": SURFACE,
        "weights": {"u": [1, 1.2, 1, 1, 0.9, 1], "v": [1, 1.1, 1, 1, 1]},
        "rational": "fixed",
    },
}

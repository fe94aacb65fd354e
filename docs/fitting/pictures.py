"""The pictures of docs/how-to/choose-a-fit.md and of the README, fitted and drawn by a real server.

    docs/fitting/pictures.py PROGRAM    # the server to start, such as target/debug/piad

Needs numpy.
"""

import json
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
EXAMPLES = FOLDER.parents[1] / "examples"
sys.path.insert(0, str(FOLDER.parents[1] / "tests" / "python"))
from over_http import fetch, server


def noisy() -> list:
    """60 measurements of a profile, with an error of about a hundredth of its width."""
    x = np.linspace(0, 6, 60)
    y = np.tanh(4 * (x - 2)) + 0.4 * np.sin(1.5 * x) + 0.08 * np.random.default_rng(5).standard_normal(60)
    return np.c_[x, y].tolist()


def with_outliers() -> list:
    """120 points of a wave, of which three are wrong."""
    s = np.linspace(0, 1, 120)
    y = 20 * np.sin(7 * s)
    y[[17, 60, 101]] += [12, 14, -15]
    return np.c_[100 * s, y].tolist()


def profile() -> list:
    """An open profile with sharp corners and a fillet: points along the first edge and the fillet, and ends of edges."""
    edge = np.c_[np.linspace(0, 30, 7), np.zeros(7)]
    angle = np.linspace(0, np.pi / 2, 9)[1:-1]
    fillet = np.c_[50 + 20 * np.sin(angle), 20 - 20 * np.cos(angle)]
    ends = [[70, 20], [70, 24], [70, 28], [70, 35], [70, 50], [60, 50], [60, 30], [0, 30], [0, 15]]
    return [*edge.tolist(), [50, 0], *fillet.tolist(), *ends]


def plate() -> list:
    """An outline with round corners: edges have two points, arcs one every 15 degrees."""
    centres = [(105, 15), (105, 55), (15, 55), (15, 15)]
    angle = np.linspace(0, np.pi / 2, 7)
    turns = [angle + (k - 1) * np.pi / 2 for k in range(4)]
    arcs = [np.c_[x + 15 * np.cos(turn), y + 15 * np.sin(turn)] for (x, y), turn in zip(centres, turns)]
    return np.concatenate(arcs).tolist()


def half_circle() -> list:
    angle = np.linspace(0, np.pi, 6)
    return np.c_[np.cos(angle), np.sin(angle)].tolist()


def leaves(tolerance: float) -> dict:
    """The outline of `examples/leaves.json`, within another tolerance."""
    example = json.loads((EXAMPLES / "leaves.json").read_text())
    return example | {"stop": {"tolerance": tolerance}}


def recipes() -> dict:
    """What the README's recipes fit."""
    auto = {"kind": "least_squares", "control_points": "auto"}
    airfoil = np.loadtxt(EXAMPLES / "naca2412.dat", skiprows=1).tolist()
    scan = np.loadtxt(EXAMPLES / "scan.xyz").tolist()
    return {
        "airfoil": {"curve": {"points": airfoil}, "method": auto, "stop": {"tolerance": 1e-4}},
        "scan": {"surface": {"scattered": scan, "parameters": "project"}, "method": auto, "stop": {"tolerance": 0.2}},
        "peaks": json.loads((EXAMPLES / "peaks.json").read_text()),
    }


def jobs() -> dict:
    least_squares = {"kind": "least_squares", "variant": "direct", "control_points": 14}
    curve = {"points": noisy(), "parameters": "uniform"}
    return {
        "interpolated": {"curve": curve},
        "approximated": {"curve": curve, "method": least_squares},
        "fair": {"curve": curve, "method": least_squares | {"control_points": 40, "fairness": 1e-8}},
        "constrained": {
            "curve": curve,
            "method": least_squares
            | {"constraints": [{"at": "start", "tangent": [1, 0]}, {"at": "end", "tangent": [1, 0]}, {"at": {"parameter": 0.5}, "point": [3, 0.2]}]},
        },
        "outliers": {"curve": {"points": with_outliers()}, "method": least_squares | {"control_points": 24}},
        "robust": {"curve": {"points": with_outliers()}, "method": least_squares | {"control_points": 24, "robust": True}},
        "swinging": {"curve": {"points": profile()}, "method": "direct"},
        "cornered": {"curve": {"points": profile(), "corners": "auto"}, "method": "direct"},
        "bulging": {"curve": {"points": plate(), "closed": True}, "method": "direct"},
        "straight": {"curve": {"points": plate(), "closed": True, "polyline": True}, "stop": {"tolerance": 0.1}},
        "ends_repeated": {"curve": {"points": half_circle(), "ends": "repeated"}},
        "ends_estimated": {"curve": {"points": half_circle()}},
        "within_a_tenth": leaves(0.1),
        "within_a_thousandth": leaves(0.001),
    }


def growing(base: str) -> None:
    """One fit on its way: the first iterations with at least 5, 9 and 14 control points, and the last."""
    resource = json.loads(fetch(f"{base}/v1/jobs", json.dumps(leaves(0.01) | {"name": "on the way"}).encode()))
    path = base + resource["links"]["self"]
    wanted = [5, 9, 14]
    for k in range(resource["iteration"] + 1):
        iteration = json.loads(fetch(f"{path}/iterations/{k}"))
        count = len(iteration["control_points"])
        if k < resource["iteration"] and not (wanted and count >= wanted[0]):
            continue
        del wanted[:1]
        (FOLDER / f"growing_{count}.svg").write_bytes(fetch(f"{path}/iterations/{k}/svg"))
        print(f"{count} control points at iteration {k}: largest distance {iteration['error']['max']:.3g}")


def main() -> int:
    with server(sys.argv[1]) as base:
        growing(base)
        for name, job in (jobs() | recipes()).items():
            job["name"] = name.replace("_", " ")
            resource = json.loads(fetch(f"{base}/v1/jobs", json.dumps(job).encode()))
            assert resource["state"] == "converged" or name in ("swinging", "bulging"), resource
            samples = "?samples=40x40" if resource["kind"] == "surface" else ""
            picture = fetch(f"{base}{resource['links']['result']}/svg{samples}")
            (FOLDER / f"{name}.svg").write_bytes(picture)
            print(f"{name}: largest distance {resource['error']['max']:.3g} after {resource['iteration']} iterations")
    return 0


if __name__ == "__main__":
    sys.exit(main())

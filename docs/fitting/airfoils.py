"""The table of docs/how-to/choose-a-fit.md: interpolations of every second point of 150 airfoils, and where the others lie.

    docs/fitting/airfoils.py PROGRAM    # the server to start, such as target/release/piad

The airfoils are those of UIUC, as the package aerosandbox has them; its wheel is downloaded and read as a zip file,
nothing of it is installed. Needs numpy and pip.
"""

import io
import json
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "python"))
from over_http import fetch, server

COUNT, FEWEST = 150, 61
CHOICES = [
    (parameters, knots, ends)
    for parameters in ("chord_length", "centripetal", "uniform")
    for knots, ends in (("data", "estimated"), ("data", "natural"), ("data", "repeated"), ("averaged", None))
]


def airfoils() -> list[tuple[str, np.ndarray]]:
    """150 of them, evenly spread over the alphabet, of all that are one list of at least 61 distinct points."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", folder, "aerosandbox==4.2.9"], check=True)
        [wheel] = Path(folder).glob("*.whl")
        archive = zipfile.ZipFile(io.BytesIO(wheel.read_bytes()))
    found = []
    for name in sorted(archive.namelist()):
        if name.endswith(".dat"):
            lines = archive.read(name).decode("latin-1").splitlines()
            rows = [re.findall(r"[-+]?\d*\.?\d+(?:[eE][-+]?\d+)?", line) for line in lines[1:] if line.strip()]
            if any(len(row) != 2 for row in rows):
                continue
            points = np.array(rows, float)
            steps = np.linalg.norm(np.diff(points, axis=0), axis=1) if len(points) > 1 else np.zeros(1)
            # Lists that jump from one side to the other are not ordered around the airfoil.
            if len(points) >= FEWEST and steps.min() > 1e-6 and steps.max() < 0.2 and np.abs(points).max() < 2:
                found.append((Path(name).stem, points))
    places = np.linspace(0, len(found) - 1, COUNT).astype(int)
    return [found[k] for k in places]


def distances(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Of points from a polygon."""
    start, step = polygon[:-1], np.diff(polygon, axis=0)
    squares = (step**2).sum(axis=1)
    offset = points[:, None] - start
    share = np.clip((offset * step).sum(axis=2) / np.where(squares > 0, squares, 1), 0, 1)
    return np.linalg.norm(offset - share[..., None] * step, axis=2).min(axis=1)


def largest(base: str, points: np.ndarray, parameters: str, knots: str, ends: str | None) -> float:
    """The largest distance of the points that are left out from the curve through the others, in chords."""
    curve = {"points": points[::2].tolist(), "parameters": parameters, "basis": {"kind": "bspline", "degree": 3, "knots": knots}}
    if ends:
        curve["ends"] = ends
    resource = json.loads(fetch(f"{base}/v1/jobs", json.dumps({"curve": curve, "method": "direct"}).encode()))
    assert resource["state"] == "converged", resource
    result = json.loads(fetch(f"{base}{resource['links']['result']}?view=samples&samples=5001"))
    chord = np.ptp(points[:, 0])
    return distances(points[1::2], np.array(result["samples"])).max() / chord


def main() -> int:
    found = {choice: [] for choice in CHOICES}
    sections = airfoils()
    with server(sys.argv[1]) as base:
        for _, points in sections:
            for choice in CHOICES:
                found[choice].append(largest(base, points, *choice))
    best = np.min([found[choice] for choice in CHOICES], axis=0)
    print(f"{len(sections)} airfoils of {min(len(p) for _, p in sections)} to {max(len(p) for _, p in sections)} points\n")
    print("| parameters | knots | ends | median | 90 % below | worst | within 10 % of the best |")
    print("|---|---|---|---|---|---|---|")
    for choice in CHOICES:
        values = np.array(found[choice])
        names = " | ".join(f"`{name}`" if name else "–" for name in choice)
        near = np.count_nonzero(values <= 1.1 * best)
        print(f"| {names} | {np.median(values):.1e} | {np.quantile(values, 0.9):.1e} | {values.max():.1e} | {near} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""The units that STEP and IGES files declare, by the lengths that OpenCASCADE reads in millimetres.

    units.py PROGRAM            # the server to start, such as target/debug/piad

Needs the packages of requirements.txt.
"""

import json
import os
import sys
import tempfile

import numpy as np

import cad
from over_http import ROOT, fetch, server

MILLIMETRES = {None: 1.0, "mm": 1.0, "m": 1000.0, "in": 25.4}


def length(path: str, axes: int) -> float:
    """The length of the chords of a curve, or of the first line of a surface, after conversion to millimetres."""
    geometry = cad.CadFile(path).geometry()
    if axes == 1:
        sites = [np.linspace(geometry.FirstParameter(), geometry.LastParameter(), 501)]
    else:
        u0, u1, v0, _ = geometry.Bounds()
        sites = [np.linspace(u0, u1, 501), np.array([v0])]
    places = np.asarray(cad.evaluate(geometry, *sites)).reshape(-1, 3)
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def check(base: str, name: str, axes: int, folder: str) -> None:
    with open(os.path.join(ROOT, "examples", f"{name}.json"), "rb") as file:
        result = base + json.loads(fetch(f"{base}/v1/jobs", file.read()))["links"]["result"]
    samples = json.loads(fetch(f"{result.removesuffix('/result')}/iterations/last?view=samples&samples="
                               + ("501" if axes == 1 else "501x2")))["samples"]
    # Points of a curve, or rows of points of which the first one counts.
    points = samples if axes == 1 else [row[0] for row in samples]
    points = [list(point) + [0.0] * (3 - len(point)) for point in points]
    expected = float(np.linalg.norm(np.diff(np.array(points), axis=0), axis=1).sum())
    for format in ("step", "iges"):
        for unit, factor in MILLIMETRES.items():
            path = os.path.join(folder, f"{name}.{format}")
            query = f"?units={unit}" if unit else ""
            with open(path, "wb") as file:
                file.write(fetch(f"{result}/{format}{query}"))
            found = length(path, axes)
            assert abs(found - factor * expected) <= 1e-9 * factor * expected, (name, format, unit, found, expected)
            print(f"{name} as {format} in {unit or 'no unit of choice'}: {found:.6f} mm")


def main() -> None:
    with tempfile.TemporaryDirectory() as folder, server(sys.argv[1]) as base:
        check(base, "helix", 1, folder)
        check(base, "peaks", 2, folder)


if __name__ == "__main__":
    main()

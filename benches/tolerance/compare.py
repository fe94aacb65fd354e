"""The fewest control points for a tolerance: compares piad over HTTP with scipy and OpenCASCADE, in
one run.

    compare.py PROGRAM [PART …]     # PROGRAM is target/release/piad; parts: curves splines airfoils times surfaces grid terrain

- curves: published and common ones, and chirps, at four tolerances, with cubics of all three, and
  with free degrees (piad's quintics, OpenCASCADE's degrees up to 8);
- splines: points of cubics with few knots;
- airfoils: all those of UIUC in the package aerosandbox, at 1e-3 and 1e-4 of the chord;
- times: 10,000 and 100,000 points, exact, to 1e-4 of their size and finer, and with noise, until the last event is there;
- surfaces: Franke's function at 1500 scattered points;
- grid: 200 × 150 elevations, within 1 % of their range, beside scipy with the smoothing factor found by bisection;
- terrain: 100,000 elevations, at what scipy reaches and below.

scipy is given the best of twenty smoothing factors. fits.py checks piad's distances with scipy.
Exits with code 1 if piad is not within the tolerance, needs more control points than the better of
both for one of the curves or for Franke's function, two more than a spline with few knots has, not
10% fewer for all curves or airfoils together, more in total for the terrain, or more time. Needs
requirements.txt; `make tolerance` installs them and takes three quarters of an hour.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import fits
import shapes
from fits import Fit, limited

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "python"))
from over_http import server

# Time limit in seconds for a curve or surface; number of interleaved runs of compared times.
CURVE, SURFACE = 120, 300
ROUNDS = 5
wrong: list[str] = []


def table(*head: str) -> None:
    row(*head)
    row(*["---"] * len(head))


def row(*cells: object) -> None:
    print("|", " | ".join(map(str, cells)), "|", flush=True)


def count(fit: Fit | None) -> str:
    return str(fit.count) if fit else "–"


def shape(fit: Fit) -> str:
    return f"{' × '.join(map(str, fit.shape))} = {fit.count}"


def least(*others: Fit | None) -> int | None:
    return min((fit.count for fit in others if fit), default=None)


def curves(base: str) -> None:
    table("data", "tolerance", "piad", "scipy", "OpenCASCADE", "piad, quintic", "OpenCASCADE, degree ≤ 8", "piad's largest distance / tolerance")
    total, better = 0, 0
    for name, make, tolerances in shapes.CURVES:
        points = make()
        curve = {"points": points}
        for tolerance in tolerances:
            cubic = fits.piad(base, {"curve": curve}, tolerance)
            quintic = fits.piad(base, {"curve": curve | {"degree": 5}}, tolerance)
            scipy = fits.scipy_curve(points, tolerance)
            third, eighth = (limited(60, fits.opencascade_curve, points, tolerance, degree) for degree in (3, 8))
            row(name, f"{tolerance:g}", *map(count, (cubic, scipy, third, quintic, eighth)), f"{cubic.largest / tolerance:.3f}")
            most, free = least(scipy, third), least(eighth)
            if cubic.ended != "converged" or cubic.count > most or free and quintic.count > free:
                wrong.append(f"{name}, {tolerance:g}: {cubic}, {quintic}")
            total, better = total + cubic.count, better + most
    print(f"\nIn all, cubics: {total} control points, the better of the others {better}: {1 - total / better:.0%} fewer.\n")
    if total > 0.9 * better:
        wrong.append(f"curves: {total} control points in all, the better of the others {better}")


def splines(base: str) -> None:
    table("cubic with inner knots", "tolerance", "its control points", "piad", "scipy")
    for knots in shapes.SPLINES:
        t, points = shapes.few_knots(knots)
        for tolerance in (1e-3, 1e-5, 1e-7):
            piad = fits.piad(base, {"curve": {"points": points, "parameters": t}}, tolerance)
            scipy = fits.scipy_curve(points, tolerance, t)
            own = len(knots) + 4
            row(len(knots), f"{tolerance:g}", own, piad.count, count(scipy))
            if piad.ended != "converged" or piad.count > own + 2:
                wrong.append(f"cubic with {len(knots)} knots, {tolerance:g}: {piad}")
    print()


def airfoils(base: str) -> None:
    sections = shapes.airfoils()
    sizes = [len(points) for _, points in sections]
    print(f"{len(sections)} airfoils of {min(sizes)} to {max(sizes)} points\n")
    table("tolerance", "piad needs fewer", "equally many", "more", "piad, in all", "scipy", "OpenCASCADE", "the better of both")
    for tolerance in (1e-3, 1e-4):
        found = []
        for name, points in sections:
            piad = fits.piad(base, {"curve": {"points": points}}, tolerance)
            if piad.ended != "converged":
                wrong.append(f"{name}, {tolerance:g}: {piad}")
            # Interpolation is within each tolerance, with one control point per point.
            scipy = least(fits.scipy_curve(points, tolerance)) or len(points)
            opencascade = least(limited(60, fits.opencascade_curve, points, tolerance, 3)) or len(points)
            found.append((piad.count, scipy, opencascade, min(scipy, opencascade)))
        piad, *_, better = counts = np.array(found).T
        compared = [np.count_nonzero(it) for it in (piad < better, piad == better, piad > better)]
        row(f"{tolerance:g} of the chord", *compared, *counts.sum(axis=1))
        if piad.sum() > 0.9 * better.sum():
            wrong.append(f"airfoils, {tolerance:g}: {piad.sum()} control points, the better of the others {better.sum()}")
    print()


def times(base: str) -> None:
    table("data", "tolerance", "", "control points", "largest distance / tolerance", "first within it, s", "control points then", "all, s", "times as long as piad", "all runs until within it, s")
    for points_of, noise, tolerance in ((100_000, 0, 3e-3), (10_000, 0, 1e-3), (10_000, 1e-3, 6e-3), (100_000, 0, 1e-3), (100_000, 1e-3, 6e-3)):
        points = shapes.spiral(points_of, noise)
        name = f"{points_of:,} points, {f'noise of {noise}' if noise else 'exact'}"
        runs: dict[str, list[Fit | None]] = {"piad, over HTTP": [], "scipy": []}
        for _ in range(ROUNDS):
            runs["piad, over HTTP"].append(fits.piad(base, {"curve": {"points": points}}, tolerance))
            runs["scipy"].append(limited(CURVE, fits.first_of_scipy, points, tolerance))
        runs["OpenCASCADE"] = [limited(CURVE, fits.opencascade_curve, points, tolerance, 3)]
        medians = {program: median(of) for program, of in runs.items()}
        piad = medians["piad, over HTTP"]
        for program, fit in medians.items():
            if fit is None:
                row(name, f"{tolerance:g}", program, "–", "–", "", "", f"more than {CURVE}", f"more than {CURVE / piad.seconds:.0f}", "")
                continue
            first = (f"{fit.first:.2f}", fit.first_count) if fit is piad else ("", "")
            searched = f"{fit.searched:.2f}" if fit.searched else ""
            row(name, f"{tolerance:g}", program, fit.count, f"{fit.largest / tolerance:.3f}", *first, f"{fit.seconds:.2f}", f"{fit.seconds / piad.seconds:.1f}", searched)
            if fit is not piad and (fit.seconds <= piad.seconds or fit.count < piad.count):
                wrong.append(f"times, {name}: {program} {fit}, piad {piad}")
    print()


def median(runs: list[Fit | None]) -> Fit | None:
    """The run of median time; none if one of them has not ended."""
    return None if None in runs else sorted(runs, key=lambda fit: fit.seconds)[len(runs) // 2]


def scattered(points: np.ndarray) -> dict:
    return {"surface": {"scattered": points, "parameters": {"project": "xy"}}}


def surfaces(base: str) -> None:
    points = shapes.franke()
    table("Franke's function, largest distance", "piad", "seconds", "scipy", "seconds")
    for tolerance in (1e-2, 1e-3, 1e-4):
        piad = fits.piad(base, scattered(points), tolerance)
        scipy = fits.scipy_surface(points, tolerance)
        row(f"{tolerance:g}", shape(piad), f"{piad.seconds:.2f}", shape(scipy), f"{scipy.seconds:.2f}")
        if piad.ended != "converged" or piad.count > scipy.count:
            wrong.append(f"Franke's function, {tolerance:g}: {piad}, scipy {scipy}")
    print()


def grid(base: str) -> None:
    points = shapes.elevations()
    heights = points[..., 2]
    tolerance = 0.01 * np.ptp(heights)
    piad = fits.piad(base, {"surface": {"points": points, "parameters": "uniform"}}, tolerance)
    scipy, runs, seconds = fits.bisected_grid(points, tolerance)
    table("200 × 150 elevations", "tolerance", "control points", "largest distance", "seconds")
    row("piad, over HTTP", f"{tolerance:.2f} m", shape(piad), f"{piad.largest:.2f} m", f"{piad.seconds:.2f}")
    row("scipy, the last run", f"{tolerance:.2f} m", shape(scipy), f"{scipy.largest:.2f} m", f"{scipy.seconds:.2f}")
    row(f"scipy, {runs} runs", "", "", "", f"{seconds:.2f}")
    print()
    if piad.ended != "converged" or piad.count > scipy.count:
        wrong.append(f"grid: {piad}, scipy {scipy}")


def terrain(base: str) -> None:
    points = shapes.terrain()
    table("100,000 elevations, tolerance", "piad", "largest distance", "ended", "seconds", "scipy", "largest distance", "seconds")

    def line(tolerance: float, scipy: Fit | None, *cells: str) -> Fit:
        piad = fits.piad(base, scattered(points), tolerance)
        if scipy:
            cells = (shape(scipy), f"{scipy.largest:.1f} m", f"{scipy.seconds:.0f}")
        row(f"{tolerance:.1f} m", shape(piad), f"{piad.largest:.1f} m", piad.ended, f"{piad.seconds:.1f}", *cells)
        return piad

    # The largest distances of smoothing splines of these root mean squares are piad's tolerances.
    total = np.zeros(2, int)
    for rms in (60, 40, 25):
        scipy = limited(SURFACE, fits.smoothed_surface, points, len(points) * rms**2)
        if scipy is None:
            print(f"scipy: a root mean square of {rms} m takes more than {SURFACE} s", flush=True)
            continue
        piad = line(scipy.largest, scipy)
        total += piad.count, scipy.count
        if piad.ended != "converged" or piad.seconds >= scipy.seconds:
            wrong.append(f"terrain: {piad}, scipy {scipy}")
    if total[0] > total[1]:
        wrong.append(f"terrain: {total[0]} control points in all, scipy {total[1]}")
    for tolerance in (50, 20, 10, 5):
        line(tolerance, None, "", "", "")
    # Elevations are whole metres: a largest distance of 1 m corresponds to a root mean square of at
    # most 0.3 m.
    scipy = limited(SURFACE, fits.smoothed_surface, points, len(points) * 0.3**2)
    line(1, scipy, "–", "–", f"more than {SURFACE}")
    print()


PARTS = {part.__name__: part for part in (curves, splines, airfoils, times, surfaces, grid, terrain)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("part", nargs="*", choices=[*PARTS, []])
    given = parser.parse_args()
    with server(given.program) as base:
        for part in given.part or PARTS:
            PARTS[part](base)
    print("\n".join(wrong) or "ok: no row is worse than it may be")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

"""Compares scans and grids by piad with scipy and geomdl, in one run.

    compare.py PROGRAM [--gismo DIR] [PART …]     # PROGRAM is target/release/piad; parts: scans grids around

- scans: heights at scattered positions, within a tolerance, compared with `SmoothBivariateSpline`
  of scipy, with a smoothing factor found by bisection. piad fits over x and y, like scipy, and once
  with automatic parameters;
- grids: the fewest control points that meet the tolerance, and the same number by
  `approximate_surface` of geomdl;
- around: scans around an axis and of a sphere with the parameters that piad chooses, measured by OpenCASCADE on the face
  of the STEP file;
- with --gismo: the scan of a deep-drawn part in a checkout of G+Smo, with its parameters, beside least squares with as
  many control points and knots at equal distances.

scipy evaluates all surfaces. Distances are the largest and the root mean square: at the data, and *between* them, from exact
points that are not in the data. *Outside* is the excess of the surface over the range of the
heights on its whole rectangle, relative to that range. Exits with code 1 if piad is not within the
tolerance, needs more control points in total than scipy, or has an invalid face. Needs
../tolerance/requirements.txt, and a quarter of an hour, mostly for scipy.
"""

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
from OCP.gp import gp_Pnt
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

import data
import surfaces
from fits import limited
from surfaces import Surface

# The time limit in seconds for the runs of one surface.
LIMIT = 600
wrong: list[str] = []


def row(*cells: object) -> None:
    print("|", " | ".join(map(str, cells)), "|", flush=True)


def table(*head: str) -> None:
    print()
    row(*head)
    row(*["---"] * len(head))


def shape(surface: Surface) -> str:
    return f"{surface.net.shape[0]} × {surface.net.shape[1]} = {surface.count}"


def rms(away: np.ndarray) -> float:
    return np.sqrt((away**2).mean())


def check(name: str, tolerance: float, largest: float, ended: str) -> None:
    if ended != "converged" or largest > tolerance * (1 + 1e-9):
        wrong.append(f"{name}, {tolerance:g}: piad ended {ended} with a largest distance of {largest:.3g}")


def job_of(surface: dict, tolerance: float, control_points: object = "auto") -> dict:
    method = {"kind": "least_squares", "control_points": control_points}
    return {"surface": surface, "method": method, "stop": {"tolerance": tolerance}}


# ---------------------------------------------------------------- scans


def outside(surface: Surface, heights: np.ndarray) -> float:
    values = surface.on_rectangle(600)
    values = values[..., -1] if values.ndim == 3 else values
    low, high = heights.min(), heights.max()
    return max(low - values.min(), values.max() - high, 0) / (high - low)


def distances(surface: Surface, scan: data.Scan) -> tuple[np.ndarray, np.ndarray | None]:
    """At the data, and between them within their rectangle, of a surface over x and y."""
    places = scan.points[:, :2]
    within = ((scan.between[:, :2] >= places.min(axis=0)) & (scan.between[:, :2] <= places.max(axis=0))).all(axis=1)
    between = scan.between[within]
    if surface.net.ndim == 2:
        return tuple(surface.at(*points[:, :2].T) - points[:, 2] for points in (scan.points, between))
    at_data = np.linalg.norm(surface.at(*surface.parameters) - scan.points, axis=1)
    if not all(np.array_equal(*pair) for pair in zip(surface.parameters, scan.points.T)):
        return at_data, None
    return at_data, surface.at(*between[:, :2].T)[:, 2] - between[:, 2]


def figures(away: np.ndarray | None) -> str:
    return "–" if away is None else f"{np.abs(away).max():.3g}, {rms(away):.3g}"


def scan_row(scan: data.Scan, tolerance: float, who: str, surface: Surface, seconds: str) -> float:
    at_data, between = distances(surface, scan)
    far = f"{outside(surface, scan.points[:, 2]):.1%}"
    row(scan.name, f"{tolerance:g}", who, shape(surface), figures(at_data), figures(between), far, seconds)
    return np.abs(at_data).max()


def by_piad(program: str, scan: data.Scan, tolerance: float, who: str, parameters: object) -> Surface | None:
    surface = {"scattered": scan.points.tolist(), "parameters": parameters}
    found = surfaces.piad(program, job_of(surface, tolerance), LIMIT)
    if found is None:
        wrong.append(f"{scan.name}, {tolerance:g}: {who} takes more than {LIMIT} s")
        return None
    seconds = f"{found.seconds:.1f}" + ("" if found.ended == "converged" else f", {found.ended}")
    check(f"{scan.name}, {who}", tolerance, scan_row(scan, tolerance, who, found, seconds), found.ended)
    return found


def by_scipy(scan: data.Scan, tolerance: float) -> Surface | None:
    search = surfaces.bisected(scan.points, tolerance, LIMIT)
    seconds = f"{search.seconds:.1f} in {search.runs} runs" + ("" if search.in_time else ", ended")
    if search.best is None:
        row(scan.name, f"{tolerance:g}", "scipy", "none", f"{search.last:.3g}", "", "", seconds)
    else:
        scan_row(scan, tolerance, "scipy", search.best, f"{search.best.seconds:.1f}; {seconds}")
    return search.best


def scans(program: str) -> None:
    table("scan", "tolerance", "", "control points", "at the data", "between", "outside", "seconds")
    piad_count, scipy_count = 0, 0
    for make in data.SCANS:
        scan = make()
        for tolerance in scan.tolerances:
            piad = by_piad(program, scan, tolerance, "piad", {"project": "xy"})
            by_piad(program, scan, tolerance, "piad, own parameters", "auto")
            scipy = by_scipy(scan, tolerance)
            if piad and scipy:
                piad_count, scipy_count = piad_count + piad.count, scipy_count + scipy.count
    print(f"\nIn all, where both have a surface: piad {piad_count} control points, scipy {scipy_count}.")
    if piad_count > scipy_count:
        wrong.append(f"scans: {piad_count} control points in all, scipy {scipy_count}")


# ---------------------------------------------------------------- grids


def grid_row(name: str, tolerance: float, who: str, surface: Surface | None, grid: np.ndarray) -> float:
    if surface is None:
        row(name, f"{tolerance:g}", who, "none", "", f"more than {LIMIT}")
        return np.inf
    there = surface.at(*np.meshgrid(*surface.parameters, indexing="ij"))
    away = np.linalg.norm(there - grid, axis=-1)
    row(name, f"{tolerance:g}", who, shape(surface), figures(away), f"{surface.seconds:.2f}")
    return away.max()


def grids(program: str) -> None:
    table("grid", "tolerance", "", "control points", "at the data", "seconds")
    for name, grid, tolerances in data.grids():
        surface = {"points": grid.tolist()}
        for tolerance in tolerances:
            few = surfaces.piad(program, job_of(surface, tolerance), LIMIT)
            largest = grid_row(name, tolerance, "piad, as few as it takes", few, grid)
            check(name, tolerance, largest, few.ended if few else "never")
            if few is None:
                continue
            numbers = dict(zip("uv", few.net.shape))
            same = surfaces.piad(program, job_of(surface, tolerance, numbers), LIMIT)
            grid_row(name, tolerance, "piad, as many", same, grid)
            grid_row(name, tolerance, "geomdl, as many", limited(LIMIT, surfaces.geomdl, grid, few.net.shape[:2]), grid)


# ---------------------------------------------------------------- around an axis


def measured(step: Path, *clouds: np.ndarray) -> tuple[bool, list[np.ndarray]]:
    """True if the shape of a STEP file is valid; distances of points from the surface of its face."""
    reader = STEPControl_Reader()
    reader.ReadFile(str(step))
    reader.TransferRoots()
    body = reader.OneShape()
    face = TopoDS.Face_s(TopExp_Explorer(body, TopAbs_FACE).Current())
    projected = GeomAPI_ProjectPointOnSurf(gp_Pnt(*clouds[0][0]), BRep_Tool.Surface_s(face))

    def away(point: list[float]) -> float:
        projected.Perform(gp_Pnt(*point))
        return projected.LowerDistance()

    return BRepCheck_Analyzer(body).IsValid(), [np.array([away(point) for point in cloud.tolist()]) for cloud in clouds]


def around(program: str) -> None:
    table("scan", "tolerance", "", "control points", "at the data", "between", "valid", "seconds")
    for scan in data.around():
        for tolerance in scan.tolerances:
            around_row(program, scan, tolerance)


def around_row(program: str, scan: data.Scan, tolerance: float) -> None:
    with TemporaryDirectory() as folder:
        step = Path(folder) / "face.step"
        found = surfaces.piad(program, job_of({"scattered": scan.points.tolist()}, tolerance), LIMIT, step)
        if found is None:
            wrong.append(f"{scan.name}, {tolerance:g}: more than {LIMIT} s")
            return
        is_valid, (at_data, between) = measured(step, scan.points, scan.between)
    away = figures(at_data), figures(between)
    row(scan.name, f"{tolerance:g}", "piad", shape(found), *away, is_valid, f"{found.seconds:.1f}")
    check(scan.name, tolerance, at_data.max(), found.ended)
    if not is_valid:
        wrong.append(f"{scan.name}, {tolerance:g}: the face is not valid")


# ---------------------------------------------------------------- G+Smo


def deep_drawing(program: str, folder: Path) -> None:
    points, parameters = data.deep_drawing(folder)
    table("scan", "tolerance", "", "control points", "at the data", "seconds")
    for tolerance in (0.5, 0.2):
        surface = {"scattered": points.tolist(), "parameters": parameters.tolist()}
        found = surfaces.piad(program, job_of(surface, tolerance), LIMIT)
        if found is None:
            wrong.append(f"deep drawing, {tolerance}: more than {LIMIT} s")
            continue
        same = limited(LIMIT, surfaces.uniform, parameters, points, found.net.shape[:2])
        for who, it in (("piad", found), ("knots at equal distances", same)):
            if it is None:
                continue
            away = np.linalg.norm(it.at(*parameters.T) - points, axis=1)
            name = f"deep-drawn part, {len(points):,} points"
            row(name, f"{tolerance:g}", who, shape(it), figures(away), f"{it.seconds:.1f}")
            if it is found:
                check("deep drawing", tolerance, away.max(), found.ended)


PARTS = {part.__name__: part for part in (scans, grids, around)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("part", nargs="*", choices=[*PARTS, []])
    parser.add_argument("--gismo", type=Path, metavar="DIR", help="a checkout of G+Smo")
    given = parser.parse_intermixed_args()
    for part in given.part or PARTS:
        PARTS[part](given.program)
    if given.gismo:
        deep_drawing(given.program, given.gismo)
    print("\n" + ("\n".join(wrong) or "ok: no row is worse than it may be"))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

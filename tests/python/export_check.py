"""Reads exported files with other software and compares them with their result.

    export_check.py RESULT.json FILE... [--job JOB.json]
    export_check.py --all FOLDER        # NAME.result.json, NAME.job.json, NAME.step, …

RESULT.json is the response of `GET /v1/jobs/{id}/result`, JOB.json the request. The extension
determines the format. Needs the packages of requirements.txt.
"""

import argparse
import csv
import glob
import json
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

import cairosvg
import ezdxf
import numpy as np
import pygltflib
import rhino3dm
import trimesh
from scipy.ndimage import minimum_filter
from scipy.optimize import least_squares
from steputils import p21

import cad
from expected import Spline, load

# Numbers that are written and read back are equal; converted ones have rounding errors.
SAME = 0.0
CONVERTED = 1e-13
EVALUATED = 2e-13


def equal(found, expected, tolerance: float, what: str) -> None:
    found, expected = np.asarray(found, dtype=float), np.asarray(expected, dtype=float)
    assert found.shape == expected.shape, f"{what}: {found.shape} is not {expected.shape}"
    scale = max(float(np.abs(expected).max()), 1e-300)
    worst = float((np.abs(found - expected) / scale).max())
    assert worst <= tolerance, f"{what}: differs by {worst:.3g}, allowed {tolerance:.3g}"
    worst_of[what] = max(worst_of.get(what, 0.0), worst)


# The largest deviation of each kind, for the summary.
worst_of: dict[str, float] = {}


def check_raw(raw: cad.Raw, spline: Spline, what: str) -> None:
    tolerance = SAME if spline.exact else CONVERTED
    assert raw.degrees == spline.degrees, f"{what}: degrees {raw.degrees}"
    assert raw.closed == spline.closed, f"{what}: closed {raw.closed}"
    for found, expected in zip(raw.knots, spline.knots, strict=True):
        equal(found, expected, SAME, f"{what} knots")
    equal(raw.poles, spline.poles, tolerance, f"{what} poles")
    assert (raw.weights is None) == (spline.weights is None), f"{what}: rational or not"
    if raw.weights is not None:
        equal(raw.weights, spline.weights, tolerance, f"{what} weights")
    for axis, domain in enumerate(raw.domains or []):
        equal(domain, spline.domain(axis), SAME, f"{what} domain")


def check_geometry(file: cad.CadFile, spline: Spline, what: str) -> None:
    """OpenCASCADE evaluates to the same points at the same parameters."""
    geometry = file.geometry()
    axes = range(len(spline.degrees))
    parameters = [spline.parameters(axis, 61 if len(axes) == 1 else 23) for axis in axes]
    expected = spline.evaluate(*parameters)
    equal(cad.evaluate(geometry, *parameters), expected, EVALUATED, f"{what} places")
    if not any(spline.closed):
        made = cad.of_geometry(geometry)
        made.closed = spline.closed
        check_raw(made, spline, f"{what} geometry")


def check_data(file: cad.CadFile, spline: Spline, job: dict, what: str) -> None:
    """The distances of the data by OpenCASCADE equal those of the fit."""
    if not 1e-3 < spline.extent < 1e6:
        return  # beyond the range of OpenCASCADE
    shape = job.get("curve") or job["surface"]
    points = shape["points"]
    points = points if "curve" in job else [point for row in points for point in row if point]
    slack = 1e-7 + 1e-12 * spline.magnitude
    for place in points[:: max(1, len(points) // 150)]:
        place = list(place) + [0.0] * (3 - len(place))
        distance = file.distance(place)
        if distance > spline.error + slack and spline.is_surface:
            # OpenCASCADE can miss the nearest of several minima.
            distance = nearest(spline, np.array(place))[0]
        assert distance <= spline.error + slack, f"{what}: a data point is {distance} away"
        name = f"{what} data beyond the error of the fit"
        worst_of[name] = max(worst_of.get(name, 0.0), distance - spline.error)


def check_step(path: str, spline: Spline, job: dict | None) -> None:
    file = cad.CadFile(path)
    check_raw(cad.of_step(file), spline, "STEP")
    check_geometry(file, spline, "STEP")
    if 1e-6 < spline.extent < 1e9:
        assert file.is_valid(), "STEP: the shape is not valid"
    if job:
        check_data(file, spline, job, "STEP")
        # A parser in Python reads the syntax and the escapes.
        name = p21.readfile(path).header.entities["FILE_NAME"].params[0]
        kind = "surface" if spline.is_surface else "curve"
        assert name == (job.get("name") or kind), f"STEP: the name is {name!r}"


def check_iges(path: str, spline: Spline, job: dict | None) -> None:
    file = cad.CadFile(path)
    check_raw(cad.of_iges(file), spline, "IGES")
    check_raw(cad.of_pyiges(path), spline, "IGES by pyiges")
    check_geometry(file, spline, "IGES")
    if job:
        check_data(file, spline, job, "IGES")


def check_obj(path: str, spline: Spline, _job: dict | None) -> None:
    """Parses the statements of the specification; rhino3dm then evaluates them."""
    with open(path, encoding="utf-8") as file:
        text = re.sub(r"\\\n", " ", file.read())
    vertices, body, knots, rational = [], None, {}, False
    for line in text.splitlines():
        word, *values = line.split()
        if word == "v":
            vertices.append([float(x) for x in values])
        elif word == "cstype":
            rational = values == ["rat", "bspline"]
            assert rational or values == ["bspline"]
        elif word == "deg":
            assert [int(x) for x in values] == spline.degrees
        elif word in ("curv", "surf"):
            body = (word, values)
        elif word == "parm":
            knots[values[0]] = [float(x) for x in values[1:]]
    word, values = body
    assert word == ("surf" if spline.is_surface else "curv")
    assert rational == (spline.weights is not None)
    for axis, name in enumerate("uv"[: len(spline.degrees)]):
        equal([float(x) for x in values[2 * axis : 2 * axis + 2]], spline.domain(axis), SAME, "OBJ domain")
        equal(knots[name], spline.knots[axis], SAME, "OBJ knots")
    indices = np.array([int(x) - 1 for x in values[2 * len(spline.degrees) :]])
    net = np.array(vertices)[indices]
    if spline.is_surface:
        rows, columns = spline.poles.shape[:2]
        net = net.reshape(columns, rows, -1).swapaxes(0, 1)
    tolerance = SAME if spline.exact else CONVERTED
    equal(net[..., :3], spline.poles, tolerance, "OBJ poles")
    if rational:
        equal(net[..., 3], spline.weights, tolerance, "OBJ weights")
    check_rhino(net[..., :3], spline)


def check_rhino(poles: np.ndarray, spline: Spline) -> None:
    """OpenNURBS omits the first and last knot, and has homogeneous control points."""
    if spline.magnitude > 1e9:
        return
    weights = np.ones(poles.shape[:-1]) if spline.weights is None else spline.weights
    lifted = np.concatenate([poles * weights[..., None], weights[..., None]], axis=-1)
    rational = spline.weights is not None
    if not spline.is_surface:
        curve = rhino3dm.NurbsCurve(3, rational, spline.degrees[0] + 1, len(poles))
        for i, pole in enumerate(lifted):
            curve.Points[i] = rhino3dm.Point4d(*map(float, pole))
        for i, knot in enumerate(spline.knots[0][1:-1]):
            curve.Knots[i] = float(knot)
        t = spline.parameters(0, 41)
        found = [[p.X, p.Y, p.Z] for p in (curve.PointAt(float(x)) for x in t)]
        equal(found, spline.evaluate(t), EVALUATED, "OBJ places by OpenNURBS")
        return
    rows, columns = poles.shape[:2]
    orders = [degree + 1 for degree in spline.degrees]
    surface = rhino3dm.NurbsSurface.Create(3, rational, *orders, rows, columns)
    for i in range(rows):
        for j in range(columns):
            surface.Points[(i, j)] = rhino3dm.Point4d(*map(float, lifted[i, j]))
    for knots, values in zip((surface.KnotsU, surface.KnotsV), spline.knots):
        for i, knot in enumerate(values[1:-1]):
            knots[i] = float(knot)
    u, v = spline.parameters(0, 17), spline.parameters(1, 13)
    places = [[surface.PointAt(float(s), float(t)) for t in v] for s in u]
    found = [[[p.X, p.Y, p.Z] for p in row] for row in places]
    equal(found, spline.evaluate(u, v), EVALUATED, "OBJ places by OpenNURBS")


def check_glb(path: str, spline: Spline, _job: dict | None) -> None:
    """Reads with pygltflib; then trimesh loads it like viewers, with the node's rotation."""
    document = pygltflib.GLTF2().load(path)
    (mesh,) = document.meshes
    (primitive,) = mesh.primitives
    blob = document.binary_blob()

    def numbers(index: int) -> np.ndarray:
        accessor = document.accessors[index]
        view = document.bufferViews[accessor.bufferView]
        kind = {pygltflib.FLOAT: np.float32, pygltflib.UNSIGNED_INT: np.uint32}[accessor.componentType]
        width = {"VEC3": 3, "SCALAR": 1}[accessor.type]
        start, count = view.byteOffset or 0, accessor.count * width
        return np.frombuffer(blob, kind, count, start).reshape(-1, width)

    positions = numbers(primitive.attributes.POSITION).astype(float)
    bounds = document.accessors[primitive.attributes.POSITION]
    equal(positions.min(axis=0), bounds.min, SAME, "glTF bounds")
    equal(positions.max(axis=0), bounds.max, SAME, "glTF bounds")
    x, y, z = document.nodes[0].translation
    places = positions + np.array([x, -z, y])
    # The first and the last vertex are the corners of the domain.
    ends = [np.array(spline.domain(axis)) for axis in range(len(spline.degrees))]
    corners = spline.evaluate(*ends).reshape(-1, 3)
    size = spline.extent
    for place, corner in ((places[0], corners[0]), (places[-1], corners[-1])):
        distance = np.linalg.norm(place - corner) / size
        assert distance < 2e-6, f"glTF: a corner is off by {distance:.3g} of the extent"
    indices = numbers(primitive.indices)
    scene = trimesh.load(path)
    (shape,) = scene.geometry.values()
    if spline.is_surface:
        check_mesh(places, numbers(primitive.attributes.NORMAL), indices, spline)
        assert len(shape.faces) == len(indices) // 3
    else:
        # Separate lines between consecutive vertices: some readers ignore strips or indices.
        assert primitive.mode == pygltflib.LINES
        ends = np.arange(len(places))
        equal(indices.reshape(-1, 2), np.stack([ends[:-1], ends[1:]], axis=1), SAME, "glTF lines")
        check_path(scene, shape, places, spline)
    # glTF has y upwards: (x, y, z) is shown at (x, z, −y).
    shown = scene.bounds
    turned = np.stack([places[:, 0], places[:, 2], -places[:, 1]], axis=1)
    offset = np.abs(shown - np.stack([turned.min(axis=0), turned.max(axis=0)])).max() / spline.magnitude
    assert offset < 1e-6, f"glTF: the scene is off by {offset:.3g}"


def check_path(scene: trimesh.Scene, shape: trimesh.path.Path3D, places, spline: Spline) -> None:
    """trimesh loads the curve as a path: one polyline through the samples, about as long as the curve."""
    assert not scene.is_empty and isinstance(shape, trimesh.path.Path3D), "glTF: no path in the scene"
    (line,) = shape.entities
    assert len(line.points) == len(places), f"glTF: {len(line.points)} of {len(places)} vertices"
    drawn = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    equal(shape.length, drawn, 1e-6, "glTF length by trimesh")
    # Chords are shorter than their arcs, by a fraction that is quadratic in their angle.
    corners = np.clip(spline.knots[0], *spline.domain(0))
    fine = spline.evaluate(np.union1d(spline.parameters(0, 20_001), corners))
    length = np.linalg.norm(np.diff(fine, axis=0), axis=1).sum()
    assert 0.99 * length <= shape.length <= (1 + 1e-6) * length, f"glTF: {shape.length} long, not {length}"


def check_stl(path: str, spline: Spline, _job: dict | None) -> None:
    """trimesh reads triangles with vertices on the surface, which close closed surfaces."""
    mesh = trimesh.load(path, process=False)
    with open(path, "rb") as file:
        count = int.from_bytes(file.read(84)[80:], "little")
    assert len(mesh.faces) == count > 0, f"STL: {len(mesh.faces)} of {count} triangles"
    size = spline.extent + 1e-7 * spline.magnitude / 2e-6
    rng = np.random.default_rng(2)
    for index in rng.choice(len(mesh.vertices), 20):
        distance = nearest(spline, np.array(mesh.vertices[index], dtype=float))[0]
        assert distance < 2e-6 * size, f"STL: a corner is {distance:.3g} off the surface"
    merged = mesh.copy()
    merged.merge_vertices()
    if all(spline.closed):
        assert merged.is_watertight, "STL: a closed surface has gaps"


def check_dxf(path: str, spline: Spline, job: dict | None) -> None:
    """ezdxf reads one polyline through points of the curve, or one mesh of points of the surface."""
    document = ezdxf.readfile(path)
    assert not document.audit().has_errors, "DXF: the audit finds errors"
    (entity,) = document.modelspace()
    assert entity.dxftype() == "POLYLINE"
    if spline.is_surface:
        assert entity.is_polygon_mesh
        assert [entity.is_m_closed, entity.is_n_closed] == spline.closed
        counts = (entity.dxf.m_count, entity.dxf.n_count)
        assert len(entity.vertices) == counts[0] * counts[1]
        places = np.array([tuple(vertex.dxf.location) for vertex in entity.vertices])
        corners = [places[0]] if any(spline.closed) else [places[0], places[-1]]
    else:
        assert entity.is_closed == spline.closed[0]
        assert not job or entity.is_2d_polyline == (len(job["curve"]["points"][0]) == 2)
        places = np.array([tuple(vertex.dxf.location) for vertex in entity.vertices])
        corners = [places[0]] if spline.closed[0] else [places[0], places[-1]]
        lines = np.vstack([places, places[:1]]) if spline.closed[0] else places
        drawn = np.linalg.norm(np.diff(lines, axis=0), axis=1).sum()
        knots = np.clip(spline.knots[0], *spline.domain(0))
        fine = spline.evaluate(np.union1d(spline.parameters(0, 20_001), knots))
        length = np.linalg.norm(np.diff(fine, axis=0), axis=1).sum()
        assert 0.99 * length <= drawn <= (1 + 1e-6) * length, f"DXF: {drawn} long, not {length}"
    ends = [np.array(spline.domain(axis)) for axis in range(len(spline.degrees))]
    expected = spline.evaluate(*ends).reshape(-1, 3)[[0, -1][: len(corners)]]
    equal(corners, expected, EVALUATED, "DXF corners")


def check_mesh(places, normals, indices, spline: Spline) -> None:
    lengths = np.linalg.norm(normals.astype(float), axis=1)
    equal(lengths, np.ones(len(lengths)), 1e-6, "glTF lengths of normals")
    triangles = indices.reshape(-1, 3)
    assert triangles.max() == len(places) - 1
    a, b, c = (places[triangles[:, i]] for i in range(3))
    areas = np.cross(b - a, c - a)
    cosines = (areas * normals[triangles[:, 0]]).sum(axis=1)
    wrong = float((cosines < 0).mean())
    assert wrong < 0.1, f"glTF: {100 * wrong:.1f} % of the triangles are seen from behind"
    # Every vertex is on the surface, and has its normal. Where surfaces are folded, several
    # parameters are near a point; where they are singular, there is no normal.
    rng = np.random.default_rng(1)
    angles = []
    for index in rng.choice(len(places), 60):
        distance, site = nearest(spline, places[index])
        assert distance < 1e-6 * spline.extent, f"glTF: a vertex is {distance:.3g} off the surface"
        exact = normal(spline, *site)
        if exact is not None:
            angles.append(np.degrees(np.arccos(np.clip(exact @ normals[index], -1, 1))))
    if min(spline.degrees) == 1:
        return  # at creases there are two normals
    worst = float(np.sort(angles)[-4])
    assert worst < 1.0, f"glTF: a normal is {worst:.1f} degrees wrong"
    worst_of["glTF degrees between normals"] = max(worst_of.get("glTF degrees between normals", 0.0), worst)


def normal(spline: Spline, u: float, v: float) -> np.ndarray | None:
    """The unit normal, from central differences."""
    partial = []
    for axis, t in enumerate((u, v)):
        low, high = spline.domain(axis)
        step = 1e-6 * (high - low)
        ends = np.clip([t - step, t + step], low, high)
        sites = [np.array([u]), np.array([v])]
        sites[axis] = ends
        places = spline.evaluate(*sites).reshape(2, 3)
        partial.append((places[1] - places[0]) / spline.extent / 1e-6)
    cross = np.cross(*partial)
    length = np.linalg.norm(cross)
    return cross / length if length > 1e-2 else None


def nearest(spline: Spline, place: np.ndarray) -> tuple[float, tuple[float, float]]:
    """The distance of a surface from a point, and its parameters: by least squares from the best
    minima on a grid."""
    grid = [spline.parameters(axis, 150) for axis in (0, 1)]
    distances = np.linalg.norm(spline.evaluate(*grid) - place, axis=2)
    minima = np.argwhere(distances == minimum_filter(distances, size=3, mode="nearest"))
    minima = sorted(minima.tolist(), key=lambda cell: distances[tuple(cell)])
    low, high = np.array([spline.domain(axis) for axis in (0, 1)]).T

    def difference(part):
        u, v = low + part * (high - low)
        return (spline.evaluate(np.array([u]), np.array([v])).reshape(3) - place) / spline.extent

    best = (np.inf, (0.0, 0.0))
    for cell in minima[:12]:
        start = np.array(cell) / 149
        found = least_squares(difference, start, bounds=(0, 1), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        u, v = low + found.x * (high - low)
        best = min(best, (float(np.linalg.norm(found.fun)) * spline.extent, (float(u), float(v))))
        if best[0] < 1e-7 * spline.extent:
            break
    return best


def check_svg(path: str, spline: Spline, job: dict | None) -> None:
    """Well-formed, within the page, and drawn by a renderer."""
    root = ElementTree.parse(path).getroot()
    space = "{http://www.w3.org/2000/svg}"
    assert root.tag == f"{space}svg"
    _, _, width, height = map(float, root.get("viewBox").split())
    assert width == 800
    circles = root.findall(f".//{space}circle[@class='data']")
    circles += root.findall(f".//{space}g[@class='data']/{space}circle")
    for circle in circles:
        x, y = float(circle.get("cx")), float(circle.get("cy"))
        assert 0 <= x <= width and 0 <= y <= height, "SVG: a data point is off the page"
    if job and (circles or count(job) <= 100):
        assert len(circles) == 1 + count(job), "SVG: not all data points"
    legend = root.find(f"{space}g[@class='legend']")
    assert legend is not None or not spline.error, "SVG: no legend of distances"
    curve = root.find(f"{space}svg/{space}path[@class='curve']")
    assert (curve is not None) or spline.is_surface
    if job and job.get("name"):
        title = root.find(f"{space}title").text
        assert title == re.sub(r"[\x00-\x1f]", " ", job["name"]), f"SVG: the title is {title!r}"
    png = cairosvg.svg2png(url=path, write_to=os.environ.get("PNG_FOLDER") and os.path.join(
        os.environ["PNG_FOLDER"], os.path.basename(path).replace(".svg", ".png")))
    assert png is None or png.startswith(b"\x89PNG")


def count(job: dict) -> int:
    """The number of data points."""
    if "curve" in job:
        return len(job["curve"]["points"])
    return sum(point is not None for row in job["surface"]["points"] for point in row)


def check_csv(path: str, spline: Spline, _job: dict | None) -> None:
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    numbers = np.array([[float(x) for x in row] for row in rows])
    parameters = 2 if spline.is_surface else 1
    assert header[:parameters] == (["u", "v"] if spline.is_surface else ["t"])
    assert header[parameters:] == ["x", "y", "z"][: len(header) - parameters]
    sites = [np.unique(numbers[:, axis]) for axis in range(parameters)]
    for axis, values in enumerate(sites):
        equal([values[0], values[-1]], spline.domain(axis), SAME, "CSV domain")
    expected = spline.evaluate(*sites).reshape(-1, 3)[:, : len(header) - parameters]
    equal(numbers[:, parameters:], expected, EVALUATED, "CSV samples")


CHECKS = {
    ".step": check_step,
    ".stp": check_step,
    ".igs": check_iges,
    ".iges": check_iges,
    ".obj": check_obj,
    ".glb": check_glb,
    ".stl": check_stl,
    ".dxf": check_dxf,
    ".svg": check_svg,
    ".csv": check_csv,
}


def check(result: str, files: list[str], job_path: str | None) -> list[str]:
    """The failures, one line for each."""
    spline = load(result)
    job = None
    if job_path:
        with open(job_path, encoding="utf-8") as file:
            job = json.load(file)
    failures = []
    for path in files:
        try:
            CHECKS[os.path.splitext(path)[1]](path, spline, job)
        except AssertionError as error:
            failures.append(f"{path}: {error}")
    return failures


def cases(folder: str):
    for result in sorted(glob.glob(os.path.join(folder, "*.result.json"))):
        base = result.removesuffix(".result.json")
        job = f"{base}.job.json"
        files = [base + end for end in CHECKS if os.path.exists(base + end)]
        yield result, files, job if os.path.exists(job) else None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("result", nargs="?")
    parser.add_argument("files", nargs="*")
    parser.add_argument("--job")
    parser.add_argument("--all", metavar="FOLDER")
    given = parser.parse_args()
    todo = list(cases(given.all)) if given.all else [(given.result, given.files, given.job)]
    failures = [failure for case in todo for failure in check(*case)]
    files = sum(len(files) for _, files, _ in todo)
    for what, worst in sorted(worst_of.items()):
        print(f"{worst:9.2g}  {what}")
    print(f"{files} files of {len(todo)} results, {len(failures)} failures")
    for failure in failures:
        print("FAILED", failure)
    return 1 if failures or not files else 0


if __name__ == "__main__":
    sys.exit(main())

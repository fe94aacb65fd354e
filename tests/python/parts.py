"""Fits files of several parts, and reads the exported files with other software.

    parts.py PROGRAM            # such as target/debug/piad

Curves go through `piad fit`, several surfaces through `POST /v1/batch` of a server. Exact formats are evaluated at the
parameters of the data and compared with the data; the samples of the others are compared with the curves of the JSON
result, which are evaluated by scipy. Needs the packages of requirements.txt.
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import urllib.request
import warnings

import cairosvg
import ezdxf
import numpy as np
import pyogrio
import rhino3dm
import shapely
import svgpathtools
import trimesh
from OCP.BRep import BRep_Tool
from OCP.TopAbs import TopAbs_EDGE
from OCP.TopoDS import TopoDS
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

import cad
from over_http import server

# `piad fit` fits to a millionth of the diagonal of the data; the rest is rounding.
TOLERANCE = 1.001e-6
# The deviation of samples from their curve, relative to its size: the error of chords between 4,001
# points.
ON_THE_CURVE = 5e-7
# The rounding of nine decimals of a degree, in metres.
DEGREES = 2e-4
COUNT = 1000
ORIGIN = (11.5, 48.1)
KINDS = {"ply": "application/x-ply", "stl": "model/stl", "glb": "model/gltf-binary"}


class Part:
    """A fitted curve of the JSON result with its data."""

    def __init__(self, item: dict, data: np.ndarray):
        curve = item["curve"]
        assert item["state"] == "converged", item
        self.name, self.data = item.get("name"), data
        self.parameters, self.degree = np.array(curve["parameters"]), curve["degree"]
        self.knots = np.array(curve["knots"])
        self.spline = BSpline(self.knots, np.array(curve["control_points"]), self.degree)
        self.size = float(np.linalg.norm(np.ptp(data, axis=0)))
        self.domain = (self.knots[self.degree], self.knots[-self.degree - 1])
        self.dense = self.spline(np.linspace(*self.domain, 4001))

    def check_exact(self, points, what: str) -> None:
        """Points of a curve that was read, at the parameters of the data."""
        points = np.asarray(points, dtype=float)[:, : self.data.shape[1]]
        worst = np.linalg.norm(points - self.data, axis=1).max() / self.size
        assert worst <= TOLERANCE, f"{what}: {self.name} is {worst:.3g} of its size from its data"
        note(f"{what}: from the data, of their size", worst)

    def check_samples(self, points, what: str, slack: float = 0.0) -> None:
        """Samples that were read are on the curve, from end to end, and their polyline is near the
        data."""
        points = np.asarray(points, dtype=float)[:, : self.data.shape[1]]
        ends = np.linalg.norm(points[[0, -1]] - self.dense[[0, -1]], axis=1).max()
        off = distances(points, self.dense).max()
        apart = distances(self.data, points).max() / self.size
        allowed = ON_THE_CURVE * self.size + slack
        assert max(off, ends) <= allowed, f"{what}: samples of {self.name} are {max(off, ends):.3g} off, allowed {allowed:.3g}"
        assert apart <= 2e-3, f"{what}: the line of {self.name} is {apart:.3g} of its size from its data"
        note(f"{what}: samples from the curve, of its size", off / self.size)


# The largest deviation of each kind.
worst_of: dict[str, float] = {}


def note(what: str, value: float) -> None:
    worst_of[what] = max(worst_of.get(what, 0.0), float(value))


def distances(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distances of points from a polyline: from the segments at its nearest vertex."""
    nearest = cKDTree(line).query(points)[1]
    best = np.full(len(points), np.inf)
    for first in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(line) - 2)):
        start, step = line[first], line[first + 1] - line[first]
        part = ((points - start) * step).sum(axis=1) / np.maximum((step * step).sum(axis=1), 1e-300)
        foot = start + np.clip(part, 0, 1)[:, None] * step
        best = np.minimum(best, np.linalg.norm(points - foot, axis=1))
    return best


def waves(count: int, dimension: int) -> list[np.ndarray]:
    """Open curves of 12 and 13 points (as many in each would be a surface), each with a different
    shape and position."""
    curves = []
    for k in range(count):
        t = np.linspace(0, 1, 12 + k % 2)
        x = 10 * (k % 40) + 8 * t
        y = 10 * (k // 40) + (1 + k % 7 / 3) * np.sin((2 + k % 5) * t + k)
        z = 0.1 * k + t * t
        curves.append(np.stack([x, y, z][:dimension], axis=1))
    return curves


def fit(program: str, given: str, *outputs: str, flags: tuple[str, ...] = ()) -> None:
    command = [program, "fit", given, "--quiet", *flags]
    for output in outputs:
        command += ["-o", output]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 0, (command, done.stderr)


def fitted(path: str, data: list[np.ndarray]) -> list[Part]:
    with open(path, encoding="utf-8") as file:
        items = json.load(file)["items"]
    return [Part(item, points) for item, points in zip(items, data, strict=True)]


def drawing(path: str, version: str) -> list:
    document = ezdxf.readfile(path)
    audit = document.audit()
    assert not audit.has_errors and not audit.has_fixes, (path, audit.errors[:3], audit.fixes[:3])
    assert document.dxfversion == version, document.dxfversion
    return list(document.modelspace())


def check_r12(path: str, parts: list[Part]) -> None:
    entities = drawing(path, "AC1009")
    assert len({entity.dxf.layer for entity in entities}) == len(parts), "R12: layers are not unique"
    for entity, part in zip(entities, parts, strict=True):
        assert entity.dxftype() == "POLYLINE"
        part.check_samples([tuple(vertex.dxf.location) for vertex in entity.vertices], "DXF R12")


def check_r2000(path: str, parts: list[Part]) -> None:
    for entity, part in zip(drawing(path, "AC1015"), parts, strict=True):
        assert entity.dxftype() == "SPLINE"
        tool = entity.construction_tool()
        part.check_exact([tuple(tool.point(float(t))) for t in part.parameters], "DXF R2000")


def check_cad(path: str, parts: list[Part], what: str) -> None:
    """OpenCASCADE has an edge for each part, in their order."""
    file = cad.CadFile(path, roots=None)
    edges = cad.explore(file.shape, TopAbs_EDGE)
    assert len(edges) == len(parts), f"{what}: {len(edges)} edges"
    assert file.is_valid(), f"{what}: not valid"
    for edge, part in zip(edges, parts):
        geometry = BRep_Tool.Curve_s(TopoDS.Edge_s(edge), 0.0, 0.0)
        part.check_exact(cad.evaluate(geometry, part.parameters), what)


def check_svg(path: str, parts: list[Part]) -> None:
    """Each path has a cubic for each span of the knots; y points downwards."""
    paths, attributes = svgpathtools.svg2paths(path)
    assert len(attributes) == len(parts), f"SVG: {len(attributes)} paths"
    for curve, part in zip(paths, parts):
        knots = np.unique(np.clip(part.knots, *part.domain))
        assert len(curve) == len(knots) - 1, "SVG: not a segment for each span"
        spans = np.clip(np.searchsorted(knots, part.parameters, side="right") - 1, 0, len(curve) - 1)
        inside = (part.parameters - knots[spans]) / (knots[spans + 1] - knots[spans])
        places = [curve[int(span)].point(t) for span, t in zip(spans, inside)]
        part.check_exact([(place.real, -place.imag) for place in places], "SVG")
    assert cairosvg.svg2png(url=path).startswith(b"\x89PNG")


def check_obj(path: str, parts: list[Part]) -> None:
    """The statements of the file, evaluated by OpenNURBS, which omits the first and last knot."""
    with open(path, encoding="utf-8") as file:
        lines = [line.split() for line in file.read().replace("\\\n", " ").splitlines() if line]
    vertices = [[float(x) for x in words[1:]] for words in lines if words[0] == "v"]
    curves = [[int(x) - 1 for x in words[3:]] for words in lines if words[0] == "curv"]
    knots = [[float(x) for x in words[2:]] for words in lines if words[0] == "parm"]
    for indices, knots, part in zip(curves, knots, parts, strict=True):
        curve = rhino3dm.NurbsCurve(3, False, part.degree + 1, len(indices))
        for i, index in enumerate(indices):
            curve.Points[i] = rhino3dm.Point4d(*vertices[index], 1.0)
        for i, knot in enumerate(knots[1:-1]):
            curve.Knots[i] = knot
        places = [curve.PointAt(float(t)) for t in part.parameters]
        part.check_exact([(p.X, p.Y, p.Z) for p in places], "OBJ")


def check_glb(path: str, parts: list[Part]) -> None:
    """trimesh has a path for each part, turned so that y is upwards."""
    scene = trimesh.load_scene(path)
    assert len(scene.geometry) == len(parts), f"glTF: {len(scene.geometry)} paths"
    # Matched by their first points: nodes are named like parts, but trimesh changes equal names.
    turned = {}
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        (line,) = scene.geometry[name].entities
        x, y, z = trimesh.transform_points(scene.geometry[name].vertices[line.points], matrix).T
        turned[node] = np.stack([x, -z, y], axis=1)
    tree = cKDTree([part.dense[0] for part in parts])
    found = tree.query([points[0][: parts[0].data.shape[1]] for points in turned.values()])[1]
    assert sorted(found) == list(range(len(parts))), "glTF: some parts are missing"
    magnitude = max(np.abs(part.dense).max() for part in parts)
    for index, points in zip(found, turned.values()):
        parts[index].check_samples(points, "glTF", 3e-7 * magnitude)


def check_gdal(path: str, layer: str, parts: list[Part], origin: bool) -> None:
    """GDAL reads a line for each part, with its name; degrees are compared in metres in the plane of the data."""
    driver = pyogrio.detect_write_driver(path)
    _, _, geometry, fields = pyogrio.raw.read(path, layer=layer, columns=["name"])
    for shape, name, part in zip(shapely.from_wkb(geometry), fields[0], parts, strict=True):
        assert name == part.name, f"{driver}: the name is {name!r}"
        points = shapely.get_coordinates(shape)
        points = metres(points) if origin else points
        part.check_samples(points, driver, DEGREES if origin else 0.0)


def metres(degrees: np.ndarray) -> np.ndarray:
    """Metres east and north of the origin in its tangent plane, on the ellipsoid of WGS 84."""
    longitude, latitude = np.radians(degrees).T
    of_origin, at = np.radians(ORIGIN)
    a, flattening = 6378137.0, 1 / 298.257223563
    e2 = flattening * (2 - flattening)

    def place(longitude, latitude):
        n = a / np.sqrt(1 - e2 * np.sin(latitude) ** 2)
        flat = n * np.cos(latitude)
        return flat * np.cos(longitude), flat * np.sin(longitude), n * (1 - e2) * np.sin(latitude)

    x, y, z = (value - base for value, base in zip(place(longitude, latitude), place(of_origin, at)))
    east = -np.sin(of_origin) * x + np.cos(of_origin) * y
    outwards = np.cos(of_origin) * x + np.sin(of_origin) * y
    return np.stack([east, -np.sin(at) * outwards + np.cos(at) * z], axis=1)


def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.sin(0.7 * x) * np.cos(0.5 * y)


def normals(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    gradient = [-0.7 * np.cos(0.7 * x) * np.cos(0.5 * y), 0.5 * np.sin(0.7 * x) * np.sin(0.5 * y), np.ones_like(x)]
    return np.stack(gradient, axis=1) / np.linalg.norm(gradient, axis=0)[:, None]


def sheet(start: float) -> np.ndarray:
    """21 × 25 points of `height` over a square of 4 × 4."""
    x, y = np.meshgrid(np.linspace(start, start + 4, 21), np.linspace(-2, 2, 25), indexing="ij")
    return np.stack([x, y, height(x, y)], axis=2)


def check_sheet(mesh: trimesh.Trimesh, start: float, single: bool, what: str) -> None:
    """The mesh of a fitted sheet: its vertices are on the function, and it covers the square."""
    x, y, z = mesh.vertices.T
    # Splines deviate from the function between the points; numbers of STL and glTF have 24 bits.
    off = np.abs(z - height(x, y)).max()
    assert off < 2e-4, f"{what}: vertices are {off:.3g} off"
    note(f"{what}: vertices from the function", off)
    bounds = np.abs(mesh.bounds[:, :2] - [[start, -2], [start + 4, 2]]).max()
    assert bounds < (2e-5 if single else 1e-5), f"{what}: bounds are {bounds:.3g} off"
    flat = np.abs(np.cross(*np.diff(mesh.triangles, axis=1).swapaxes(0, 1))[:, 2]).sum() / 2
    assert abs(flat - 16) < 1e-3, f"{what}: it covers {flat} of 16"
    cosines = (mesh.face_normals * normals(*mesh.triangles_center[:, :2].T)).sum(axis=1)
    assert cosines.min() > 0.99 or cosines.max() < -0.99, f"{what}: normals of faces"


def check_ply_normals(path: str) -> None:
    """The normals of the file itself, by trimesh."""
    mesh = trimesh.load(path, process=False)
    cosines = np.abs((mesh.vertex_normals * normals(*mesh.vertices[:, :2].T)).sum(axis=1))
    assert cosines.min() > 0.999, f"PLY: normals {cosines.min()}"


def check_surface(program: str, folder: str) -> None:
    """One surface by the command, several by a batch."""
    given = os.path.join(folder, "sheet.csv")
    rows = ["\n".join(",".join(map(repr, point)) for point in row) for row in sheet(0.0).tolist()]
    with open(given, "w", encoding="utf-8") as file:
        file.write("\n\n".join(rows) + "\n")
    fit(program, given, *(os.path.join(folder, f"sheet.{ending}") for ending in ("ply", "stl")))
    check_sheet(trimesh.load(os.path.join(folder, "sheet.ply"), process=False), 0.0, False, "PLY")
    check_sheet(trimesh.load(os.path.join(folder, "sheet.stl")), 0.0, True, "STL")
    check_ply_normals(os.path.join(folder, "sheet.ply"))
    starts = [0.0, 10.0, 20.0]
    items = [{"name": f"sheet {start}", "surface": {"points": sheet(start).tolist()}} for start in starts]
    body = json.dumps({"defaults": {"stop": {"relative_tolerance": 1e-6}}, "items": items}).encode()
    with server(program) as base:
        for ending, kind in KINDS.items():
            headers = {"Content-Type": "application/json", "Accept": kind}
            request = urllib.request.Request(f"{base}/v1/batch", body, headers)
            path = os.path.join(folder, f"sheets.{ending}")
            with urllib.request.urlopen(request) as answer, open(path, "wb") as file:
                file.write(answer.read())
            merged = trimesh.load_scene(path).to_geometry()
            if ending == "glb":
                x, y, z = merged.vertices.T
                merged.vertices = np.stack([x, -z, y], axis=1)
            if ending == "ply":
                check_comments(path, items, starts)
            near = np.abs(merged.triangles_center[:, :1] - starts - 2) < 3
            assert near.any(axis=1).all(), f"{ending}: triangles beside all parts"
            for start, faces in zip(starts, near.T, strict=True):
                mesh = trimesh.Trimesh(merged.vertices, merged.faces[faces], process=False)
                mesh.remove_unreferenced_vertices()
                check_sheet(mesh, start, ending != "ply", f"{ending.upper()} of several")


def check_comments(path: str, items: list[dict], starts: list[float]) -> None:
    """Comments of a PLY file say which vertices are those of a part."""
    with open(path, "rb") as file:
        header = file.read(4096).split(b"end_header")[0].decode()
    vertices = trimesh.load(path, process=False).vertices
    found = re.findall(r"^comment vertices (\d+) to (\d+): (.*)$", header, re.MULTILINE)
    for (first, last, title), item, start in zip(found, items, starts, strict=True):
        x = vertices[int(first) : int(last) + 1, 0]
        assert item["name"] in title, f"PLY: the title is {title!r}"
        assert abs(x.min() - start) < 1e-5 and abs(x.max() - start - 4) < 1e-5, f"PLY: vertices of {title}"


def check_table(program: str, folder: str, dimension: int) -> None:
    """A table with a thousand curves between blank lines."""
    data = waves(COUNT, dimension)
    base = os.path.join(folder, f"table{dimension}")
    with open(f"{base}.csv", "w", encoding="utf-8") as file:
        file.write("xyz"[:dimension].replace("", ",").strip(",") + "\n")
        file.write("\n\n".join("\n".join(",".join(map(repr, point)) for point in curve.tolist()) for curve in data))
    exact = ["json", "step", "igs", "obj", *(["svg", "geojson"] if dimension == 2 else [])]
    fit(program, f"{base}.csv", *(f"{base}.{ending}" for ending in [*exact, "glb", "dxf"]))
    fit(program, f"{base}.csv", f"{base}-2000.dxf", flags=("--dxf", "r2000"))
    parts = fitted(f"{base}.json", data)
    for part, number in zip(parts, range(1, COUNT + 1)):
        part.name = part.name or f"part {number}"
    check_r12(f"{base}.dxf", parts)
    check_r2000(f"{base}-2000.dxf", parts)
    check_cad(f"{base}.step", parts, "STEP")
    check_cad(f"{base}.igs", parts, "IGES")
    check_obj(f"{base}.obj", parts)
    check_glb(f"{base}.glb", parts)
    if dimension == 2:
        check_svg(f"{base}.svg", parts)
        check_gdal(f"{base}.geojson", "table2", parts, origin=False)


def check_contours(program: str, folder: str) -> None:
    """Three lines of a map, two of which have the same name."""
    names = ["Höhe 40", "Höhe 40", "<&> \"C\""]
    degrees = [np.asarray(ORIGIN) + 1e-3 * (curve - waves(1, 2)[0][0]) for curve in waves(3, 2)]
    features = [
        {"type": "Feature", "properties": {"name": name}, "geometry": {"type": "LineString", "coordinates": line.tolist()}}
        for name, line in zip(names, degrees)
    ]
    base = os.path.join(folder, "contours")
    with open(f"{base}.geojson", "w", encoding="utf-8") as file:
        json.dump({"type": "FeatureCollection", "features": features}, file)
    out = os.path.join(folder, "fitted")
    fit(program, f"{base}.geojson", *(f"{out}.{ending}" for ending in ("json", "geojson", "gpx", "dxf", "step", "svg")))
    parts = fitted(f"{out}.json", [metres(line) for line in degrees])
    assert [part.name for part in parts] == [names[0], f"{names[1]} 2", names[2]]
    check_gdal(f"{out}.geojson", "fitted", parts, origin=True)
    check_gdal(f"{out}.gpx", "tracks", parts, origin=True)
    check_r12(f"{out}.dxf", parts)
    check_cad(f"{out}.step", parts, "STEP")
    check_svg(f"{out}.svg", parts)


def main() -> None:
    [program] = sys.argv[1:]
    warnings.filterwarnings("ignore", module="pyogrio")
    with tempfile.TemporaryDirectory() as folder:
        check_contours(program, folder)
        check_table(program, folder, 2)
        check_table(program, folder, 3)
        check_surface(program, folder)
    for what, worst in sorted(worst_of.items()):
        print(f"{worst:9.2g}  {what}")
    print(f"{2 * COUNT + 3} curves and 4 surfaces were read back")


if __name__ == "__main__":
    main()

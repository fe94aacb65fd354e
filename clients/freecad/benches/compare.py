"""Compares the workbench with FreeCAD's approxSurface on three point clouds: `clients/freecad/run
compare`.

Each measurement runs in its own FreeCAD process, so that it can be ended: `PIAD_CASE` selects it.
"""

import json
import math
import os
import random
import subprocess
import sys
import tempfile
import time

import FreeCAD as App
import matplotlib.cbook
import Mesh
import numpy
import Points
from scipy.spatial import cKDTree

from freecad.piad_workbench import fitting, points, server, shape
from freecad.piad_workbench.settings import defaults

# Time limit for one surface, in seconds.
LIMIT = 60
POLES = (8, 12, 16, 24, 32, 48, 60)


def sphere():
    """10,000 points of a spherical patch with a radius of 50 mm, with noise of 0.02 mm as of a
    scanner."""
    rng = random.Random(1)
    values = []
    for _ in range(10000):
        a, b, radius = rng.uniform(-0.6, 0.6), rng.uniform(-0.6, 0.6), rng.gauss(50, 0.02)
        x, y = math.sin(a), math.sin(b)
        values.append((radius * x, radius * y, radius * math.sqrt(1 - x * x - y * y)))
    return cloud(values), 0.1


def elevations():
    """The 138,632 elevations of matplotlib's example, in metres: 90 to 74 m apart, 236 to 1076 m high."""
    with numpy.load(matplotlib.cbook.get_sample_data("jacksboro_fault_dem.npz", asfileobj=False)) as dem:
        heights = dem["elevation"]
    rows, columns = heights.shape
    return cloud([(74.0 * j, 92.0 * i, float(heights[i, j])) for i in range(rows) for j in range(columns)]), 50.0


def blade():
    """The 2,501 vertices of a mesh of the suction side of a twisted blade: 120 mm high, 40 to 24 mm
    wide."""
    rows, columns = 41, 61
    corners = [[_blade(i / (columns - 1), j / (rows - 1)) for i in range(columns)] for j in range(rows)]
    facets = []
    for below, above in zip(corners, corners[1:]):
        for i in range(columns - 1):
            facets += [below[i], below[i + 1], above[i], above[i], below[i + 1], above[i + 1]]
    obj = App.newDocument().addObject("Mesh::Feature", "Blade")
    obj.Mesh = Mesh.Mesh([App.Vector(*corner) for corner in facets])
    return obj, 0.05


def _blade(along, up):
    """A NACA section with 10 % thickness and a curved mean line, dense at both ends."""
    x = (1 - math.cos(math.pi * along)) / 2
    y = 0.5 * (0.2969 * math.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4) + 0.3 * x * (1 - x)
    chord, twist = 40 * (1 - 0.4 * up), math.radians(20 + 35 * up)
    x, y = (x - 0.4) * chord, y * chord
    return x * math.cos(twist) - y * math.sin(twist), x * math.sin(twist) + y * math.cos(twist), 120 * up


def cloud(values):
    obj = App.newDocument().addObject("Points::Feature", "Cloud")
    obj.Points = Points.Points([App.Vector(*value) for value in values])
    return obj


CLOUDS = {"sphere patch": sphere, "elevation model": elevations, "blade": blade}


def by_piad(obj, tolerance):
    """As the panel does with the default settings."""
    client = server.client()
    client.capabilities()
    started = time.monotonic()
    given = points.read_surface([(obj, ("",))])
    settings = defaults(given).with_value("tolerance", tolerance)
    first = None
    for update in fitting.Follower(client).updates(given, settings):
        surface = shape.part_surface(update.geometry)
        first = first or time.monotonic() - started
    return surface, first, time.monotonic() - started


def by_freecad(obj, u, v):
    import ReverseEngineering

    started = time.monotonic()
    values = [tuple(p) for p in obj.Mesh.Topology[0]] if hasattr(obj, "Mesh") else obj.Points
    surface = ReverseEngineering.approxSurface(Points=values, NbUPoles=u, NbVPoles=v)
    seconds = time.monotonic() - started
    return surface, seconds, seconds


def farthest(surface, obj):
    """The largest distance of all points from the nearest points of the surface.

    Newton's method from the nearest of 300 × 300 samples: if it misses the nearest point, the
    distance is too large, never too small.
    """
    u0, u1, v0, v1 = surface.bounds()
    places = [(u, v) for u in numpy.linspace(u0, u1, 300) for v in numpy.linspace(v0, v1, 300)]
    samples = cKDTree([tuple(surface.value(*place)) for place in places])
    values = obj.Mesh.Topology[0] if hasattr(obj, "Mesh") else obj.Points.Points
    _, nearest = samples.query([tuple(p) for p in values])
    return max(_distance(surface, p, *places[i]) for p, i in zip(values, nearest))


def _distance(surface, point, u, v):
    u0, u1, v0, v1 = surface.bounds()
    rest = point - surface.value(u, v)
    for _ in range(8):
        a, b = surface.getDN(u, v, 1, 0), surface.getDN(u, v, 0, 1)
        aa, ab, bb, ar, br = a.dot(a), a.dot(b), b.dot(b), a.dot(rest), b.dot(rest)
        determinant = aa * bb - ab * ab
        if determinant <= 0:
            break
        u_next = min(max(u + (bb * ar - ab * br) / determinant, u0), u1)
        v_next = min(max(v + (aa * br - ab * ar) / determinant, v0), v1)
        rest_next = point - surface.value(u_next, v_next)
        if rest_next.Length >= rest.Length * (1 - 1e-6):
            break
        u, v, rest = u_next, v_next, rest_next
    return rest.Length


def measure(case):
    obj, tolerance = CLOUDS[case["cloud"]]()
    if "poles" in case:
        surface, first, end = by_freecad(obj, *case["poles"])
    else:
        surface, first, end = by_piad(obj, tolerance)
    poles = surface.NbUPoles, surface.NbVPoles
    return {"first": first, "end": end, "poles": poles, "farthest": farthest(surface, obj), "tolerance": tolerance}


def apart(**case):
    """A measurement in a separate FreeCAD process; None if it takes too long or fails."""
    with tempfile.TemporaryDirectory() as folder:
        result = os.path.join(folder, "result")
        environment = {**os.environ, "PIAD_CASE": json.dumps(case), "PIAD_RESULT": result}
        try:
            # Measuring distances takes longer than the surface.
            subprocess.run(["freecadcmd", __file__], env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, timeout=3 * LIMIT)
            with open(result) as file:
                return json.load(file)
        except (subprocess.TimeoutExpired, FileNotFoundError):
            return None


def row(cloud_, what, it):
    if it is None:
        return f"| {cloud_} | {what} | – | – | – | – |"
    u, v = it["poles"]
    mark = "" if it["farthest"] <= it["tolerance"] else " (outside)"
    return f"| {cloud_} | {what} | {it['first']:.2f} s | {it['end']:.2f} s | {u} × {v} = {u * v} | {it['farthest']:.3g}{mark} |"


def table():
    print("\n| cloud | | first | end | control points | largest distance |\n|---|---|---|---|---|---|", flush=True)
    for name in CLOUDS:
        ours = apart(cloud=name)
        title = f"{name}, within {ours['tolerance']:g}"
        print(row(title, "piad", ours), flush=True)
        print(row("", "approxSurface, as many", apart(cloud=name, poles=ours["poles"])), flush=True)
        for n in POLES:
            theirs = apart(cloud=name, poles=(n, n))
            if theirs is None or theirs["end"] > LIMIT or theirs["farthest"] <= theirs["tolerance"]:
                break
        print(row("", f"approxSurface, {n} × {n}", theirs), flush=True)


if "PIAD_CASE" in os.environ:
    App.ParamGet(server.PREFERENCES).SetString("Program", os.environ["PIAD_PROGRAM"])
    done = measure(json.loads(os.environ["PIAD_CASE"]))
    with open(os.environ["PIAD_RESULT"], "w") as out:
        json.dump(done, out)
    server._OWN.stop()
else:
    table()
sys.stdout.flush()
os._exit(0)

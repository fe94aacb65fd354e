"""FreeCAD macro: a B-spline through the points of the selected wire or sketch, or through a helix.

Install the workbench (clients/freecad/README.md), which brings the client, or the client alone into
FreeCAD's Python (`pip install ./clients/python`). Start a server, put this file into the macro folder
and run it. The spline appears in the active document. Without a window: `freecadcmd freecad_fit.py`.
"""

import math

import FreeCAD as App
import FreeCADGui as Gui
import Part

import piad

SERVER = "http://127.0.0.1:8080"


def data_points():
    """The vertices of the selection, in order, in millimetres."""
    if App.GuiUp:
        points = [v.Point for part in Gui.Selection.getSelection() for v in part.Shape.OrderedVertexes]
        if points:
            return [[p.x, p.y, p.z] for p in points]
    return [[20 * math.cos(0.5 * i), 20 * math.sin(0.5 * i), 2 * i] for i in range(26)]


def spline_of(curve):
    """A Part.BSplineCurve: distinct knots with multiplicities, and weights."""
    curve = curve.as_bspline()
    knots = sorted(set(curve.knots))
    multiplicities = [curve.knots.count(knot) for knot in knots]
    poles = [App.Vector(*map(float, point)) for point in curve.control_points]
    weights = [1.0] * len(poles) if curve.weights is None else [float(w) for w in curve.weights]
    spline = Part.BSplineCurve()
    spline.buildFromPolesMultsKnots(poles, multiplicities, knots, False, curve.degree, weights)
    return spline


def main():
    with piad.Client(SERVER) as client:
        result = client.fit(data_points(), tolerance=1e-6, name="FreeCAD")
    document = App.ActiveDocument or App.newDocument()
    shape = spline_of(result.curve).toShape()
    Part.show(shape)
    document.recompute()
    print(f"{result.state}: {len(result.curve.control_points)} control points, {shape.Length:.3f} mm long")


main()

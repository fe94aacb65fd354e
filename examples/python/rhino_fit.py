#! python 3
"""Rhino 8 and Grasshopper script: a NURBS curve through picked points, or through those of the
Grasshopper input `points`; the output is `curve`.

Install the client into Rhino's Python 3 (`pip install ./clients/python` with the python in
~/.rhinocode), start a server, and run this in the ScriptEditor or in a Python 3 component.
"""

import Rhino

import piad

SERVER = "http://127.0.0.1:8080"


def curve_of(fitted):
    """A Rhino.Geometry.NurbsCurve, which omits the first and last knot."""
    fitted = fitted.as_bspline()
    count = len(fitted.control_points)
    made = Rhino.Geometry.NurbsCurve(3, fitted.weights is not None, fitted.degree + 1, count)
    for i, point in enumerate(fitted.control_points):
        weight = 1.0 if fitted.weights is None else float(fitted.weights[i])
        made.Points.SetPoint(i, Rhino.Geometry.Point3d(*map(float, point)), weight)
    for i, knot in enumerate(fitted.knots[1:-1]):
        made.Knots[i] = knot
    return made


def fit(data):
    with piad.Client(SERVER) as client:
        return curve_of(client.fit([[p.X, p.Y, p.Z] for p in data], tolerance=1e-6).curve)


if "points" in globals():  # a Grasshopper component
    curve = fit(points)  # noqa: F821
else:
    import rhinoscriptsyntax as rs
    import scriptcontext as sc

    picked = rs.GetPoints(draw_lines=True, message1="Points of the curve")
    if picked:
        sc.doc.Objects.AddCurve(fit(picked))
        sc.doc.Views.Redraw()

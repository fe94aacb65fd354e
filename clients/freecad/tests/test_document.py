"""The object in a document: stored properties, and refitting."""

import os
import tempfile

import FreeCAD as App
import FreeCADGui as Gui
import Part

from freecad.piad_workbench import feature, server
from helpers import WorkbenchTest, button, dome, preferences, turn, until, wave


class Objects(WorkbenchTest):
    def fitted(self, command="Piad_FitCurve", source=None):
        self.source = source or self.polygon(wave())
        panel = self.open(command, self.source)
        until(lambda: panel._ended, what=panel.status.text())
        button("OK").click()
        turn()
        return self.document.Objects[-1]

    def without_server(self):
        server._OWN.stop()
        preferences(Server="http://127.0.0.1:9")

    def test_points_that_change_are_fitted_again(self):
        obj = self.fitted()
        moved = [(x, y + 3 * x / 100, z) for x, y, z in wave()]
        self.source.Shape = Part.makePolygon([App.Vector(*p) for p in moved])
        self.document.recompute()
        self.assertNear(obj.Shape, moved, 0.1 * (1 + 1e-9))
        self.assertEqual(obj.Status, "converged")

    def test_points_of_a_sketch_that_is_edited(self):
        sketch = self.document.addObject("Sketcher::SketchObject", "Sketch")
        corners = [App.Vector(10 * i, i % 3, 0) for i in range(8)]
        for a, b in zip(corners, corners[1:]):
            sketch.addGeometry(Part.LineSegment(a, b))
        self.document.recompute()
        obj = self.fitted(source=sketch)
        sketch.movePoint(0, 1, App.Vector(0, 7, 0))
        self.document.recompute()
        self.assertNear(obj.Shape, [(0, 7, 0), (70, 1, 0)], 1e-6)

    def test_settings_that_change_are_fitted_again(self):
        obj = self.fitted()
        before = obj.Shape.Edges[0].Curve.NbPoles
        obj.Tolerance = 0.001
        self.document.recompute()
        self.assertGreater(obj.Shape.Edges[0].Curve.NbPoles, before)
        self.assertNear(obj.Shape, wave(), 0.001 * (1 + 1e-6))

    def test_opens_without_a_server(self):
        obj = self.fitted("Piad_FitSurface", self.cloud(dome(500)))
        obj.ViewObject.ShowErrors = True
        poles = [tuple(p) for row in obj.Shape.Faces[0].Surface.getPoles() for p in row]
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "fit.FCStd")
            self.document.saveAs(path)
            App.closeDocument(self.document.Name)
            self.without_server()
            self.document = App.openDocument(path)
            turn(0.1)
            obj = self.document.getObject("FittedSurface")
            self.document.recompute(None, True)
        self.assertTrue(obj.isValid())
        again = [tuple(p) for row in obj.Shape.Faces[0].Surface.getPoles() for p in row]
        self.assertEqual(len(again), len(poles))
        for a, b in zip(again, poles):
            self.assertLess(App.Vector(*a).distanceToPoint(App.Vector(*b)), 1e-9)
        self.assertTrue(feature.is_fitted(obj))
        self.assertIsNotNone(obj.ViewObject.Proxy._cloud)
        Gui.ActiveDocument.ActiveView.viewAxometric()
        Gui.ActiveDocument.ActiveView.fitAll()
        self.picture("reopened")

    def test_without_a_server_the_shape_stays(self):
        obj = self.fitted()
        before = obj.Shape.hashCode()
        self.without_server()
        obj.Tolerance = 0.001
        self.document.recompute()
        self.assertFalse(obj.isValid())
        self.assertIn("cannot reach http://127.0.0.1:9", obj.Status)
        self.assertEqual(obj.Shape.hashCode(), before)
        preferences(Program=os.environ["PIAD_PROGRAM"])
        obj.touch()
        self.document.recompute()
        self.assertTrue(obj.isValid())
        self.assertNear(obj.Shape, wave(), 0.001 * (1 + 1e-6))

    def test_placement_stays(self):
        obj = self.fitted()
        obj.Placement.Base = App.Vector(0, 0, 50)
        obj.Tolerance = 0.01
        self.document.recompute()
        self.assertNear(obj.Shape, [(x, y, z + 50) for x, y, z in wave()], 0.01 * (1 + 1e-6))

    def test_points_without_a_source(self):
        obj = self.fitted()
        obj.Source = []
        self.document.removeObject(self.source.Name)
        self.document.recompute()
        points = wave()
        points[30] = (points[30][0], points[30][1] + 1, points[30][2])
        obj.Points = [App.Vector(*p) for p in points]
        self.document.recompute()
        self.assertNear(obj.Shape, points, 0.1 * (1 + 1e-9))

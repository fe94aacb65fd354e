"""The panel of a fit, operated by clicks."""

import math

import FreeCAD as App
import Mesh
import Part
from PySide import QtGui

from freecad.piad_workbench import drawing, fitting
from freecad.piad_workbench.settings import defaults
from helpers import WorkbenchTest, button, colours_of, dome, farthest, until, wave


class Curves(WorkbenchTest):
    def open_wave(self):
        self.points = wave()
        self.wire = self.polygon(self.points)
        return self.open("Piad_FitCurve", self.wire)

    def ended(self, panel, tolerance=None):
        """The end of the fit, with the tolerance that it had."""

        def end():
            update = panel._ended
            return update if update and tolerance in (None, panel._preview.settings.tolerance) else None

        return until(end, what=panel.status.text())

    def type(self, panel, text):
        """Types a tolerance."""
        line = panel.settings.widgets["tolerance"].findChild(QtGui.QLineEdit)
        line.setText(text)

    def test_accepted_curve_is_within_the_tolerance(self):
        panel = self.open_wave()
        update = self.ended(panel)
        self.view.viewAxometric()
        self.view.fitAll()
        self.picture("curve")
        self.assertIn("Within the tolerance", panel.status.text())
        button("OK").click()
        obj = self.document.Objects[-1]
        self.assertEqual(obj.TypeId, "Part::FeaturePython")
        self.assertEqual(obj.Shape.Edges[0].Curve.NbPoles, update.control_points[0])
        self.assertLess(update.control_points[0], 12)
        self.assertNear(obj.Shape, self.points, obj.Tolerance.Value * (1 + 1e-9))
        self.assertAlmostEqual(obj.LargestDistance.Value, farthest(obj.Shape, self.points), delta=1e-6)
        self.assertRegex(obj.PiadVersion, r"^\d+\.\d+\.\d+")
        self.assertTrue(self.wire.Visibility)

    def test_each_setting_has_help(self):
        panel = self.open_wave()
        names = list(panel.settings.widgets)
        self.assertEqual(names[0], "tolerance")
        texts = [it.text() for it in panel.settings.findChildren(QtGui.QLabel)]
        for name, widget in panel.settings.widgets.items():
            self.assertGreater(len(widget.toolTip()), 30, name)
            self.assertIn(widget.toolTip(), texts)

    def test_a_smaller_tolerance_takes_more_control_points(self):
        panel = self.open_wave()
        before = self.ended(panel)
        self.type(panel, "0.001 mm")
        after = self.ended(panel, 0.001)
        self.assertGreater(after.control_points[0], before.control_points[0])
        button("OK").click()
        self.assertNear(self.document.Objects[-1].Shape, self.points, 0.001 * (1 + 1e-6))

    def test_defaults(self):
        panel = self.open_wave()
        self.ended(panel)
        self.type(panel, "5 mm")
        panel.settings.widgets["degree"].setValue(5)
        panel.settings.widgets["smoothness"].setCurrentIndex(3)
        self.assertEqual(self.ended(panel, 5).geometry.degree, 5)
        panel.form.findChild(QtGui.QPushButton, "defaults").click()
        self.assertEqual(panel.settings.value(), defaults(panel.points))
        self.assertEqual(self.ended(panel, 0.1).geometry.degree, 3)

    def test_colours_say_what_is_outside(self):
        panel = self.open_wave()
        self.ended(panel)
        self.assertEqual(len(colours_of(panel._overlay.points)), 60)
        self.assertEqual(sum(rgb[0] > 0.85 and rgb[1] < 0.2 for rgb in colours_of(panel._overlay.points)), 0)
        self.type(panel, "0.01 mm")
        panel.settings.widgets["limit"].setValue(5)
        update = self.ended(panel, 0.01)
        self.assertIn("Outside of the tolerance", panel.status.text())
        self.view.viewAxometric()
        self.view.fitAll()
        self.picture("outside")
        outside = [rgb[0] > 0.85 and rgb[1] < 0.2 for rgb in colours_of(panel._overlay.points)]
        self.assertEqual(outside, [d > 0.01 for d in update.distances])
        self.assertIn(True, outside)
        panel.errors.setChecked(False)
        self.assertEqual(len(set(colours_of(panel._overlay.points)[:1])), 1)
        button("OK").click()
        obj = self.document.Objects[-1]
        obj.ViewObject.ShowErrors = True
        cloud = obj.ViewObject.Proxy._cloud
        self.assertEqual([rgb[0] > 0.85 and rgb[1] < 0.2 for rgb in colours_of(cloud)], outside)

    def test_selected_vertices_in_their_order(self):
        wire = self.polygon([(0, 0, 0), (10, 0, 0), (20, 5, 0), (30, 0, 0)])
        order = ["Vertex4", "Vertex2", "Vertex1", "Vertex3"]
        panel = self.open("Piad_FitCurve", *[(wire, name) for name in order])
        corners = [wire.Shape.getElement(name).Point for name in order]
        self.assertEqual([tuple(p) for p in corners], list(panel.points.values))

    def test_closed_sketch(self):
        sketch = self.document.addObject("Sketcher::SketchObject", "Sketch")
        corners = [App.Vector(30 * math.cos(a), 20 * math.sin(a), 0) for a in (2 * math.pi * i / 12 for i in range(12))]
        for a, b in zip(corners, [*corners[1:], corners[0]]):
            sketch.addGeometry(Part.LineSegment(a, b))
        self.document.recompute()
        panel = self.open("Piad_FitCurve", sketch)
        self.assertTrue(panel.settings.value().closed)
        self.ended(panel)
        button("OK").click()
        edge = self.document.Objects[-1].Shape.Edges[0]
        self.assertTrue(edge.isClosed())
        start, end = edge.tangentAt(edge.FirstParameter), edge.tangentAt(edge.LastParameter)
        self.assertLess((start - end).Length, 1e-6)
        self.assertNear(edge, [tuple(p) for p in corners], 0.072)

    def test_undo_and_redo(self):
        panel = self.open_wave()
        self.ended(panel)
        button("OK").click()
        self.assertEqual(len(self.document.Objects), 2)
        self.document.undo()
        self.assertEqual(len(self.document.Objects), 1)
        self.document.redo()
        obj = self.document.Objects[-1]
        self.assertNear(obj.Shape, self.points, obj.Tolerance.Value * (1 + 1e-9))
        obj.ViewObject.Proxy.doubleClicked(obj.ViewObject)
        from helpers import panel as newest

        panel = newest()
        self.type(panel, "0.002 mm")
        self.ended(panel, 0.002)
        before = obj.Shape.Edges[0].Curve.NbPoles
        button("OK").click()
        self.assertGreater(obj.Shape.Edges[0].Curve.NbPoles, before)
        self.document.undo()
        self.assertEqual((obj.Shape.Edges[0].Curve.NbPoles, obj.Tolerance.Value), (before, 0.1))

    def test_cancel_leaves_nothing(self):
        panel = self.open_wave()
        self.ended(panel)
        button("Cancel").click()
        self.assertEqual(self.document.Objects, [self.wire])
        self.assertTrue(self.wire.Visibility)


class Surfaces(WorkbenchTest):
    def accepted(self, panel):
        until(lambda: panel._ended, what=panel.status.text())
        self.view.viewAxometric()
        self.view.fitAll()
        return panel._ended

    def test_noisy_cloud(self):
        points = dome(2000, 0.05)
        panel = self.open("Piad_FitSurface", self.cloud(points))
        update = self.accepted(panel)
        self.picture("surface")
        self.assertLessEqual(max(update.control_points), 12)
        button("OK").click()
        obj = self.document.Objects[-1]
        self.assertNear(obj.Shape, points[::40], obj.Tolerance.Value * (1 + 1e-9))
        # The surface ends at the points, without overshoot.
        self.assertLess(obj.Shape.BoundBox.DiagonalLength, 1.1 * panel.points.size)
        obj.ViewObject.ShowErrors = True
        self.picture("surface_done")

    def test_coarse_shapes_come_first(self):
        counts = []
        show = drawing.Overlay.show
        drawing.Overlay.show = lambda overlay, spline: (counts.append(spline.NbUPoles * spline.NbVPoles), show(overlay, spline))
        self.addCleanup(setattr, drawing.Overlay, "show", show)
        panel = self.open("Piad_FitSurface", self.cloud(dome(5000, 0.05)))
        panel.settings.widgets["tolerance"].setProperty("rawValue", 0.045)
        until(lambda: panel._preview.settings.tolerance == 0.045)
        counts.clear()
        self.accepted(panel)
        self.assertGreater(len(set(counts)), 3)
        self.assertLess(counts[1], counts[-1])

    def test_mesh(self):
        mesh = self.document.addObject("Mesh::Feature", "Mesh")
        side = Part.makeCylinder(30, 60, App.Vector(), App.Vector(0, 0, 1), 120).Faces[0]
        mesh.Mesh = Mesh.Mesh(side.tessellate(0.05))
        panel = self.open("Piad_FitSurface", mesh)
        self.accepted(panel)
        self.picture("mesh")
        button("OK").click()
        obj = self.document.Objects[-1]
        self.assertNear(obj.Shape, [tuple(p) for p in mesh.Mesh.Topology[0]], obj.Tolerance.Value * (1 + 1e-9))

    def test_grid(self):
        points = [(x * 2.0, y * 3.0, math.sin(x / 5) * math.cos(y / 4)) for x in range(30) for y in range(20)]
        panel = self.open("Piad_FitSurface", self.cloud(points))
        self.assertEqual((panel.points.kind, panel.points.rows, panel.points.columns), ("grid", 20, 30))
        self.accepted(panel)
        button("OK").click()
        obj = self.document.Objects[-1]
        self.assertNear(obj.Shape, points[::7], obj.Tolerance.Value * (1 + 1e-9))

    def test_a_change_cancels_the_fit_before(self):
        panel = self.open("Piad_FitSurface", self.cloud(dome(20000, 0.05)))
        panel.settings.widgets["tolerance"].setProperty("rawValue", 0.03)
        first = until(lambda: panel._preview.settings.tolerance == 0.03 and panel._preview)
        until(lambda: first._follower and first._follower.job)
        self.assertFalse(panel.accept(), "the fit has not ended")
        panel.settings.widgets["tolerance"].setProperty("rawValue", 0.5)
        until(lambda: not first.running, what="the fit before is cancelled")
        self.assertIsNone(first.error)
        update = self.accepted(panel)
        self.assertIsNot(panel._preview, first)
        self.assertLessEqual(update.error, 0.5)
        with fitting.server.client() as client:
            jobs = [job.id for job in client.jobs()]
        self.assertEqual(jobs, [panel._preview.job.id])

"""Points of a fitted shape that are dragged with the mouse."""

import FreeCAD as App

from freecad.piad_workbench import feature
from helpers import Server, WorkbenchTest, button, dome, mouse, preferences, turn, until, wave


class Drags(WorkbenchTest):
    def fitted(self, command, source):
        panel = self.open(command, source)
        until(lambda: panel._ended, what=panel.status.text())
        button("OK").click()
        turn()
        return self.document.Objects[-1]

    def dragging(self, obj, view="viewTop"):
        panel = self.open("Piad_Drag", obj)
        getattr(self.view, view)()
        self.view.fitAll()
        until(lambda: panel._dragging, what=panel.status.text())
        return panel

    def place(self, point):
        """The position of a point on the screen, after the panel has resized the view."""
        seen = []

        def stands_still():
            turn(0.2)
            seen.append(self.view.getPointOnScreen(App.Vector(*point)))
            return len(seen) > 1 and seen[-1] == seen[-2]

        until(stands_still, what=f"the view moves: {seen}")
        return seen[-1]

    def drag(self, panel, index, by, steps=4):
        """Drags a point by this number of pixels."""
        x, y = self.place(panel.positions()[index])
        mouse("move", (x, y))
        mouse("press", (x, y))
        self.assertIsNotNone(panel._mouse._index)
        for i in range(1, steps + 1):
            mouse("move", (x + by[0] * i // steps, y + by[1] * i // steps))
            turn(0.05)
        mouse("release", (x + by[0], y + by[1]))

    def test_curve_follows(self):
        points = wave()
        obj = self.fitted("Piad_FitCurve", self.polygon(points))
        panel = self.dragging(obj)
        self.drag(panel, 20, (0, 40))
        moved = panel.positions()[20]
        self.assertGreater(moved[1] - points[20][1], 2)
        self.assertAlmostEqual(moved[2], points[20][2], delta=1e-6)
        until(lambda: "within the tolerance" in panel.status.text(), what=panel.status.text())
        self.picture("drag")
        button("OK").click()
        points[20] = moved
        self.assertNear(obj.Shape, points, 0.1 * (1 + 1e-9))
        self.assertEqual(obj.Moved, [20])
        self.document.recompute(None, True)
        self.assertNear(obj.Shape, points, 0.1 * (1 + 1e-9))
        self.document.undo()
        self.assertNear(obj.Shape, wave(), 0.1 * (1 + 1e-9))
        self.assertEqual(obj.Moved, [])

    def test_a_source_that_changes_keeps_the_move(self):
        import Part

        wire = self.polygon(wave())
        obj = self.fitted("Piad_FitCurve", wire)
        panel = self.dragging(obj)
        self.drag(panel, 20, (0, 40))
        moved = panel.positions()[20]
        button("OK").click()
        points = [(x, y, z + x / 50) for x, y, z in wave()]
        wire.Shape = Part.makePolygon([App.Vector(*p) for p in points])
        self.document.recompute()
        points[20] = moved
        self.assertNear(obj.Shape, points, 0.1 * (1 + 1e-9))

    def test_undo_in_the_panel(self):
        obj = self.fitted("Piad_FitCurve", self.polygon(wave()))
        panel = self.dragging(obj)
        self.drag(panel, 20, (0, 40))
        first = dict(panel.moves)
        self.drag(panel, 40, (10, -30))
        self.assertEqual(set(panel.moves), {20, 40})
        panel.back.click()
        self.assertEqual(panel.moves, first)
        panel.back.click()
        self.assertEqual(panel.moves, {})
        self.assertFalse(panel.back.isEnabled())
        button("Cancel").click()
        self.assertTrue(obj.Visibility)
        self.assertNear(obj.Shape, wave(), 0.1 * (1 + 1e-9))

    def test_surface_follows(self):
        points = dome(400)
        obj = self.fitted("Piad_FitSurface", self.cloud(points))
        panel = self.dragging(obj, "viewFront")
        # In the front view the top of the dome is its outline: the nearest point to it is taken.
        index = max(range(len(points)), key=lambda i: points[i][2])
        x, y = self.view.getPointOnScreen(App.Vector(*points[index]))
        self.drag(panel, index, (0, 12), 2)
        (index, moved), = panel.moves.items()
        self.assertGreater(moved[2] - points[index][2], 0.3)
        until(lambda: "control points" in panel.status.text(), what=panel.status.text())
        self.picture("drag_surface")
        button("OK").click()
        # The surface goes through it exactly.
        self.assertNear(obj.Shape, [moved], 1e-6)

    def test_server_that_goes_away(self):
        self.server = Server()
        preferences(Server=self.server.address)
        obj = self.fitted("Piad_FitCurve", self.polygon(wave()))
        panel = self.dragging(obj)
        self.server.kill()
        self.drag(panel, 20, (0, 40))
        until(lambda: panel._dragging.error, what=panel.status.text())
        self.assertFalse(panel.accept())
        button("Cancel").click()
        self.assertNear(obj.Shape, wave(), 0.1 * (1 + 1e-9))
        self.assertEqual(feature.moves_of(obj), {})

"""Test helpers for FreeCAD: clicks in panels, servers, screenshots."""

from __future__ import annotations

import math
import os
import subprocess
import threading
import time
import unittest
from collections.abc import Callable
from typing import Any

import FreeCAD as App
import FreeCADGui as Gui
import Part
from PySide import QtCore, QtGui

from freecad.piad_workbench import server
from freecad.piad_workbench.drag import DragPanel
from freecad.piad_workbench.panel import FitPanel

PROGRAM = os.environ["PIAD_PROGRAM"]
PICTURES = os.environ["PIAD_PICTURES"]
TIMEOUT = 120.0


def turn(seconds: float = 0.0) -> None:
    """Processes events of FreeCAD."""
    end = time.monotonic() + seconds
    while True:
        QtGui.QApplication.processEvents()
        if time.monotonic() >= end:
            return
        time.sleep(0.005)


def until(condition: Callable[[], Any], what: str = "") -> Any:
    """Processes events of FreeCAD until a condition holds."""
    end = time.monotonic() + TIMEOUT
    while True:
        turn()
        found = condition()
        if found:
            return found
        if time.monotonic() > end:
            raise AssertionError(f"not within {TIMEOUT} s: {what or condition}")
        time.sleep(0.005)


class Server:
    """A server that can be killed."""

    def __init__(self) -> None:
        command = [PROGRAM, "--listen", "127.0.0.1:0", "--store", ":memory:"]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        for line in self.process.stderr:
            if "listening on http" in line:
                self.address = "http" + line.split("listening on http", 1)[1].split()[0]
                break
        threading.Thread(target=self.process.stderr.read, daemon=True).start()

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def client(self) -> Any:
        return server.piad().Client(self.address)


class WorkbenchTest(unittest.TestCase):
    """A document and the program of the workbench."""

    server: Any = None
    """A `Server` that ends with the test."""

    def setUp(self) -> None:
        preferences(Program=PROGRAM)
        self.document = App.newDocument()
        Gui.activateWorkbench("PiadWorkbench")
        window = Gui.getMainWindow()
        window.showMaximized()
        for dock in window.findChildren(QtGui.QDockWidget):
            dock.setVisible(dock.objectName() == "Combo View")
        self.view = Gui.ActiveDocument.ActiveView
        self.view.setAnimationEnabled(False)

    def tearDown(self) -> None:
        if Gui.Control.activeDialog():
            panel().reject()
        for name in list(App.listDocuments()):
            App.closeDocument(name)
        if self.server is not None:
            self.server.kill()

    def cloud(self, points: Any, name: str = "Cloud") -> Any:
        import Points

        obj = self.document.addObject("Points::Feature", name)
        obj.Points = Points.Points([App.Vector(*p) for p in points])
        self.document.recompute()
        return obj

    def polygon(self, points: Any) -> Any:
        obj = self.document.addObject("Part::Feature", "Wire")
        obj.Shape = Part.makePolygon([App.Vector(*p) for p in points])
        return obj

    def open(self, command: str, *selected: Any) -> Any:
        """The panel of a command, with objects selected or (object, name of an element)."""
        Gui.Selection.clearSelection()
        for it in selected:
            Gui.Selection.addSelection(*(it if isinstance(it, tuple) else (it,)))
        turn()
        Gui.runCommand(command)
        turn()
        return panel()

    def picture(self, name: str) -> None:
        """A screenshot of the window."""
        turn(0.2)
        screen = QtGui.QApplication.primaryScreen()
        screen.grabWindow(0).save(os.path.join(PICTURES, f"{name}.png"))

    def assertNear(self, shape: Any, points: Any, tolerance: float) -> None:
        """All points are within the tolerance, measured by OpenCASCADE."""
        self.assertLessEqual(farthest(shape, points), tolerance)


def farthest(shape: Any, points: Any) -> float:
    """The largest distance of points from a curve or a surface."""
    return max(shape.distToShape(Part.Vertex(*p))[0] for p in points)


_panels: list[Any] = []


def panel() -> Any:
    """The panel that was opened last, which FreeCAD does not expose."""
    return _panels[-1] if _panels else None


def _remember(kind: type) -> None:
    """Records the instances of a class of panels."""
    make = kind.__init__

    def making(self: Any, *arguments: Any, **named: Any) -> None:
        make(self, *arguments, **named)
        _panels.append(self)

    kind.__init__ = making


for _kind in (FitPanel, DragPanel):
    _remember(_kind)


def button(name: str) -> Any:
    """A button of the task panel's box: "OK" or "Cancel"."""
    for box in Gui.getMainWindow().findChildren(QtGui.QDialogButtonBox):
        for it in box.buttons():
            if it.text().replace("&", "") == name and it.isVisible():
                return it
    raise AssertionError(f"there is no button {name}")


def preferences(**values: str) -> None:
    """Sets the preferences of the workbench; others are empty."""
    group = App.ParamGet(server.PREFERENCES)
    for name in ("Server", "Token", "Program"):
        group.SetString(name, values.get(name, ""))


def wave(count: int = 60) -> list[tuple[float, float, float]]:
    """Points along a curve in space."""
    return [(100 * t, 20 * math.sin(6 * t), 10 * t * t) for t in (i / (count - 1) for i in range(count))]


def dome(count: int = 2000, noise: float = 0.0) -> list[tuple[float, float, float]]:
    """Part of a sphere of radius 50, scattered as by a scanner, deterministic."""
    points = []
    for i in range(count):
        # A low-discrepancy sequence (Roberts' R2) for positions, and one for the noise.
        x, y, e = ((i * step) % 1 - 0.5 for step in (0.7548776662466927, 0.5698402909980532, 0.6180339887498949))
        radius = 50 + 2 * noise * e
        z = math.sqrt(1 - x * x - y * y)
        points.append((radius * x, radius * y, radius * z))
    return points


def viewport() -> Any:
    """The widget of the 3D view that gets the events of the mouse."""
    views = Gui.getMainWindow().findChildren(QtGui.QGraphicsView)
    return next(it for it in views if it.isVisible() and it.width() > 300).viewport()


def mouse(kind: str, place: tuple[int, int]) -> None:
    """An event of the left button: press, move or release. Positions count from the lower left
    corner."""
    kinds = {
        "press": (QtCore.QEvent.MouseButtonPress, QtCore.Qt.LeftButton, QtCore.Qt.LeftButton),
        "move": (QtCore.QEvent.MouseMove, QtCore.Qt.NoButton, QtCore.Qt.LeftButton),
        "release": (QtCore.QEvent.MouseButtonRelease, QtCore.Qt.LeftButton, QtCore.Qt.NoButton),
    }
    what, button_, buttons = kinds[kind]
    target = viewport()
    # Pixels of the scene may differ from those of the widget.
    width, height = Gui.ActiveDocument.ActiveView.getSize()
    position = QtCore.QPointF(place[0] * target.width() / width, (height - 1 - place[1]) * target.height() / height)
    event = QtGui.QMouseEvent(what, position, button_, buttons, QtCore.Qt.NoModifier)
    QtGui.QApplication.sendEvent(target, event)
    turn()


def colours_of(cloud: Any) -> list[tuple[float, ...]]:
    """The colours of a `PointCloud`."""
    return [tuple(it.getValue()) for it in cloud._material.diffuseColor.getValues()]

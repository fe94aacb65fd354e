"""The three commands."""

from __future__ import annotations

import os

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from . import feature
from .points import CLOUD, CURVE, PointsError

translate = FreeCAD.Qt.translate


class FitCommand:
    """Opens the panel with the selected points."""

    def __init__(self, kind: str, icon: str, text: str, tip: str):
        self._kind = kind
        self._resources = {"Pixmap": os.path.join(feature.ICONS, icon), "MenuText": text, "ToolTip": tip}

    def GetResources(self) -> dict[str, str]:
        """The icon and the texts."""
        return self._resources

    def IsActive(self) -> bool:
        """True if something is selected and no other panel is open."""
        return bool(FreeCADGui.Selection.getSelection()) and not FreeCADGui.Control.activeDialog()

    def Activated(self) -> None:
        """Opens the panel, or shows what to select."""
        from .panel import FitPanel
        from .view import FitView

        # A link to a whole object needs an empty element name, or it would be dropped.
        links = [(it.Object, it.SubElementNames or ("",)) for it in FreeCADGui.Selection.getSelectionEx()]
        try:
            panel = FitPanel.of_points(feature.read(self._kind, links), links, FitView)
        except PointsError as error:
            tell(str(error))
            return
        FreeCADGui.Control.showDialog(panel)


class DragCommand:
    """Opens the panel for dragging points of a fitted shape."""

    def GetResources(self) -> dict[str, str]:
        """The icon and the texts."""
        return {
            "Pixmap": os.path.join(feature.ICONS, "piad_drag.svg"),
            "MenuText": translate("piad", "Drag points"),
            "ToolTip": translate("piad", "Drag points of a fitted curve or surface: select it first"),
        }

    def IsActive(self) -> bool:
        """True if one fitted shape is selected and no other panel is open."""
        selected = FreeCADGui.Selection.getSelection()
        return len(selected) == 1 and feature.is_fitted(selected[0]) and not FreeCADGui.Control.activeDialog()

    def Activated(self) -> None:
        """Opens the panel."""
        from .drag import DragPanel

        FreeCADGui.Control.showDialog(DragPanel(FreeCADGui.Selection.getSelection()[0]))


def tell(text: str) -> None:
    """Shows a message without blocking the caller."""
    FreeCAD.Console.PrintWarning(text + "\n")
    box = QtGui.QMessageBox(QtGui.QMessageBox.Information, "piad", text, QtGui.QMessageBox.Ok, FreeCADGui.getMainWindow())
    box.setAttribute(QtCore.Qt.WA_DeleteOnClose)
    box.open()


NAMES = ("Piad_FitCurve", "Piad_FitSurface", "Piad_Drag")


def register() -> None:
    """Registers the commands with FreeCAD."""
    curve = FitCommand(
        CURVE,
        "piad_curve.svg",
        translate("piad", "Fit a curve"),
        translate("piad", "Fit a curve through selected points, a wire, a sketch or a list of points"),
    )
    surface = FitCommand(
        CLOUD,
        "piad_surface.svg",
        translate("piad", "Fit a surface"),
        translate("piad", "Fit a surface to selected point clouds or meshes"),
    )
    for name, command in zip(NAMES, (curve, surface, DragCommand())):
        FreeCADGui.addCommand(name, command)

"""The view of a fitted shape in the 3D view and the tree."""

from __future__ import annotations

import os
from typing import Any

import FreeCADGui
from PySide.QtCore import QT_TRANSLATE_NOOP

from . import feature
from .drawing import PointCloud
from .panel import FitPanel


class FitView:
    """The proxy of the view of a fitted shape, which can show its points coloured by their distances."""

    def __init__(self, view: Any):
        text = QT_TRANSLATE_NOOP("App::Property", "Shows the points in the colours of their distances.")
        view.addProperty("App::PropertyBool", "ShowErrors", "Fit", text)
        view.Proxy = self

    def attach(self, view: Any) -> None:
        """Called when the view is created, and when a document is opened."""
        self.object = view.Object
        self._cloud: PointCloud | None = None
        self._show(view)

    def getIcon(self) -> str:
        """The icon in the tree."""
        name = "piad_curve.svg" if self.object.Kind == feature.CURVE else "piad_surface.svg"
        return os.path.join(feature.ICONS, name)

    def updateData(self, obj: Any, name: str) -> None:
        """Called when a property of the object changes; the digest is set after all others."""
        if name in ("Fitted", "Visibility"):
            self._show(obj.ViewObject)

    def onChanged(self, view: Any, name: str) -> None:
        """Called when a property of the view changes."""
        if name in ("ShowErrors", "Visibility"):
            self._show(view)

    def _show(self, view: Any) -> None:
        if getattr(self, "_cloud", None) is not None:
            view.RootNode.removeChild(self._cloud.node)
            self._cloud = None
        if getattr(view, "ShowErrors", False) and view.Visibility and self.object.Points:
            self._cloud = PointCloud(feature.points_of(self.object).values)
            distances = self.object.Distances
            self._cloud.paint(distances if len(distances) == len(self.object.Points) else None, self.object.Tolerance.Value)
            view.RootNode.addChild(self._cloud.node)

    def doubleClicked(self, view: Any) -> bool:
        """Opens the panel with the settings."""
        FreeCADGui.Control.closeDialog()
        FreeCADGui.Control.showDialog(FitPanel.of_object(view.Object))
        return True

    def dumps(self) -> None:
        """There is no state other than the properties."""

    def loads(self, state: Any) -> None:
        """The reverse."""

    # The names of FreeCAD 0.20.
    __getstate__ = dumps
    __setstate__ = loads

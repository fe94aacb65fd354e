"""Picking and dragging of points with the mouse in the 3D view."""

from __future__ import annotations

import math
from typing import Any

import FreeCAD

# The picking radius in pixels.
_NEAR = 12

# Points within this number of pixels look coincident.
_SAME = 2


class PointMouse:
    """Reports drags to a panel with `positions()`, `move(index, point)` and `release()`."""

    def __init__(self, view: Any, panel: Any):
        self._view = view
        self._panel = panel
        self._index: int | None = None
        self._button = view.addEventCallback("SoMouseButtonEvent", self._press)
        self._move = view.addEventCallback("SoLocation2Event", self._motion)

    def remove(self) -> None:
        """Stops listening."""
        self._view.removeEventCallback("SoMouseButtonEvent", self._button)
        self._view.removeEventCallback("SoLocation2Event", self._move)

    def _press(self, event: Any) -> None:
        if event["Button"] != "BUTTON1":
            return
        if event["State"] == "DOWN":
            self._index = self._nearest(event["Position"])
        elif self._index is not None:
            self._index = None
            self._panel.release()

    def _motion(self, event: Any) -> None:
        if self._index is not None:
            point = FreeCAD.Vector(*self._panel.positions()[self._index])
            self._panel.move(self._index, self._under(event["Position"], point))

    def _nearest(self, position: Any) -> int | None:
        """The index of the point under the mouse; of coincident ones the nearest to the eye."""
        x, y = position
        direction = self._view.getViewDirection()
        near = []
        for index, point in enumerate(self._panel.positions()):
            vector = FreeCAD.Vector(*point)
            px, py = self._view.getPointOnScreen(vector)
            distance = math.hypot(px - x, py - y)
            if distance <= _NEAR:
                near.append((distance, vector.dot(direction), index))
        least = min(near, default=(math.inf,))[0]
        there = [(depth, index) for distance, depth, index in near if distance <= least + _SAME]
        return min(there)[1] if there else None

    def _under(self, position: Any, point: Any) -> Any:
        """The position of the mouse in the plane through a point parallel to the screen."""
        normal = self._view.getViewDirection()
        seen = self._view.getPoint(*position)
        ray = normal
        if self._view.getCameraType() == "Perspective":
            ray = seen - self._view.viewPosition().Base
        return seen + ray * ((point - seen).dot(normal) / ray.dot(normal))

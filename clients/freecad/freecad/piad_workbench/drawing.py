"""Nodes of a fit in the 3D view: its points, coloured by their distances, and its current shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pivy import coin

from . import shape
from .points import Point

# From 0 to the tolerance. Points outside have a separate colour.
_SCALE = ((0.0, (0.13, 0.35, 0.85)), (0.5, (0.15, 0.72, 0.35)), (1.0, (0.98, 0.80, 0.10)))
_OUTSIDE = (0.88, 0.10, 0.15)
_UNKNOWN = (0.95, 0.60, 0.15)
_SHAPE = (0.55, 0.70, 0.88)
_LINE = (0.10, 0.20, 0.45)

_FEW = 500
"""Up to this number, points are drawn large."""


def colour(part: float) -> tuple[float, float, float]:
    """The colour of a distance relative to the tolerance."""
    if not part <= 1.0:
        return _OUTSIDE
    for (a, low), (b, high) in zip(_SCALE, _SCALE[1:]):
        if part <= b:
            share = (part - a) / (b - a)
            return tuple(x + share * (y - x) for x, y in zip(low, high))
    return _SCALE[-1][1]


def colours(distances: Sequence[float], tolerance: float) -> list[tuple[float, float, float]]:
    """The colour of each point, from a table for speed."""
    table = [colour(i / 64) for i in range(65)]
    return [table[int(64 * d / tolerance)] if d <= tolerance else _OUTSIDE for d in distances]


def style() -> str:
    """The colour scale from 0 to the tolerance, as the background of a label."""
    stops = ", ".join("stop:{} rgb({}, {}, {})".format(at, *(int(255 * x) for x in rgb)) for at, rgb in _SCALE)
    return f"background: qlineargradient(x1:0, y1:0, x2:1, y2:0, {stops});"


def outside_style() -> str:
    """The same for points outside the tolerance."""
    return "background: rgb({}, {}, {});".format(*(int(255 * x) for x in _OUTSIDE))


class PointCloud:
    """Points as a scene node."""

    def __init__(self, points: Sequence[Point]):
        self.node = coin.SoSeparator()
        light = coin.SoLightModel()
        light.model = coin.SoLightModel.BASE_COLOR
        size = coin.SoDrawStyle()
        size.pointSize = 7 if len(points) <= _FEW else 3
        self._material = coin.SoMaterial()
        self._binding = coin.SoMaterialBinding()
        self._coordinates = coin.SoCoordinate3()
        self._set = coin.SoPointSet()
        for node in (light, size, self._material, self._binding, self._coordinates, self._set):
            self.node.addChild(node)
        self.move(points)
        self.paint(None, 1.0)

    def move(self, points: Sequence[Point]) -> None:
        """Moves the points."""
        self._coordinates.point.setValues(0, len(points), points)
        self._set.numPoints = len(points)

    def paint(self, distances: Sequence[float] | None, tolerance: float) -> None:
        """Colours each point by its distance, or all equally."""
        if distances is None:
            self._binding.value = coin.SoMaterialBinding.OVERALL
            self._material.diffuseColor.setValues(0, 1, [_UNKNOWN])
            return
        rgb = colours(distances, tolerance)
        self._material.diffuseColor.setValues(0, len(rgb), rgb)
        self._binding.value = coin.SoMaterialBinding.PER_VERTEX


class Overlay:
    """Nodes in a 3D view that are not part of the document or its undo history."""

    def __init__(self, view: Any, points: Sequence[Point]):
        self._scene = view.getSceneGraph()
        self._root = coin.SoSeparator()
        pick = coin.SoPickStyle()
        pick.style = coin.SoPickStyle.UNPICKABLE
        self._shape = coin.SoSeparator()
        self.points = PointCloud(points)
        for node in (pick, self._shape, self.points.node):
            self._root.addChild(node)
        self._scene.addChild(self._root)

    def show(self, spline: Any) -> None:
        """Replaces the displayed curve or surface of Part."""
        self._shape.removeAllChildren()
        add = _add_surface if hasattr(spline, "UDegree") else _add_curve
        add(self._shape, spline)

    def remove(self) -> None:
        """Removes all nodes."""
        self._scene.removeChild(self._root)


def _add_curve(parent: Any, spline: Any) -> None:
    _add_line(parent, shape.curve_samples(spline), 3)


def _add_line(parent: Any, points: Sequence[Any], width: int) -> None:
    line = coin.SoSeparator()
    look = coin.SoBaseColor()
    look.rgb = _LINE
    thickness = coin.SoDrawStyle()
    thickness.lineWidth = width
    light = coin.SoLightModel()
    light.model = coin.SoLightModel.BASE_COLOR
    coordinates = coin.SoCoordinate3()
    coordinates.point.setValues(0, len(points), [tuple(p) for p in points])
    lines = coin.SoLineSet()
    lines.numVertices = len(points)
    for node in (light, look, thickness, coordinates, lines):
        line.addChild(node)
    parent.addChild(line)


def _add_surface(parent: Any, spline: Any) -> None:
    rows = shape.surface_samples(spline)
    hints = coin.SoShapeHints()
    hints.vertexOrdering = coin.SoShapeHints.COUNTERCLOCKWISE
    hints.creaseAngle = 1.5
    material = coin.SoMaterial()
    material.diffuseColor = _SHAPE
    material.specularColor = (0.4, 0.4, 0.4)
    material.shininess = 0.6
    coordinates = coin.SoCoordinate3()
    flat = [tuple(p) for row in rows for p in row]
    coordinates.point.setValues(0, len(flat), flat)
    mesh = coin.SoQuadMesh()
    mesh.verticesPerColumn, mesh.verticesPerRow = len(rows), len(rows[0])
    for node in (hints, material, coordinates, mesh):
        parent.addChild(node)
    outline = [*rows[0], *(row[-1] for row in rows[1:]), *rows[-1][-2::-1], *(row[0] for row in rows[-2::-1])]
    _add_line(parent, outline, 2)

"""The fitted shape in a document: it stores its points and settings and is refitted when they
change."""

from __future__ import annotations

import os
from typing import Any

import FreeCAD
from PySide.QtCore import QT_TRANSLATE_NOOP

from . import fitting, points, server, shape
from .fitting import Update
from .points import CURVE, Points
from .settings import SMOOTHNESS, Settings, fields_of

translate = FreeCAD.Qt.translate

ICONS = os.path.join(os.path.dirname(__file__), "resources", "icons")

_READ_ONLY = 1
_HIDDEN = 4

# Name, type, description and attributes.
_KEPT = (
    ("Source", "App::PropertyLinkSubListGlobal", QT_TRANSLATE_NOOP("App::Property", "Where the points come from. Without it they are those that are kept here."), 0),
    ("Points", "App::PropertyVectorList", QT_TRANSLATE_NOOP("App::Property", "The points, in the order of the source."), _HIDDEN),
    ("Rows", "App::PropertyInteger", QT_TRANSLATE_NOOP("App::Property", "The number of rows of a grid of points."), _HIDDEN),
    ("Kind", "App::PropertyString", QT_TRANSLATE_NOOP("App::Property", "Points of a curve, a grid or a cloud."), _HIDDEN),
    ("Moved", "App::PropertyIntegerList", QT_TRANSLATE_NOOP("App::Property", "The points that were dragged."), _HIDDEN),
    ("MovedTo", "App::PropertyVectorList", QT_TRANSLATE_NOOP("App::Property", "Where these are."), _HIDDEN),
    ("Distances", "App::PropertyFloatList", QT_TRANSLATE_NOOP("App::Property", "How far each point is from the shape."), _HIDDEN),
    ("Fitted", "App::PropertyString", QT_TRANSLATE_NOOP("App::Property", "The points and settings of the shape, as a digest."), _HIDDEN),
    ("PiadVersion", "App::PropertyString", QT_TRANSLATE_NOOP("App::Property", "The version of piad that has fitted the shape."), _READ_ONLY),
    ("ControlPoints", "App::PropertyString", QT_TRANSLATE_NOOP("App::Property", "How many control points the shape has."), _READ_ONLY),
    ("LargestDistance", "App::PropertyLength", QT_TRANSLATE_NOOP("App::Property", "How far the shape is from the points."), _READ_ONLY),
    ("Status", "App::PropertyString", QT_TRANSLATE_NOOP("App::Property", "How the fit has ended."), _READ_ONLY),
)


class FitFeature:
    """The proxy of a fitted curve or surface. Its state is in properties of its object."""

    def __init__(self, obj: Any, given: Points, links: Any):
        for name, kind, text, attributes in _KEPT:
            obj.addProperty(kind, name, "Fit", text, attributes)
        for field in fields_of(given.kind):
            obj.addProperty(field.property, _property(field.name), "Settings", field.help)
        if hasattr(obj, "Smoothness"):
            obj.Smoothness = list(SMOOTHNESS)
        obj.Kind = given.kind
        obj.Source = links
        _keep(obj, given)
        obj.Proxy = self

    def execute(self, obj: Any) -> None:
        """Fits again if points or settings have changed since the current shape."""
        if obj.Source:
            _keep(obj, read(obj.Kind, obj.Source))
        given, settings = points_of(obj), settings_of(obj)
        if obj.Fitted == fitting.key(given, settings) and not obj.Shape.isNull():
            return
        try:
            store(obj, given, settings, fitting.fit(given, settings))
        except Exception as error:
            # The previous shape is kept, and FreeCAD marks the object.
            obj.Status = server.in_words(error)
            raise RuntimeError(obj.Status) from error

    def dumps(self) -> None:
        """There is no state other than the properties."""

    def loads(self, state: Any) -> None:
        """The reverse."""

    # The names of FreeCAD 0.20.
    __getstate__ = dumps
    __setstate__ = loads


def create(document: Any, given: Points, links: Any, settings: Settings, update: Update | None) -> Any:
    """Creates an object without a view provider, with the shape of an ended fit if there is one."""
    name = "FittedCurve" if given.kind == CURVE else "FittedSurface"
    obj = document.addObject("Part::FeaturePython", name)
    FitFeature(obj, given, links)
    set_settings(obj, settings)
    if update is not None:
        store(obj, given, settings, update)
    return obj


def read(kind: str, links: Any) -> Points:
    """The current points of objects."""
    return points.read_curve(links) if kind == CURVE else points.read_surface(links)


def _keep(obj: Any, given: Points) -> None:
    """Stores points if they have changed: setting a property marks the object as touched."""
    values = [FreeCAD.Vector(*point) for point in given.values]
    if obj.Points != values:
        obj.Points = values
    if obj.Rows != given.rows or obj.Kind != given.kind:
        obj.Rows, obj.Kind = given.rows, given.kind


def points_of(obj: Any, moved: bool = True) -> Points:
    """The points of an object, including moves by dragging."""
    values = tuple((p.x, p.y, p.z) for p in obj.Points)
    given = Points(obj.Kind, values, obj.Rows)
    return given.with_moves(moves_of(obj)) if moved else given


def moves_of(obj: Any) -> dict[int, tuple[float, float, float]]:
    """The dragged points."""
    return {index: (p.x, p.y, p.z) for index, p in zip(obj.Moved, obj.MovedTo)}


def set_moves(obj: Any, moves: dict[int, Any]) -> None:
    """Stores moves of points."""
    obj.Moved = list(moves)
    obj.MovedTo = [FreeCAD.Vector(*point) for point in moves.values()]


def settings_of(obj: Any) -> Settings:
    """The settings of an object."""
    values = {field.name: getattr(obj, _property(field.name)) for field in fields_of(obj.Kind)}
    values["tolerance"] = values["tolerance"].Value
    return Settings(**values)


def set_settings(obj: Any, settings: Settings) -> None:
    """Sets the changed properties."""
    before = settings_of(obj)
    for field in fields_of(obj.Kind):
        value = getattr(settings, field.name)
        if getattr(before, field.name) != value:
            setattr(obj, _property(field.name), value)


def store(obj: Any, given: Points, settings: Settings, update: Update) -> None:
    """Stores the result of a fit: documents open and recompute with it, without a server."""
    spline = shape.part_geometry(update.geometry)
    placement = obj.Placement
    obj.Shape = spline.toShape()
    obj.Placement = placement
    obj.Distances = list(update.distances or ())
    obj.Fitted = fitting.key(given, settings)
    obj.PiadVersion = update.version or obj.PiadVersion
    obj.ControlPoints = " × ".join(map(str, update.control_points))
    obj.LargestDistance = max(obj.Distances, default=update.error)
    obj.Status = update.detail or update.state


def is_fitted(obj: Any) -> bool:
    """True for objects of this type."""
    return isinstance(getattr(obj, "Proxy", None), FitFeature)


def _property(name: str) -> str:
    return name.capitalize()

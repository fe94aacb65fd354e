"""The settings of a fit, with texts for users."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import floor, log10
from typing import Any

from PySide.QtCore import QT_TRANSLATE_NOOP

from .points import CLOUD, CURVE, Points

SMOOTHNESS = {
    QT_TRANSLATE_NOOP("piad", "Off"): 0.0,
    QT_TRANSLATE_NOOP("piad", "Light"): 1e-10,
    QT_TRANSLATE_NOOP("piad", "Medium"): 1e-8,
    QT_TRANSLATE_NOOP("piad", "Strong"): 1e-6,
}
"""The fairness of each: the weight of bending relative to the distances."""


@dataclass(frozen=True)
class Field:
    """A setting as shown to users."""

    name: str
    """The field of `Settings`."""
    label: str
    help: str
    """The help text: the effect, and when to change it."""
    property: str
    """The type of its property in the document."""


FIELDS = (
    Field(
        "tolerance",
        QT_TRANSLATE_NOOP("piad", "Tolerance"),
        QT_TRANSLATE_NOOP("piad", "How far the shape may be from the points. A larger one needs fewer control points."),
        "App::PropertyLength",
    ),
    Field(
        "degree",
        QT_TRANSLATE_NOOP("piad", "Degree"),
        QT_TRANSLATE_NOOP("piad", "3 suits most shapes. 5 lets curvature change more evenly, 1 makes straight pieces."),
        "App::PropertyInteger",
    ),
    Field(
        "smoothness",
        QT_TRANSLATE_NOOP("piad", "Smoothing"),
        QT_TRANSLATE_NOOP("piad", "Evens out noise and bridges gaps. Too much of it keeps the shape away from the points."),
        "App::PropertyEnumeration",
    ),
    Field(
        "limit",
        QT_TRANSLATE_NOOP("piad", "Most control points"),
        QT_TRANSLATE_NOOP("piad", "A limit, in each direction of a surface. 0 is none: as many as the tolerance needs."),
        "App::PropertyInteger",
    ),
    Field(
        "closed",
        QT_TRANSLATE_NOOP("piad", "Closed"),
        QT_TRANSLATE_NOOP("piad", "Continues smoothly from the last point to the first."),
        "App::PropertyBool",
    ),
    Field(
        "ends",
        QT_TRANSLATE_NOOP("piad", "Exactly through the ends"),
        QT_TRANSLATE_NOOP("piad", "Switch it off if the first and the last point are as noisy as the others."),
        "App::PropertyBool",
    ),
    Field(
        "steep",
        QT_TRANSLATE_NOOP("piad", "Steep or bent shape"),
        QT_TRANSLATE_NOOP("piad", "Lays the points on a rough surface first rather than on a plane. Switch it off for flat shapes, to save time."),
        "App::PropertyBool",
    ),
)


@dataclass(frozen=True)
class Settings:
    """The values of all settings; unused ones of a kind of shape keep their defaults."""

    tolerance: float
    degree: int = 3
    smoothness: str = "Off"
    limit: int = 0
    closed: bool = False
    ends: bool = True
    steep: bool = True

    def with_value(self, name: str, value: Any) -> Settings:
        """The same with another value of a setting."""
        return replace(self, **{name: value})

    @property
    def fairness(self) -> float:
        """The weight of bending."""
        return SMOOTHNESS[self.smoothness]

    def as_tuple(self) -> tuple[Any, ...]:
        """The values in the order of the fields."""
        return tuple(getattr(self, field.name) for field in fields(self))


def fields_of(kind: str) -> list[Field]:
    """The settings of a kind of points."""
    without = {"steep"} if kind == CURVE else {"closed", "ends"} if kind == CLOUD else {"closed", "ends", "steep"}
    return [field for field in FIELDS if field.name not in without]


def defaults(points: Points) -> Settings:
    """Defaults for points: a tolerance of a thousandth of their size, and a degree that they allow.

    Scans have gaps and corners where a surface is undetermined: a little smoothing keeps it near.
    """
    degree = max(1, min(3, points.shortest - 1))
    smoothness = "Light" if points.kind == CLOUD else "Off"
    return Settings(_rounded(points.size / 1000), degree, smoothness, closed=points.closed)


def _rounded(length: float) -> float:
    """A length with one digit."""
    if length <= 0:
        return 0.1
    unit = 10.0 ** floor(log10(length))
    return float(f"{round(length / unit) * unit:.1g}")

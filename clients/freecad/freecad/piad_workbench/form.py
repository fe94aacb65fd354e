"""The settings of a fit as widgets with help texts."""

from __future__ import annotations

from typing import Any

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from .points import Points
from .settings import SMOOTHNESS, Field, Settings, defaults, fields_of

translate = FreeCAD.Qt.translate


class SettingsForm(QtGui.QWidget):
    """All settings of a kind of points. `changed` is emitted when the user changes one."""

    changed = QtCore.Signal()

    def __init__(self, points: Points, settings: Settings):
        super().__init__()
        self._points = points
        self._base = settings
        self.widgets: dict[str, Any] = {}
        layout = QtGui.QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        for field in fields_of(points.kind):
            layout.addLayout(self._row(field, getattr(settings, field.name)))
        self.back = QtGui.QPushButton(translate("piad", "Back to the defaults"))
        self.back.setObjectName("defaults")
        self.back.clicked.connect(self.set_defaults)
        layout.addWidget(self.back)
        self.set_value(settings)

    def _row(self, field: Field, value: Any) -> Any:
        column = QtGui.QVBoxLayout()
        column.setSpacing(0)
        label = translate("piad", field.label)
        widget = _widget(value, label)
        widget.setObjectName(field.name)
        widget.setToolTip(translate("piad", field.help))
        self.widgets[field.name] = widget
        if isinstance(value, bool):
            column.addWidget(widget)
        else:
            row = QtGui.QHBoxLayout()
            row.addWidget(QtGui.QLabel(label))
            # The panel is narrow, and their values are short.
            widget.setSizePolicy(QtGui.QSizePolicy.Ignored, QtGui.QSizePolicy.Fixed)
            row.addWidget(widget, 1)
            column.addLayout(row)
        help_ = QtGui.QLabel(translate("piad", field.help))
        help_.setWordWrap(True)
        help_.setStyleSheet("color: #757575; font-size: small;")
        column.addWidget(help_)
        _signal(widget).connect(self._tell)
        return column

    def _tell(self, *_: Any) -> None:
        """A spin box reports each change of its text, also from 0.1 mm to 0.10 mm."""
        if self.value() != self._told:
            self._told = self.value()
            self.changed.emit()

    def value(self) -> Settings:
        """The displayed settings."""
        settings = self._base
        for name, widget in self.widgets.items():
            settings = settings.with_value(name, _value(widget))
        return settings

    def set_value(self, settings: Settings) -> None:
        """Displays these without emitting `changed`."""
        for name, widget in self.widgets.items():
            widget.blockSignals(True)
            _set(widget, getattr(settings, name))
            widget.blockSignals(False)
        self._told = self.value()

    def set_defaults(self) -> None:
        """Shows the defaults."""
        before = self.value()
        self.set_value(defaults(self._points))
        if self.value() != before:
            self.changed.emit()


def _widget(value: Any, label: str) -> Any:
    """The widget of a kind of value."""
    if isinstance(value, bool):
        return QtGui.QCheckBox(label)
    if isinstance(value, str):
        box = QtGui.QComboBox()
        for name in SMOOTHNESS:
            box.addItem(translate("piad", name), name)
        return box
    if isinstance(value, int):
        spin = QtGui.QSpinBox()
        spin.setRange(0, 1000)
        return spin
    length = FreeCADGui.UiLoader().createWidget("Gui::QuantitySpinBox")
    length.setProperty("unit", "mm")
    length.setProperty("decimals", 6)
    length.setProperty("minimum", 0.0)
    return length


def _signal(widget: Any) -> Any:
    if isinstance(widget, QtGui.QCheckBox):
        return widget.toggled
    if isinstance(widget, QtGui.QComboBox):
        return widget.currentIndexChanged
    return widget.valueChanged


def _value(widget: Any) -> Any:
    if isinstance(widget, QtGui.QCheckBox):
        return widget.isChecked()
    if isinstance(widget, QtGui.QComboBox):
        return widget.currentData()
    if isinstance(widget, QtGui.QSpinBox):
        return widget.value()
    return widget.property("rawValue")


def _set(widget: Any, value: Any) -> None:
    if isinstance(widget, QtGui.QCheckBox):
        widget.setChecked(value)
    elif isinstance(widget, QtGui.QComboBox):
        widget.setCurrentIndex(widget.findData(value))
    elif isinstance(widget, QtGui.QSpinBox):
        widget.setValue(value)
    else:
        widget.setProperty("rawValue", value)

"""The task panel of a fit: its progress and settings."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from . import drawing, feature, shape
from .fitting import Update
from .form import SettingsForm
from .points import CURVE, Points
from .preview import Preview
from .settings import defaults

translate = FreeCAD.Qt.translate

# Milliseconds between updates, and from the last change of a setting to a new fit.
_LOOK = 40
_SETTLE = 250


class FitPanel:
    """Fits while it is open; OK adds an object to the document or changes one."""

    @classmethod
    def of_object(cls, obj: Any) -> FitPanel:
        """The panel of an existing shape."""
        return cls(feature.points_of(obj), obj.Source, obj)

    @classmethod
    def of_points(cls, points: Points, links: Any, attach_view: Callable[[Any], Any]) -> FitPanel:
        """The panel of a new shape, whose view gets its provider from `attach_view`."""
        return cls(points, links, attach_view=attach_view)

    def __init__(self, points: Points, links: Any, obj: Any = None, attach_view: Callable[[Any], Any] | None = None):
        self.points = points
        self._links = links
        self._object = obj
        self._attach_view = attach_view
        self._document = FreeCAD.ActiveDocument
        self._preview: Preview | None = None
        self._last: Update | None = None
        self._ended: Update | None = None
        """The end of the fit with the displayed settings, if available."""
        settings = defaults(points) if obj is None else feature.settings_of(obj)
        self.settings = SettingsForm(points, settings)
        self.form = self._form()
        self._overlay = drawing.Overlay(FreeCADGui.ActiveDocument.ActiveView, _finite(points))
        # The preview replaces the source and the previous shape.
        shown = [it for it, _ in links or ()] + ([] if obj is None else [obj])
        self._hidden = [it for it in shown if it.Visibility]
        self._set_visible(False)
        FreeCADGui.Selection.clearSelection()
        self._settle = QtCore.QTimer()
        self._settle.setSingleShot(True)
        self._settle.timeout.connect(self.start)
        self._look = QtCore.QTimer()
        self._look.timeout.connect(self._follow)
        self.settings.changed.connect(self._change)
        self.start()

    def _form(self) -> Any:
        form = QtGui.QWidget()
        form.setWindowTitle(translate("piad", "Fit a curve") if self.points.kind == CURVE else translate("piad", "Fit a surface"))
        layout = QtGui.QVBoxLayout(form)
        self.source = QtGui.QLabel(translate("piad", "{} points").format(_described(self.points)))
        self.status = QtGui.QLabel()
        self.status.setObjectName("status")
        self.status.setWordWrap(True)
        self.status.setTextInteractionFlags(QtCore.Qt.TextSelectableByMouse)
        # It is above the settings, so that it is visible while they change and they do not move.
        self.status.setMinimumHeight(3 * self.status.fontMetrics().lineSpacing())
        self.status.setAlignment(QtCore.Qt.AlignTop)
        self.again = QtGui.QPushButton(translate("piad", "Try again"))
        self.again.setObjectName("again")
        self.again.clicked.connect(self.start)
        self.errors = QtGui.QCheckBox(translate("piad", "Show distances as colours"))
        self.errors.setObjectName("errors")
        self.errors.setChecked(True)
        self.errors.toggled.connect(self._paint)
        for widget in (self.source, self.status, self.again, _line(), self.settings, self.errors, legend()):
            layout.addWidget(widget)
        layout.addStretch()
        return form

    # The fit.

    def _change(self) -> None:
        """A setting has changed: cancels the current fit."""
        self._stop()
        self._ended = None
        self.status.setText(translate("piad", "Fitting…"))
        self._settle.start(_SETTLE)

    def start(self) -> None:
        """Fits with the displayed settings and cancels the previous fit."""
        self._stop()
        self._ended = None
        self.again.hide()
        self.status.setText(translate("piad", "Fitting…"))
        self._preview = Preview(self.points, self.settings.value())
        self._look.start(_LOOK)

    def _stop(self) -> None:
        self._settle.stop()
        self._look.stop()
        if self._preview is not None:
            self._preview.cancel()

    def _follow(self) -> None:
        """Shows the newest update. Checks for the end of the thread first, so that its last update
        is not missed."""
        assert self._preview is not None
        running = self._preview.running
        update = self._preview.take()
        if update is not None:
            self._show(update)
        if not running:
            self._look.stop()
            if self._preview.error is not None:
                self._fail(self._preview.error)

    def _show(self, update: Update) -> None:
        self._last = update
        self._ended = update if update.ended else None
        try:
            self._overlay.show(shape.part_geometry(update.geometry))
        except Exception as error:  # Part rejects an intermediate shape.
            if update.ended:
                self._fail(str(error))
                return
        self._paint()
        self.status.setText(_in_words(update, self.settings.value().tolerance))

    def _fail(self, text: str) -> None:
        self._ended = None
        self.status.setText(f'<b style="color: #c01818">{_html(text)}</b>')
        self.again.show()

    def _paint(self, *_: Any) -> None:
        distances = self._last.distances if self._last is not None and self.errors.isChecked() else None
        if distances is not None and len(distances) == len(self.points.values):
            self._overlay.points.paint(distances, self.settings.value().tolerance)
        elif not self.errors.isChecked() or self._last is None:
            self._overlay.points.paint(None, 1.0)

    def _set_visible(self, visible: bool) -> None:
        for obj in self._hidden:
            obj.ViewObject.Visibility = visible

    # The buttons of the task panel.

    def getStandardButtons(self) -> int:
        """OK and Cancel."""
        return int(QtGui.QDialogButtonBox.Ok | QtGui.QDialogButtonBox.Cancel)

    def accept(self) -> bool:
        """Adds the shape to the document. If there is none yet, the panel stays open with a
        message."""
        if self._ended is None:
            if self._preview is not None and not self._preview.running:
                return False
            self.status.setText(translate("piad", "The fit has not ended: wait for it, or choose a larger tolerance."))
            return False
        settings = self.settings.value()
        self._document.openTransaction(self.form.windowTitle())
        if self._object is None:
            obj = feature.create(self._document, self.points, self._links, settings, self._ended)
            if self._attach_view is not None:
                self._attach_view(obj.ViewObject)
        else:
            obj = self._object
            feature.set_settings(obj, settings)
            feature.store(obj, self.points, settings, self._ended)
        self._document.recompute([obj])
        self._document.commitTransaction()
        self._close()
        return True

    def reject(self) -> bool:
        """Discards all changes."""
        self._close()
        return True

    def _close(self) -> None:
        self._stop()
        self._set_visible(True)
        self._overlay.remove()
        FreeCADGui.Control.closeDialog()


def legend() -> Any:
    """The legend of the colours."""
    widget = QtGui.QWidget()
    row = QtGui.QHBoxLayout(widget)
    row.setContentsMargins(0, 0, 0, 0)
    scale, outside = QtGui.QLabel(), QtGui.QLabel()
    scale.setStyleSheet(drawing.style())
    outside.setStyleSheet(drawing.outside_style())
    scale.setFixedHeight(10)
    outside.setFixedSize(16, 10)
    row.addWidget(QtGui.QLabel("0"))
    row.addWidget(scale, 1)
    row.addWidget(QtGui.QLabel(translate("piad", "tolerance")))
    row.addWidget(outside)
    row.addWidget(QtGui.QLabel(translate("piad", "outside")))
    return widget


def _line() -> Any:
    line = QtGui.QFrame()
    line.setFrameShape(QtGui.QFrame.HLine)
    line.setFrameShadow(QtGui.QFrame.Sunken)
    return line


def _described(points: Points) -> str:
    return f"{points.rows} × {points.columns}" if points.rows else str(len(points.values))


def _finite(points: Points) -> list[Any]:
    """Points for the view, without those that are not finite."""
    return [point if all(map(math.isfinite, point)) else (0.0, 0.0, 0.0) for point in points.values]


def _in_words(update: Update, tolerance: float) -> str:
    """The state of the fit."""
    if update.rough:
        return translate("piad", "A rough surface to lay the points on…")
    count = " × ".join(map(str, update.control_points))
    distance = max(update.distances) if update.distances and update.ended else update.error
    lines = [translate("piad", "{} control points, iteration {}").format(count, update.iteration)]
    lines.append(translate("piad", "Largest distance {}").format(_distance(distance)))
    if not update.ended:
        lines.append(translate("piad", "Fitting…"))
    elif update.error <= tolerance:
        within = translate("piad", "Within the tolerance.")
        lines.append(f'<b style="color: #187a30">{within}</b>')
    else:
        outside = translate("piad", "Outside of the tolerance.")
        lines.append(f'<b style="color: #b06000">{outside}</b> {_html(update.detail)}')
    return "<br>".join([*lines, *map(_html, update.warnings)])


def _distance(value: float) -> str:
    """Formats with three digits: as a length of FreeCAD, small numbers would be zero."""
    return f"{value:.3g} mm"


def _html(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace("\n", "<br>")

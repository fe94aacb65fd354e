"""The task panel for dragging points of a fitted shape; the shape is fitted again."""

from __future__ import annotations

from typing import Any

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

from . import drawing, feature, fitting, server, shape
from .edits import Dragging
from .fitting import Update
from .mouse import PointMouse
from .preview import Preview

translate = FreeCAD.Qt.translate

_LOOK = 15


class DragPanel:
    """Points follow the mouse, and the shape is fitted to them. OK stores the moves in the
    object."""

    def __init__(self, obj: Any):
        self._object = obj
        self._document = obj.Document
        self._settings = feature.settings_of(obj)
        self._points = feature.points_of(obj)
        self._history: list[dict[int, Any]] = [{}]
        """The moves of this panel, after each time the mouse button was released."""
        self.moves: dict[int, Any] = {}
        self._dragging: Dragging | None = None
        self._preview = Preview(self._points, self._settings)
        view = FreeCADGui.ActiveDocument.ActiveView
        self._overlay = drawing.Overlay(view, self._points.values)
        self._overlay.show(_spline(obj))
        obj.Visibility = False
        self.form = self._form()
        self._mouse = PointMouse(view, self)
        self._look = QtCore.QTimer()
        self._look.timeout.connect(self._follow)
        self._look.start(_LOOK)

    def _form(self) -> Any:
        form = QtGui.QWidget()
        form.setWindowTitle(translate("piad", "Drag points"))
        layout = QtGui.QVBoxLayout(form)
        help_ = QtGui.QLabel(translate("piad", "Drag a point with the left mouse button: it moves in the plane of the screen, and the shape follows."))
        help_.setWordWrap(True)
        self.status = QtGui.QLabel(translate("piad", "Preparing: the server fits the points as they are…"))
        self.status.setObjectName("status")
        self.status.setWordWrap(True)
        self.back = QtGui.QPushButton(translate("piad", "Undo the last move"))
        self.back.setObjectName("undo")
        self.back.setEnabled(False)
        self.back.clicked.connect(self.undo)
        for widget in (help_, self.status, self.back):
            layout.addWidget(widget)
        layout.addStretch()
        return form

    # Events of the mouse.

    def positions(self) -> Any:
        """The current positions of the points."""
        return self._points.with_moves(self.moves).values

    def move(self, index: int, position: Any) -> None:
        """Moves a point while the mouse button is down."""
        self._set({**self.moves, index: tuple(position)})

    def release(self) -> None:
        """Ends a move when the mouse button is released."""
        if self.moves != self._history[-1]:
            self._history.append(self.moves)
            self.back.setEnabled(True)

    def undo(self) -> None:
        """Undoes the last move."""
        if len(self._history) > 1:
            self._history.pop()
            self._set(self._history[-1])
            self.back.setEnabled(len(self._history) > 1)

    def _set(self, moves: dict[int, Any]) -> None:
        self.moves = moves
        self._overlay.points.move(self.positions())
        if not moves:
            self._overlay.show(_spline(self._object))
        elif self._dragging is not None:
            self._dragging.move(moves)

    # Updates from the server.

    def _follow(self) -> None:
        if self._dragging is None:
            self._prepare()
            return
        update = self._dragging.take()
        if update is not None and self.moves:
            self._show(update)
        elif self._dragging.error is not None:
            self._fail(self._dragging.error)

    def _prepare(self) -> None:
        """Edits need a job: the fit of the current points."""
        running = self._preview.running
        update = self._preview.take()
        if update is not None and update.ended:
            self._dragging = Dragging(self._preview.job.id, self._points, self._settings)
            self.status.setText(translate("piad", "Drag a point."))
            if self.moves:
                self._set(self.moves)
        elif not running:
            self._look.stop()
            self._fail(self._preview.error or "")

    def _show(self, update: Update) -> None:
        self._overlay.show(shape.part_geometry(update.geometry))
        within = update.error <= self._settings.tolerance
        state = translate("piad", "within the tolerance") if within else translate("piad", "outside of the tolerance")
        count = " × ".join(map(str, update.control_points))
        self.status.setText(translate("piad", "{} control points, largest distance {:.3g} mm: {}").format(count, update.error, state))

    def _fail(self, text: str) -> None:
        self.status.setText(f'<b style="color: #c01818">{text}</b>')

    # The buttons of the task panel.

    def getStandardButtons(self) -> int:
        """OK and Cancel."""
        return int(QtGui.QDialogButtonBox.Ok | QtGui.QDialogButtonBox.Cancel)

    def accept(self) -> bool:
        """Stores the moves and the shape. Without a server the panel stays open with a message."""
        update = None
        if self.moves:
            try:
                update = fitting.edit(self._preview.job, self._points, self.moves, self._settings)
            except Exception as error:
                self._fail(server.in_words(error))
                return False
        self._document.openTransaction(self.form.windowTitle())
        if update is not None:
            feature.set_moves(self._object, {**feature.moves_of(self._object), **self.moves})
            feature.store(self._object, feature.points_of(self._object), self._settings, update)
        self._object.Visibility = True
        self._document.recompute([self._object])
        self._document.commitTransaction()
        self._close()
        return True

    def reject(self) -> bool:
        """Discards all changes."""
        self._object.Visibility = True
        self._close()
        return True

    def _close(self) -> None:
        self._look.stop()
        self._mouse.remove()
        if self._dragging is not None:
            self._dragging.close()
        self._preview.cancel()
        self._overlay.remove()
        FreeCADGui.Control.closeDialog()


def _spline(obj: Any) -> Any:
    """The curve or the surface of an object."""
    return obj.Shape.Faces[0].Surface if obj.Shape.Faces else obj.Shape.Edges[0].Curve

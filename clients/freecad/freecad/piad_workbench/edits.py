"""Edits for dragging: fits that are streamed in the response and not stored."""

from __future__ import annotations

import threading
import uuid
from typing import Any

from . import server
from .fitting import Update, method_of
from .points import Points
from .settings import Settings

# Older versions of httpx send head and body separately, and on a reused connection the system
# delays the body by 40 ms.
_ONCE = {"Connection": "close"}


class Dragging:
    """A thread that fits for the newest positions of the points and skips older ones."""

    def __init__(self, job: str, points: Points, settings: Settings):
        self.error: str | None = None
        """The message of an error, if there is one."""
        self._job = job
        self._points = points
        self._settings = settings
        self._session = uuid.uuid4().hex
        self._wanted: Any = None
        self._newest: Update | None = None
        self._closed = False
        self._wake = threading.Condition()
        threading.Thread(target=self._run, daemon=True).start()

    def move(self, moves: dict[int, Any]) -> None:
        """Requests a fit with moved points."""
        with self._wake:
            self.error = None
            self._wanted = dict(moves)
            self._wake.notify()

    def take(self) -> Update | None:
        """Returns the newest update once."""
        with self._wake:
            newest, self._newest = self._newest, None
            return newest

    def close(self) -> None:
        """Ends the thread after its current task."""
        with self._wake:
            self._closed = True
            self._wake.notify()

    def _run(self) -> None:
        job: Any = None
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._closed or self._wanted is not None)
                if self._closed:
                    return
                moves, self._wanted = self._wanted, None
            try:
                if job is None:
                    job = server.client(headers=_ONCE).job(self._job)
                self._follow(job, moves)
            except Exception as error:  # A thread must report any exception itself.
                self.error = server.in_words(error)

    def _follow(self, job: Any, moves: dict[int, Any]) -> None:
        places = {self._points.index(i): list(point) for i, point in moves.items()}
        method = method_of(self._points.with_moves(moves), self._settings)
        for level in job.preview(places, method=method, session=self._session, pace="latest"):
            with self._wake:
                self._newest = Update(level.geometry, level.number, level.error.max)
                if self._wanted is not None or self._closed:
                    return

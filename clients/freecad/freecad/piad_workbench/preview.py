"""Watches a fit in a thread, for a user interface that must not block."""

from __future__ import annotations

import threading
from typing import Any

from . import server
from .fitting import Follower, Update
from .points import Points
from .settings import Settings


class Preview:
    """A fit in a thread. It keeps only the newest update until it is taken."""

    def __init__(self, points: Points, settings: Settings):
        self.points = points
        self.settings = settings
        self.error: str | None = None
        """The message of an error, if there is one."""
        self._newest: Update | None = None
        self._follower: Follower | None = None
        self._cancelled = False
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def take(self) -> Update | None:
        """Returns the newest update once."""
        with self._lock:
            update, self._newest = self._newest, None
            return update

    @property
    def running(self) -> bool:
        """True if more updates are expected."""
        return self._thread.is_alive()

    @property
    def job(self) -> Any:
        """The job on the server, for edits; None before it is created and after it is cancelled."""
        return self._follower.job if self._follower else None

    def cancel(self) -> None:
        """Also cancels it on the server, without waiting. An ended one is deleted there."""
        with self._lock:
            self._cancelled = True
            follower = self._follower
        if follower is not None:
            threading.Thread(target=follower.cancel, daemon=True).start()

    def _run(self) -> None:
        try:
            self._follow(server.client())
        except Exception as error:  # A thread must report any exception itself.
            if not self._cancelled:
                self.error = server.in_words(error)

    def _follow(self, client: Any) -> None:
        with self._lock:
            if self._cancelled:
                return
            self._follower = Follower(client)
        for update in self._follower.updates(self.points, self.settings):
            with self._lock:
                self._newest = update

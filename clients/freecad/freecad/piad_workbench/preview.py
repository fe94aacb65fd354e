"""Follows a fit in a thread, for a user interface that must not wait."""

from __future__ import annotations

import threading
from typing import Any

from . import server
from .fitting import Follower, Update
from .points import Points
from .settings import Settings


class Preview:
    """A fit in a thread. It keeps the newest update until somebody takes it, and none before it."""

    def __init__(self, points: Points, settings: Settings):
        self.points = points
        self.settings = settings
        self.error: str | None = None
        """What went wrong, in words, once it has."""
        self._newest: Update | None = None
        self._follower: Follower | None = None
        self._cancelled = False
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def take(self) -> Update | None:
        """The newest update, once."""
        with self._lock:
            update, self._newest = self._newest, None
            return update

    @property
    def running(self) -> bool:
        """Whether updates are to come."""
        return self._thread.is_alive()

    @property
    def job(self) -> Any:
        """The job on the server, for edits; None before it is there and after it is cancelled."""
        return self._follower.job if self._follower else None

    def cancel(self) -> None:
        """Ends it on the server as well, without waiting for that. An ended one is forgotten there."""
        with self._lock:
            self._cancelled = True
            follower = self._follower
        if follower is not None:
            threading.Thread(target=follower.cancel, daemon=True).start()

    def _run(self) -> None:
        try:
            self._follow(server.client())
        except Exception as error:  # Whatever it is: a thread has nobody else to tell.
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

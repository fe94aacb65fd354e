"""Edits for dragging: fits that are streamed in the answer, and of which nothing is kept."""

from __future__ import annotations

import json
import threading
import uuid
from collections.abc import Iterator
from typing import Any

from . import server
from .fitting import Update, method_of
from .points import Points
from .settings import Settings


class Dragging:
    """A thread that fits for the newest position of the points, and leaves out those before it."""

    def __init__(self, job: str, points: Points, settings: Settings):
        self.error: str | None = None
        """What went wrong, in words, once it has."""
        self._job = job
        self._points = points
        self._settings = settings
        self._http = server.connection()
        self._session = uuid.uuid4().hex
        self._wanted: Any = None
        self._newest: Update | None = None
        self._closed = False
        self._wake = threading.Condition()
        threading.Thread(target=self._run, daemon=True).start()

    def move(self, moves: dict[int, Any]) -> None:
        """Asks for a fit with points elsewhere than the job has them."""
        with self._wake:
            self.error = None
            self._wanted = dict(moves)
            self._wake.notify()

    def take(self) -> Update | None:
        """The newest update, once."""
        with self._wake:
            newest, self._newest = self._newest, None
            return newest

    def close(self) -> None:
        """Ends the thread after what it is doing."""
        with self._wake:
            self._closed = True
            self._wake.notify()

    def _run(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._closed or self._wanted is not None)
                if self._closed:
                    self._http.close()
                    return
                moves, self._wanted = self._wanted, None
            try:
                for update in self._edit(moves):
                    with self._wake:
                        self._newest = update
                        if self._wanted is not None or self._closed:
                            break
            except Exception as error:  # Whatever it is: a thread has nobody else to tell.
                self.error = server.in_words(error)

    def _edit(self, moves: dict[int, Any]) -> Iterator[Update]:
        piad = server.piad()
        shape: Any = None
        last: Any = None
        for name, data in self._events(self._body(moves)):
            if name == "job":
                shape = piad.Shape.from_json(data)
            elif name == "iteration":
                last = piad.Iteration.from_json(data, shape)
                shape = last.shape
                yield Update(last.geometry, last.number, last.error.max)
            elif name == "end" and last is not None:
                yield Update(last.geometry, last.number, last.error.max, state=data["state"], detail=data.get("detail") or "")

    def _events(self, body: dict[str, Any]) -> Iterator[tuple[str, Any]]:
        """The client of piad has no ephemeral edits: a line of JSON for each event."""
        path = f"/v1/jobs/{self._job}/edits/stream"
        # Older versions of httpx send a body after the head, and on a connection that was used before the system
        # holds it back for 40 ms.
        headers = {"Accept": "application/x-ndjson", "Connection": "close"}
        with self._http.stream("POST", path, params={"pace": "latest"}, json=body, headers=headers) as answer:
            if not answer.is_success:
                raise RuntimeError(_detail(answer.read()))
            for line in answer.iter_lines():
                if line.strip():
                    event = json.loads(line)
                    yield event["event"], event["data"]

    def _body(self, moves: dict[int, Any]) -> dict[str, Any]:
        points = [{"index": self._points.index(i), "point": list(point)} for i, point in moves.items()]
        method = method_of(self._points.with_moves(moves), self._settings)
        return {"points": points, "method": method, "ephemeral": True, "session": self._session}


def _detail(answer: bytes) -> str:
    """What a server says of a request that it refuses."""
    try:
        return str(json.loads(answer)["detail"])
    except (ValueError, KeyError):
        return answer.decode(errors="replace")[:200]

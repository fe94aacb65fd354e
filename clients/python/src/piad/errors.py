"""Exceptions, which are all derived from `PiadError`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Optional


@dataclass(frozen=True)
class FieldError:
    """One error of a request."""

    detail: str
    """The reason."""
    pointer: Optional[str] = None
    """The value in the body, as a JSON pointer (RFC 6901)."""
    parameter: Optional[str] = None
    """The query parameter."""
    header: Optional[str] = None
    """The header."""
    line: Optional[int] = None
    """The line of a file of points, from 1."""


@dataclass(frozen=True)
class Problem:
    """A problem object (RFC 9457), in error responses and failed jobs."""

    type: str
    """Such as "/problems/invalid-fit", which is also the path of its description; "about:blank" for responses of other
    servers."""
    title: str
    status: int
    """The HTTP status."""
    detail: str
    errors: tuple[FieldError, ...] = ()
    request_id: Optional[str] = None

    @property
    def pointers(self) -> tuple[str, ...]:
        """JSON pointers to the invalid values of the body."""
        return tuple(error.pointer for error in self.errors if error.pointer is not None)

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Problem:
        """Parses a problem object; missing fields are empty."""
        names = ("pointer", "parameter", "header", "line")
        errors = (
            FieldError(error.get("detail", ""), **{name: error.get(name) for name in names})
            for error in value.get("errors", ())
        )
        return cls(
            value.get("type", "about:blank"),
            value.get("title", ""),
            value.get("status", 0),
            value.get("detail", ""),
            tuple(errors),
            value.get("request_id"),
        )


class PiadError(Exception):
    """The base of all exceptions of this package."""


@dataclass
class ApiError(PiadError):
    """The server rejected a request."""

    problem: Problem
    retry_after: Optional[float] = field(default=None)
    """The delay in seconds requested by the server (`Retry-After`)."""

    @property
    def status(self) -> int:
        """The HTTP status."""
        return self.problem.status

    def __str__(self) -> str:
        return f"{self.status} {self.problem.title}: {self.problem.detail}"


class ConnectionLost(PiadError):
    """The server was unreachable or the connection broke on each attempt."""


class ServerNotStarted(PiadError):
    """A fit without the URL of a server needs one of this process, and that cannot be started."""


class ProtocolError(PiadError):
    """The response does not conform to this API."""


@dataclass
class JobFailed(PiadError):
    """A job ended without a result."""

    id: str
    state: str
    """"failed" or "cancelled"."""
    problem: Optional[Problem] = None
    """Why it failed."""

    def __str__(self) -> str:
        why = "" if self.problem is None else f": {self.problem.detail}"
        return f"the job {self.id} is {self.state}{why}"


class NotConverged(UserWarning):
    """A fit has ended outside its tolerance, or was cancelled."""


class WaitTimeout(PiadError, TimeoutError):
    """A job has not ended within the timeout. It continues."""


class MissingPackage(PiadError, ImportError):
    """An optional package is not installed, or cannot be loaded."""

    def __init__(self, module: str, package: str, why: str | None = None):
        super().__init__(f"{module} is needed for this and cannot be imported: {why or f'pip install {package}'}", name=module)
        self.package = package
        """The name of the package."""

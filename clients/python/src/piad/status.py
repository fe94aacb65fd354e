"""States of jobs, from the JSON of the server."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Optional

from .errors import Problem
from .iteration import Distances

State = Literal["queued", "running", "converged", "exhausted", "stalled", "failed", "cancelled"]


@dataclass(frozen=True)
class JobWarning:
    """A warning about a fit that is computed nevertheless."""

    code: str
    """The kind, such as "few_points"."""
    pointer: str
    """A JSON pointer to the input concerned, such as "/curve/basis/degree"."""
    detail: str
    """The reason, and a remedy."""

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> JobWarning:
        """Reads a warning."""
        return cls(value["code"], value["pointer"], value["detail"])


@dataclass(frozen=True)
class Status:
    """A snapshot of a job."""

    id: str
    name: Optional[str]
    kind: Literal["curve", "surface"]
    state: State
    reason: Optional[str]
    """The reason for the end of a job, such as "minimum" or "convexity"."""
    detail: Optional[str]
    """The reason as text, with the remaining distance."""
    warnings: tuple[JobWarning, ...]
    """Warnings about the fit; some are found only when the job runs."""
    points: int
    method: Mapping[str, Any]
    """The method, with its computed settings."""
    stop: Mapping[str, Any]
    """The tolerance in data units, and `max_iterations`."""
    stream: Optional[Mapping[str, Any]]
    iteration: Optional[int]
    predicted: Mapping[str, Any]
    """The predicted `rate` and total `iterations`; None if unknown."""
    error: Optional[Distances]
    progress: float
    """From 0 to 1."""
    created_at: str
    started_at: Optional[str]
    finished_at: Optional[str]
    """Times in RFC 3339 format."""
    parent: Optional[Mapping[str, Any]] = None
    """The parent of an edit: `id` and `iteration`."""
    problem: Optional[Problem] = None
    """Why the job failed."""

    def __repr__(self) -> str:
        at = "" if self.iteration is None else f", iteration {self.iteration}"
        return f"<piad.Status of job {self.id}: {self.state}{at}>"

    @property
    def ended(self) -> bool:
        """True if the job has ended."""
        return self.state not in ("queued", "running")

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> Status:
        """Reads a job."""
        fields = {name: value[name] for name in _FIELDS}
        error, problem = value["error"], value.get("problem")
        return cls(
            **fields,
            detail=value.get("detail"),
            predicted=value.get("predicted", {}),
            warnings=tuple(JobWarning.from_json(it) for it in value.get("warnings", ())),
            error=None if error is None else Distances.from_json(error),
            parent=value.get("parent"),
            problem=None if problem is None else Problem.from_json(problem),
        )


_FIELDS = (
    "id",
    "name",
    "kind",
    "state",
    "reason",
    "points",
    "method",
    "stop",
    "stream",
    "iteration",
    "progress",
    "created_at",
    "started_at",
    "finished_at",
)

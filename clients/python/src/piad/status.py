"""How jobs stand, from the JSON of the server."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, Optional

from .errors import Problem
from .iteration import Distances

State = Literal["queued", "running", "converged", "exhausted", "stalled", "failed", "cancelled"]


@dataclass(frozen=True)
class JobWarning:
    """What is doubtful about a fit that is computed even so."""

    code: str
    """What it is, such as "few_points"."""
    pointer: str
    """The part of the job's input that it is about, such as "/curve/basis/degree"."""
    detail: str
    """Why it is doubtful, and what to do about it."""

    @classmethod
    def from_json(cls, value: Mapping[str, Any]) -> JobWarning:
        """Reads a warning."""
        return cls(value["code"], value["pointer"], value["detail"])


@dataclass(frozen=True)
class Status:
    """A job as it stood when the server was asked."""

    id: str
    name: Optional[str]
    kind: Literal["curve", "surface"]
    state: State
    reason: Optional[str]
    """Why a job ended as it did, such as "minimum" or "convexity"."""
    detail: Optional[str]
    """The reason in words, with the distance that is left."""
    warnings: tuple[JobWarning, ...]
    """What is doubtful about the fit; some of it is known only when the job runs."""
    points: int
    method: Mapping[str, Any]
    """With the numbers that were computed for it."""
    stop: Mapping[str, Any]
    """The tolerance in data units, and `max_iterations`."""
    stream: Optional[Mapping[str, Any]]
    iteration: Optional[int]
    predicted: Mapping[str, Any]
    """`rate` and `iterations` in all, by what is known at that iteration; None where nobody knows."""
    error: Optional[Distances]
    progress: float
    """From 0 to 1."""
    created_at: str
    started_at: Optional[str]
    finished_at: Optional[str]
    """Times as in RFC 3339."""
    parent: Optional[Mapping[str, Any]] = None
    """Of an edit: `id` and `iteration`."""
    problem: Optional[Problem] = None
    """Why the job failed."""

    def __repr__(self) -> str:
        at = "" if self.iteration is None else f", iteration {self.iteration}"
        return f"<piad.Status of job {self.id}: {self.state}{at}>"

    @property
    def ended(self) -> bool:
        """Whether the job goes no further."""
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

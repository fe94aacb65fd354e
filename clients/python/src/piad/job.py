"""Jobs: fits on the server."""

from __future__ import annotations

from ._blocking import iterating, method, same
from .async_job import AsyncJob
from .status import Status


class Job:
    """A job and its operations."""

    def __init__(self, job: AsyncJob):
        self._async = job

    def __repr__(self) -> str:
        return f"<piad.Job {self.id}: {self.status.state}>"

    @property
    def id(self) -> str:
        """The id."""
        return self._async.id

    @property
    def status(self) -> Status:
        """The last state received from the server; `refresh` updates it."""
        return self._async.status

    refresh = same(AsyncJob.refresh)
    iterations = iterating(AsyncJob.iterations)
    shape = same(AsyncJob.shape)
    iteration = same(AsyncJob.iteration)
    samples = same(AsyncJob.samples)
    wait = same(AsyncJob.wait)
    result = same(AsyncJob.result)
    deviation = same(AsyncJob.deviation)
    curvature = same(AsyncJob.curvature)
    input = same(AsyncJob.input)
    ticket = same(AsyncJob.ticket)
    cancel = same(AsyncJob.cancel)
    delete = same(AsyncJob.delete)
    edit = method(AsyncJob.edit, lambda job: Job(job))
    preview = iterating(AsyncJob.preview)
    download = same(AsyncJob.download)

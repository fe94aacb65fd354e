"""The client."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import TracebackType
from typing import Optional

import httpx

from ._blocking import iterate, making, method, same
from ._connections import BlockingConnections
from ._place import place
from ._service import Service
from ._transport import Transport, settings
from .batch import Batch
from .job import Job
from .status import State


class Client:
    """A connection to a server, which must be closed; use it as a context manager.

    It may be used from several threads.
    """

    def __init__(
        self,
        base_url: Optional[str] = None,
        *,
        timeout: float = 60.0,
        attempts: int = 8,
        token: Optional[str] = None,
        headers: Optional[Mapping[str, str]] = None,
        transport: Optional[httpx.BaseTransport] = None,
    ):
        """Without a `base_url` the client uses the one in PIAD_URL, with the token in PIAD_TOKEN, or a server that is
        started for this process, is shared by its clients and ends with it. `timeout` is the longest silence of the
        server in seconds. `attempts` is the maximum number of times a request is sent, or a stream is opened without
        receiving an iteration, while connections break or the server is overloaded. A missing server is detected
        within two seconds. `token` is created by `piad token create`, for a server that requires one. `headers` are
        sent with each request. `transport` is an httpx transport, for proxies, certificates, Unix sockets and tests.
        """
        where = place(base_url, token, has_transport=transport is not None)
        connections = BlockingConnections(transport, where.socket, **settings(where.url, timeout, where.token, headers))
        self._async = Service(Transport(connections, attempts=attempts), timeout)

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self,
        kind: Optional[type[BaseException]],
        error: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self.close()

    close = same(Service.close)
    create = method(Service.create, Job)
    fit = same(Service.fit)
    job = method(Service.job, Job)
    read_points = same(Service.read_points)
    fit_file = same(Service.fit_file)
    capabilities = same(Service.capabilities)

    batch = making(Service.batch, Batch)

    def jobs(self, state: Optional[State] = None, *, page: int = 100) -> Iterator[Job]:
        """All jobs, newest first, fetched as they are used, `page` (1 to 1000) at a time."""
        return map(Job, iterate(self._async.jobs(state, page=page)))

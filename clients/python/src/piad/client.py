"""The client: where fits begin."""

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
    """A connection to a server, to be closed at the end; a context manager does that.

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
        """Without a `base_url` it is that in the variable PIAD_URL, with the token in PIAD_TOKEN, or that of a server
        which is started for this process, is shared by its clients and ends with it. `timeout` is how many seconds the server may be silent, `attempts` how often a request is
        sent, or a stream opened again without an iteration in between, while connections break or
        the server has no room. Where no server is, this is known within two seconds. `token` is one
        of `piad token create`, for a server that asks for one. `headers` go with every request.
        `transport` is one of httpx, for proxies, certificates, Unix sockets and tests.
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
        """All jobs, the newest first; asked for as they are used, `page` (1 to 1000) at a time."""
        return map(Job, iterate(self._async.jobs(state, page=page)))

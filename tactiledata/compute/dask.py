"""Tasks on a Dask cluster that is already running and sees the same files."""

from __future__ import annotations

import asyncio
import logging
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from tactiledata.compute.base import Outcome, R, Scheduler, T, attempt_afar, in_order
from tactiledata.contract.extras import missing_package
from tactiledata.errors import TactileDataError, UsageError

logger = logging.getLogger(__name__)

CONNECT_TIMEOUT = 20.0
"""Seconds to wait for the scheduler to answer."""
STARTING_TIMEOUT = 3.0
"""Seconds to wait where the machine answers, but nobody listens at the port: a scheduler may be starting."""
WORKER_TIMEOUT = 60.0
"""Seconds to wait for a first worker, and for another one once all are lost."""
LOOK_AGAIN = 5.0
"""Seconds of waiting for a task after which it is looked whether there still are workers."""
LARGEST_TASK = "1GB"
"""Size of a task from which on Dask warns. Few are on their way at a time, and the networks of a transfer are large."""


class DaskScheduler(Scheduler):
    """Runs tasks on the workers of a Dask cluster.

    Parameters
    ----------
    address : str
        Address of the Dask scheduler, for example ``"tcp://10.0.0.5:8786"``. Its workers must have this package
        installed and see the same paths.
    """

    def __init__(self, address: str) -> None:
        self.address = address

    def outcomes(
        self, function: Callable[[T], R], tasks: Sequence[T], ahead: int | None = None
    ) -> Iterator[Outcome[T, R]]:
        """Yield one `Outcome` per task in order.

        Tasks of a worker that dies go to another one.

        Parameters
        ----------
        function : callable
            Is called with each task.
        tasks : sequence
            The tasks.
        ahead : int, optional
            See `Scheduler.outcomes`.

        Raises
        ------
        UsageError
            The package is missing, no scheduler answers, or it has no workers.
        TactileDataError
            Workers died again and again at one task, all workers were lost, or the scheduler was.
        """
        try:
            from dask import config
            from distributed import Client
            from distributed.comm import get_address_host_port
        except ImportError as error:
            raise missing_package("distributed", "--scheduler") from error
        try:
            # a client of an address that is none would not end by itself
            timeout = _patience(*get_address_host_port(self.address))
            client = Client(self.address, timeout=timeout, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise UsageError(
                f"no Dask scheduler answers at {self.address!r} ({error})",
                "the address of a running scheduler, like tcp://host:8786",
                "Start a scheduler with `dask scheduler`, or use --workers N.",
            ) from error
        few_warnings = config.set({"distributed.admin.large-graph-warning-threshold": LARGEST_TASK})
        with _without_log("distributed.client"), client, few_warnings:
            self._need_workers(client)
            most = max(ahead or 0, 4, 2 * sum(client.ncores().values()))
            yield from in_order(
                tasks,
                lambda task: client.submit(attempt_afar, function, task, pure=False),
                lambda task, future: self._collect(client, task, future),
                most,
            )

    def _need_workers(self, client: Any) -> None:
        """Refuse a scheduler without workers: tasks would wait for ever."""
        if not client.ncores():
            # the logger of last resort prints it; a library must not print by itself
            logger.warning("waiting for workers at %s, for up to %g s", self.address, WORKER_TIMEOUT)
        try:
            client.wait_for_workers(1, timeout=WORKER_TIMEOUT)
        except TimeoutError as error:
            raise UsageError(
                f"the Dask scheduler at {self.address!r} has no workers",
                "one or more",
                f"Start some with `dask worker {self.address}`, where the files are seen at the same paths.",
            ) from error

    def _collect(self, client: Any, task: Any, future: Any) -> Outcome[Any, Any]:
        """Return the outcome of a submitted task; a cluster that failed becomes an error of ours."""
        from distributed import CancelledError, KilledWorker

        try:
            outcome = self._result(client, task, future)
            future.release()  # a worker that is lost later does not do it again
            return replace(outcome, task=task)
        except KilledWorker as error:
            raise TactileDataError(
                f"workers of the Dask cluster died again and again at {str(task)[:300]}",
                "",
                "Most often they ran out of memory: give them more, or start fewer on a machine. Run the command again "
                "to go on; finished tasks are kept.",
            ) from error
        except (CancelledError, OSError) as error:
            if future.status == "error":  # the task's own
                raise
            raise TactileDataError(
                f"the Dask scheduler at {self.address!r} was lost at {str(task)[:300]}",
                "",
                "Start it anew, and run the command again to go on; finished tasks are kept.",
            ) from error

    def _result(self, client: Any, task: Any, future: Any) -> Outcome[None, Any]:
        """Return what a task gave; a cluster that has lost all of its workers for long would never send it."""
        lost_since: float | None = None
        sent = client.gather(future, asynchronous=True)
        gathered = asyncio.run_coroutine_threadsafe(sent, client.loop.asyncio_loop)
        while True:
            try:
                outcome: Outcome[None, Any] = gathered.result(timeout=LOOK_AGAIN)
                return outcome
            except TimeoutError:
                if gathered.done():  # the task's own
                    raise
                lost_since = None if client.ncores() else lost_since or time.monotonic()
            if lost_since is not None and time.monotonic() - lost_since >= WORKER_TIMEOUT:
                raise TactileDataError(
                    f"the Dask cluster at {self.address!r} has lost all its workers at {str(task)[:300]}",
                    f"a worker within {WORKER_TIMEOUT:g} s",
                    "Most often they ran out of memory, or their machines were taken back. Start new ones, and run the "
                    "command again to go on; finished tasks are kept.",
                )


def _patience(host: str, port: int) -> float:
    """Return for how many seconds a client tries to reach a scheduler: few if the machine refuses the connection.

    Raises
    ------
    OSError
        There is no such machine, or it does not answer.
    """
    try:
        socket.create_connection((host, port), CONNECT_TIMEOUT).close()
    except ConnectionRefusedError:
        return min(STARTING_TIMEOUT, CONNECT_TIMEOUT)
    return CONNECT_TIMEOUT


@contextmanager
def _without_log(name: str) -> Iterator[None]:
    """Silence a logger inside the block: a lost scheduler would be told as tracebacks, beside the error of ours."""
    logger = logging.getLogger(name)
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)

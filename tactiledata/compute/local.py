"""Tasks in this process (one worker) or on local processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from tactiledata.compute.base import Outcome, R, Scheduler, T, attempt, attempt_afar, in_order
from tactiledata.contract.worker_pool import need_workers, worker_died, worker_pool
from tactiledata.errors import TactileDataError


class LocalScheduler(Scheduler):
    """Runs tasks on local processes; with one worker it starts no process.

    Parameters
    ----------
    workers : int
        Number of tasks that run at a time, at least 1.
    """

    def __init__(self, workers: int = 1) -> None:
        need_workers(workers)
        self.workers = workers
        self._pool: ProcessPoolExecutor | None = None

    def outcomes(
        self, function: Callable[[T], R], tasks: Sequence[T], ahead: int | None = None
    ) -> Iterator[Outcome[T, R]]:
        """Yield one `Outcome` per task in order.

        Parameters
        ----------
        function : callable
            Is called with each task.
        tasks : sequence
            The tasks.
        ahead : int, optional
            See `Scheduler.outcomes`.
        """
        if self.workers == 1 or len(tasks) < 2:
            for task in tasks:
                yield attempt(function, task)
            return
        with self._lent() as pool:
            yield from in_order(
                tasks,
                lambda task: _submitted(pool, function, task),
                _collect,
                max(ahead or 0, 2 * self.workers),
                Future.cancel,
            )

    @contextmanager
    def kept_open(self) -> Iterator[Scheduler]:
        """Yield this scheduler; its processes start once for all runs within the block, and end with it."""
        if self.workers == 1:
            yield self
            return
        with worker_pool(self.workers) as pool:
            self._pool = pool
            try:
                yield self
            finally:
                self._pool = None

    @contextmanager
    def _lent(self) -> Iterator[ProcessPoolExecutor]:
        """Yield the pool that is kept open, or one of this run; a pool whose worker died is not used again."""
        if self._pool is None:
            with worker_pool(self.workers) as pool:
                yield pool
            return
        try:
            yield self._pool
        except TactileDataError as error:
            if isinstance(error.__cause__, BrokenProcessPool):
                self._pool = None
            raise


def _submitted(pool: ProcessPoolExecutor, function: Callable[[Any], Any], task: Any) -> Future[Outcome[None, Any]]:
    """Return the future of a task; a pool whose worker died becomes an error of ours."""
    try:
        return pool.submit(attempt_afar, function, task)
    except BrokenProcessPool as error:
        raise worker_died(task) from error


def _collect(task: Any, future: Future[Outcome[None, Any]]) -> Outcome[Any, Any]:
    """Return the outcome of a submitted task once it is done; a worker that died becomes an error of ours."""
    try:
        return replace(future.result(), task=task)
    except BrokenProcessPool as error:
        raise worker_died(task) from error

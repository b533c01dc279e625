"""Tasks in this process (one worker) or on local processes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from tactiledata.compute.base import Outcome, R, Scheduler, T, attempt
from tactiledata.contract.worker_pool import worker_pool
from tactiledata.errors import TactileDataError, UsageError


class LocalScheduler(Scheduler):
    """Local processes; with one worker, no process is started.

    Parameters
    ----------
    workers : int
        How many tasks run at a time, at least 1.
    """

    def __init__(self, workers: int = 1) -> None:
        if workers < 1:
            raise UsageError(f"{workers} workers", "at least 1", "Leave --workers out to run in one process.")
        self.workers = workers

    def outcomes(self, function: Callable[[T], R], tasks: Sequence[T]) -> Iterator[Outcome[T, R]]:
        """See `Scheduler.outcomes`."""
        if self.workers == 1 or len(tasks) < 2:
            for task in tasks:
                yield attempt(function, task)
            return
        waiting: deque[tuple[T, Future[Outcome[Any, Any]]]] = deque()
        with worker_pool(self.workers) as pool:
            for task in tasks:
                waiting.append((task, _submitted(pool, function, task)))
                if len(waiting) >= 2 * self.workers:
                    yield _collect(*waiting.popleft())
            while waiting:
                yield _collect(*waiting.popleft())


def _submitted(pool: ProcessPoolExecutor, function: Callable[[Any], Any], task: Any) -> Future[Outcome[Any, Any]]:
    try:
        return pool.submit(attempt, function, task)
    except BrokenProcessPool as error:
        raise _death(task) from error


def _collect(task: Any, future: Future[Outcome[Any, Any]]) -> Outcome[Any, Any]:
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise _death(task) from error


def _death(task: Any) -> TactileDataError:
    return TactileDataError(
        f"a worker process died while it, or another worker, was at {str(task)[:300]}",
        "",
        "Most often the machine ran out of memory: use fewer --workers. (A Python script that starts workers must "
        "do so under `if __name__ == '__main__':`.) Run it again to go on; what is finished is kept.",
    )

"""A scheduler of one's own: tasks on threads, for work that waits for a network rather than for a processor."""

from concurrent.futures import ThreadPoolExecutor

from tactiledata.compute.base import Scheduler, attempt


class ThreadScheduler(Scheduler):
    """Threads of this process."""

    def __init__(self, workers: int = 4) -> None:
        self.workers = workers

    def outcomes(self, function, tasks, ahead=None):
        """Results in the order of the tasks, as every scheduler gives them."""
        with ThreadPoolExecutor(self.workers) as pool:
            yield from pool.map(lambda task: attempt(function, task), tasks)

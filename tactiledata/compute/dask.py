"""Tasks on a Dask cluster that is already running and sees the same files."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence

from tactiledata.compute.base import Outcome, R, Scheduler, T, attempt
from tactiledata.errors import UsageError

CONNECT_TIMEOUT = 20.0
"""Seconds to wait for the scheduler to answer."""


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

    def outcomes(self, function: Callable[[T], R], tasks: Sequence[T]) -> Iterator[Outcome[T, R]]:
        """Yield one `Outcome` per task in order; refuse a scheduler that does not answer."""
        try:
            from distributed import Client
        except ImportError as error:
            raise UsageError(
                "the package 'distributed' is not installed",
                "this package, for --scheduler",
                "pip install 'tactiledata[dask]'",
            ) from error
        try:
            client = Client(self.address, timeout=CONNECT_TIMEOUT, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise UsageError(
                f"no Dask scheduler answers at {self.address!r} ({error})",
                "the address of a running scheduler, like tcp://host:8786",
                "Start a scheduler with `dask scheduler`, or use --workers N.",
            ) from error
        with client:
            ahead = max(4, 2 * sum(client.ncores().values()))
            waiting: deque = deque()
            for task in tasks:
                waiting.append(client.submit(attempt, function, task, pure=False))
                if len(waiting) >= ahead:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()

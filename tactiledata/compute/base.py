"""What every scheduler offers: results of independent tasks, in the order of the tasks, with bounded memory."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar, cast

from tactiledata.compute.threads import one_thread
from tactiledata.errors import TactileDataError

T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Outcome(Generic[T, R]):
    """The outcome of one task: a result, or the error that ended it."""

    task: T
    result: R | None
    error: TactileDataError | None

    @property
    def is_ok(self) -> bool:
        """Whether the task gave a result."""
        return self.error is None

    @property
    def value(self) -> R:
        """The result of the task; where an error ended it, that error is raised."""
        if self.error is not None:
            raise self.error
        return cast(R, self.result)


class Scheduler(ABC):
    """Runs one function over many tasks.

    The function and the tasks must pickle. An error of the toolkit's own tree ends its task only; any other error is a
    fault of ours and ends the run.
    """

    @abstractmethod
    def outcomes(
        self, function: Callable[[T], R], tasks: Sequence[T], ahead: int | None = None
    ) -> Iterator[Outcome[T, R]]:
        """Yield one `Outcome` per task, in the order of ``tasks``.

        Parameters
        ----------
        function : callable
            Is called with each task.
        tasks : sequence
            The tasks.
        ahead : int, optional
            Largest number of tasks that are begun before the reader has their results. The default is two for each
            worker, which bounds memory; where results are small, more keep workers busy behind a slow task.
        """

    def kept_open(self) -> AbstractContextManager[Scheduler]:
        """Return a block within which the workers of one run serve the next, where they would be started anew."""
        return nullcontext(self)


def in_order(
    tasks: Sequence[T],
    begin: Callable[[T], Any],
    end: Callable[[T, Any], Outcome[T, R]],
    ahead: int,
    drop: Callable[[Any], object] = lambda begun: None,
) -> Iterator[Outcome[T, R]]:
    """Yield the outcome of each task in order, while a limited number of tasks is under way.

    Parameters
    ----------
    tasks : sequence
        The tasks.
    begin : callable
        Begins a task; returns what stands for its outcome.
    end : callable
        Waits for the outcome of a task, from the task and what stands for its outcome.
    ahead : int
        Largest number of tasks under way.
    drop : callable
        Called with what stands for the outcome of each task that is still under way when the reader stops.
    """
    waiting: deque[tuple[T, Any]] = deque()
    try:
        for task in tasks:
            waiting.append((task, begin(task)))
            if len(waiting) >= ahead:
                yield end(*waiting.popleft())
        while waiting:
            yield end(*waiting.popleft())
    finally:
        for _, begun in waiting:
            drop(begun)


def attempt_afar(function: Callable[[Any], Any], task: Any) -> Outcome[None, Any]:
    """Run one task and return its outcome without the task; workers execute this function.

    Who sent the task has it still: only results travel back, and what a task keeps of its work need not pickle.
    """
    return replace(attempt(function, task), task=None)


def attempt(function: Callable[[Any], Any], task: Any) -> Outcome[Any, Any]:
    """Run one task in this process and return its outcome.

    Linear algebra has one thread: workers share the cores, and a result does not depend on their number.
    """
    try:
        with one_thread():
            return Outcome(task, function(task), None)
    except TactileDataError as error:
        return Outcome(task, None, error)

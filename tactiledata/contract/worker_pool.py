"""Pools of worker processes, and queues between them, that never outlive the process that started them."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.managers import SyncManager
from queue import Queue
from typing import Any

from tactiledata.errors import TactileDataError, UsageError

ORPHANED = 1
"""Exit status of a worker whose parent is gone."""
GRACE_S = 0.5
"""Time, s, in which a worker leaves its task when its parent has ended: what it was writing is then removed."""
WARNINGS = "PYTHONWARNINGS"
"""Variable of the environment that says which warnings a process of Python prints."""
NO_LEAKS = "ignore:resource_tracker"
"""The tracker of a parent that was killed removes its semaphores; that it had to is no news for anybody."""


class StartedWorker(SpawnProcess):
    """A process that no interrupt of the terminal meets before it is prepared, and whose start is not cut off by one.

    An interrupt that comes meanwhile is raised in the parent once the process has started.
    """

    def start(self) -> None:
        """Start the process; it begins with interrupts blocked, as it takes over the mask of this thread."""
        with _interrupts_kept():
            super().start()

    def run(self) -> None:
        """Do the process's work; where the parent is gone there is nobody to tell."""
        try:
            super().run()
        except (BrokenPipeError, ConnectionResetError, EOFError):
            raise SystemExit(ORPHANED) from None


class WorkerContext(SpawnContext):
    """A way to start processes: from nothing, with interrupts blocked.

    A forked child would inherit locks of libraries that run threads (tensorstore, OpenCV), and the pipe's end.
    """

    Process = StartedWorker


@contextmanager
def _interrupts_kept() -> Iterator[None]:
    """Keep interrupts until the block has ended; the mask of this thread is also that of processes it starts."""
    # starting the tracker ends any mask
    _start_tracker()
    kept: list[int] = []
    is_main = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, lambda number, _: kept.append(number)) if is_main else None
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        # the one that waits is delivered now, to the handler that notes it
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if is_main:
            signal.signal(signal.SIGINT, before)
    if kept:
        signal.raise_signal(signal.SIGINT)


def _start_tracker() -> None:
    """Start the process that removes semaphores which nobody else removes, and let it do so without a word."""
    told = os.environ.get(WARNINGS)
    os.environ[WARNINGS] = NO_LEAKS if told is None else f"{told},{NO_LEAKS}"
    try:
        resource_tracker.ensure_running()
    finally:
        if told is None:
            del os.environ[WARNINGS]
        else:
            os.environ[WARNINGS] = told


@contextmanager
def worker_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of processes that end when the block is left by an error, or when the parent process dies.

    Each worker waits, in a thread, for the end of a pipe whose other end the parent alone holds. The parent closes it
    when an exception (an interrupt, too) leaves the block; the operating system closes it when the parent is killed.
    After a block without an error, tasks that were submitted are finished first.

    Parameters
    ----------
    workers : int
        Number of processes, at least 1.
    """
    _start_tracker()
    context = WorkerContext()
    watched, held = context.Pipe(duplex=False)
    with watched, held, ProcessPoolExecutor(workers, context, _end_with_parent, (watched,)) as pool:
        try:
            yield pool
        except BaseException:
            held.close()
            # workers end by themselves now; a pool that is not waited for complains when this process ends
            pool.shutdown(wait=True, cancel_futures=True)
            raise


@contextmanager
def shared_queue() -> Iterator[Queue[Any]]:
    """Yield a queue that can be handed to tasks of a pool, for what they say while they run.

    The process that keeps it ends with the block, and as the workers do when the parent process dies.
    """
    _start_tracker()
    context = WorkerContext()
    watched, held = context.Pipe(duplex=False)
    manager = SyncManager(ctx=context)
    with watched, held:
        manager.start(_end_with_parent, (watched,))
        with manager:
            yield manager.Queue()


def need_workers(workers: int) -> None:
    """Refuse a number of processes that does no work.

    Raises
    ------
    UsageError
        There are fewer than one.
    """
    if workers < 1:
        raise UsageError(f"{workers} workers", "at least 1", "Leave --workers out to run in one process.")


def worker_died(task: object) -> TactileDataError:
    """Return the error for a worker process that died near a task."""
    return TactileDataError(
        f"a worker process died while the workers were at {str(task)[:300]}",
        "",
        "Most often the machine ran out of memory: use fewer --workers. (A Python script that starts workers must "
        "do so under `if __name__ == '__main__':`.) Run the command again to go on; finished tasks are kept.",
    )


def _end_with_parent(watched: Connection) -> None:
    """Prepare a worker: an interrupt of the terminal is the parent's to handle, and the parent's end is its own."""
    is_orphan = threading.Event()

    def leave(number: int, frame: Any) -> None:
        """Leave the task where the parent is gone, so that its `finally` blocks run."""
        if is_orphan.is_set():
            raise SystemExit(ORPHANED)

    signal.signal(signal.SIGINT, leave)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    main = threading.get_ident()
    threading.Thread(target=_exit_at_end, args=(watched, is_orphan, main), daemon=True).start()


def _exit_at_end(watched: Connection, is_orphan: threading.Event, main: int) -> None:
    watched.poll(None)
    is_orphan.set()
    signal.pthread_kill(main, signal.SIGINT)
    time.sleep(GRACE_S)
    # the main thread may be deep in a computation: nothing but the process itself can be ended
    os._exit(ORPHANED)

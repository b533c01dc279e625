"""Pools of worker processes, and queues between them, that never outlive the process that started them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.managers import SyncManager
from queue import Queue
from typing import Any

from tactiledata.errors import TactileDataError

ORPHANED = 1
"""Exit status of a worker whose parent is gone."""


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
    # spawn: a forked child would inherit locks of libraries that run threads (tensorstore, OpenCV), and the pipe's end
    context = multiprocessing.get_context("spawn")
    watched, held = context.Pipe(duplex=False)
    with watched, held, ProcessPoolExecutor(workers, context, _end_with_parent, (watched,)) as pool:
        try:
            yield pool
        except BaseException:
            held.close()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def shared_queue() -> Iterator[Queue[Any]]:
    """Yield a queue that can be handed to tasks of a pool, for what they say while they run.

    The process that keeps it ends with the block, and as the workers do when the parent process dies.
    """
    context = multiprocessing.get_context("spawn")
    watched, held = context.Pipe(duplex=False)
    manager = SyncManager(ctx=context)
    with watched, held:
        manager.start(_end_with_parent, (watched,))
        with manager:
            yield manager.Queue()


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
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_at_end, args=(watched,), daemon=True).start()


def _exit_at_end(watched: Connection) -> None:
    watched.poll(None)
    # the main thread may be deep in a computation: nothing but the process itself can be ended
    os._exit(ORPHANED)

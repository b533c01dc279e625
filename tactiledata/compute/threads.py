"""Threads of the libraries that multiply matrices."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep linear algebra to one thread while a block, or the decorated function, runs.

    Matrices of some hundred rows are multiplied in microseconds. Threads of OpenBLAS and OpenMP wait for the next
    product by spinning: with two of them a naming takes four times as much of the processors, and no less time.
    """
    with threadpool_limits(limits=1):
        yield

"""Peak memory of a new process that calls one function."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tactiledata.contract.worker_pool import worker_pool

STATUS = Path("/proc/self/status")
"""Linux' file with a process's peak memory."""


def peak_memory(work: Callable[..., Any], *arguments: Any) -> float:
    """Peak resident memory, MB, of a new process that calls ``work(*arguments)`` once; all must be picklable.

    It includes Python, its libraries and the unpickled arguments.
    """
    with worker_pool(1) as pool:
        # plain pickles: PyTorch would share the memory of tensors that queues send, and so change what is measured
        return pool.submit(_measured, pickle.dumps((work, arguments))).result()


def _measured(pickled: bytes) -> float:
    """Peak resident memory, MB, of this process after calling the pickled function."""
    work, arguments = pickle.loads(pickled)
    work(*arguments)
    if STATUS.exists():
        # getrusage would give the peak of the process that started this one where that was larger
        line = next(status_line for status_line in STATUS.read_text().splitlines() if status_line.startswith("VmHWM"))
        return int(line.split()[1]) * 1024 / 1e6
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6

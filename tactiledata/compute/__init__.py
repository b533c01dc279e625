"""Schedulers: where independent tasks run.

`base` states what every scheduler offers: results in the order of the tasks, with bounded memory.
`local` runs tasks in this process or on local processes.
`dask` sends tasks to a Dask cluster that sees the same files.
`threads` keeps linear algebra to one thread where its matrices are small.

The functions are the same everywhere, and so are their results. The room knows nothing of recordings or stores.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tactiledata.errors import UsageError
from tactiledata.registry import Registry

if TYPE_CHECKING:
    from tactiledata.compute.base import Scheduler

SCHEDULERS = Registry(
    "scheduler",
    {
        "local": "tactiledata.compute.local:LocalScheduler",
        "dask": "tactiledata.compute.dask:DaskScheduler",
    },
)


def make_scheduler(workers: int = 1, address: str | None = None) -> Scheduler:
    """Return the scheduler that runs tasks: a Dask cluster at an address, or local processes.

    Parameters
    ----------
    workers : int
        Number of local processes; one starts none.
    address : str, optional
        Address of a running Dask scheduler, which then takes all tasks.

    Raises
    ------
    UsageError
        Fewer than one worker, or several beside an address.
    """
    if address and workers != 1:
        raise UsageError(
            f"--workers {workers} beside --scheduler {address}",
            "one of them",
            "Leave out --workers: the cluster has workers of its own.",
        )
    made: Scheduler = SCHEDULERS["dask"](address) if address else SCHEDULERS["local"](workers)
    return made

"""Schedulers: where independent tasks run.

`base` states what every scheduler offers: results in the order of the tasks, with bounded memory.
`local` runs tasks in this process or on local processes.
`dask` sends tasks to a Dask cluster that sees the same files.

The functions are the same everywhere, and so are their results. The room knows nothing of recordings or stores.
"""

from tactiledata.registry import Registry

SCHEDULERS = Registry(
    "scheduler",
    {
        "local": "tactiledata.compute.local:LocalScheduler",
        "dask": "tactiledata.compute.dask:DaskScheduler",
    },
)

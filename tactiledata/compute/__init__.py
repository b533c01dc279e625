"""Where independent tasks run: in this process, on local processes, or on a Dask cluster; the same functions."""

from tactiledata.registry import Registry

SCHEDULERS = Registry(
    "scheduler",
    {
        "local": "tactiledata.compute.local:LocalScheduler",
        "dask": "tactiledata.compute.dask:DaskScheduler",
    },
)

"""Options that say where the tasks of a command run: on local processes, or on a Dask cluster (docs/scaling.md)."""

from __future__ import annotations

import os
from typing import Any

import typer

from tactiledata.errors import UsageError

WORKERS_HELP = "Number of local processes."
SCHEDULER_HELP = "Address of a Dask scheduler whose workers do the work, in place of local processes: tcp://HOST:8786."
MOST_WORKERS = 4
"""Local processes that a simulation starts by itself, at most: each holds a gel engine in memory."""
VARIABLE = "TACTILEDATA_WORKERS"
"""Variable of the environment that says how many local processes a simulation starts by itself."""


def workers_option(prefix: str = "") -> Any:
    """Return the option ``--workers`` of a command that simulates; ``prefix`` begins its help.

    Its value is ``None`` where it is not given: see `workers_of`.
    """
    default = f"[default: {VARIABLE}, or one for each processor, at most {MOST_WORKERS}]"
    return typer.Option(None, "--workers", help=f"{prefix}{WORKERS_HELP} {default}")


def scheduler_option(prefix: str = "") -> Any:
    """Return the option ``--scheduler``; ``prefix`` begins its help."""
    return typer.Option(None, "--scheduler", help=prefix + SCHEDULER_HELP)


def workers_of(asked: int | None, scheduler: str | None = None) -> int:
    """Return the number of local processes of a command that simulates.

    Parameters
    ----------
    asked : int, optional
        Value of ``--workers``.
    scheduler : str, optional
        Value of ``--scheduler``; a cluster needs no local processes.

    Raises
    ------
    UsageError
        The variable of the environment is no positive number.
    """
    if asked is not None:
        return asked
    if scheduler:
        return 1
    told = os.environ.get(VARIABLE, "").strip()
    if told and not (told.isdecimal() and int(told)):
        raise UsageError(
            f"{VARIABLE}={told!r} in the environment", "a number of processes, 1 or more", "Correct it, or unset it."
        )
    return int(told) if told else min(len(os.sched_getaffinity(0)), MOST_WORKERS)


WORKERS = typer.Option(1, "--workers", help=WORKERS_HELP)
SIMULATION_WORKERS = workers_option()
SCHEDULER = scheduler_option()

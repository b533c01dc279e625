"""Options that say where the tasks of a command run: on local processes, or on a Dask cluster (docs/scaling.md)."""

from __future__ import annotations

from typing import Any

import typer

WORKERS_HELP = "Number of local processes."
SCHEDULER_HELP = "Address of a Dask scheduler whose workers do the work, in place of local processes: tcp://HOST:8786."


def workers_option(prefix: str = "") -> Any:
    """Return the option ``--workers``; ``prefix`` begins its help."""
    return typer.Option(1, "--workers", help=prefix + WORKERS_HELP)


def scheduler_option(prefix: str = "") -> Any:
    """Return the option ``--scheduler``; ``prefix`` begins its help."""
    return typer.Option(None, "--scheduler", help=prefix + SCHEDULER_HELP)


WORKERS = workers_option()
SCHEDULER = scheduler_option()

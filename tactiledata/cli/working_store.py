"""The store that a command works on: the one that is named, or the only one in the working folder."""

from __future__ import annotations

from pathlib import Path

import typer

from tactiledata.errors import UsageError

STORE_ARGUMENT = typer.Argument(None, help="A store (*.zarr); left out: the only one in the working folder.")


def working_store(named: str | None, remedy: str = "Name one.") -> str:
    """Path or address of the store.

    Raises
    ------
    UsageError
        None is named, and the working folder holds none, or several.
    """
    if named is not None:
        return named
    stores = sorted(path.name for path in Path.cwd().glob("*.zarr") if path.is_dir())
    if len(stores) == 1:
        return stores[0]
    if not stores:
        raise UsageError(
            f"no store is named, and {Path.cwd()} holds no *.zarr",
            "a store",
            "Name one, or make one: tactiledata ingest RECORDINGS --store ds.zarr",
        )
    raise UsageError(f"the working folder holds several stores: {', '.join(stores)}", "one", remedy)

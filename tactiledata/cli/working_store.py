"""The choice of the store that a command works on: the named store, or the only one in the working folder."""

from __future__ import annotations

from pathlib import Path

import typer

from tactiledata.errors import UsageError

STORE_ARGUMENT = typer.Argument(None, help="A store (*.zarr). Default: the only store in the working folder.")


def working_store(named: str | None, remedy: str = "Name one of them.") -> str:
    """Return the path or address of the named store, else of the only store in the working folder.

    ``remedy`` is the advice where the folder holds several stores.

    Raises
    ------
    UsageError
        No store is named, and the working folder holds none, or several.
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
            "Name a store, or make one: tactiledata ingest RECORDINGS --store ds.zarr",
        )
    raise UsageError(f"the working folder holds several stores: {', '.join(stores)}", "one", remedy)

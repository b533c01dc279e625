"""The choice of the store that a command works on: the named store, or the only one in the working folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import typer

from tactiledata.errors import UsageError

STORE_ARGUMENT = typer.Argument(None, help="A store (*.zarr). Default: the only store in the working folder.")


def store_and_names(words: Sequence[str] | None) -> tuple[str, list[str]]:
    """Return the store that a command works on, and the words that name something in it.

    The first word is the store where it ends in ``.zarr``, is an address, or is a folder with a manifest; else the only
    store in the working folder is taken, and all words are names.
    """
    from tactiledata.store.layout.places import MANIFEST

    given = list(words or [])
    if given:
        first = given[0]
        is_address = "://" in first or "::" in first
        if is_address or first.rstrip("/").endswith(".zarr") or (Path(first) / MANIFEST).is_file():
            return first, given[1:]
    return working_store(None), given


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
    raise UsageError(f"the working folder holds several stores: {', '.join(stores)}", "one store", remedy)

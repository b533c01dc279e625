"""A store that takes recordings in: made where there is none, and taken away again where it got nothing."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactiledata.errors import UsageError
from tactiledata.store.layout.lock import writing_lock
from tactiledata.store.layout.manifest import ADDRESS, Settings, read_manifest
from tactiledata.store.layout.places import INTAKE_LOCK, MANIFEST
from tactiledata.store.write.commit import create
from tactiledata.store.write.writer import find_staged


@contextmanager
def intake(folder: Path, settings: Settings | None = None) -> Iterator[None]:
    """Hold a store's lock against other intakes; a store that is made here and gets nothing is taken away again.

    Parameters
    ----------
    folder : Path
        The store; made where there is none, with the folders above it.
    settings : Settings, optional
        Sizes of chunks of a new store.

    Raises
    ------
    StoreError
        The folder holds something else, cannot be written, or is a store of a newer version.
    UsageError
        The store exists with other settings, the place lies in another store, or it is an address.
    StoreBusy
        Another process takes recordings in.
    """
    if ADDRESS.match(str(folder)):
        raise UsageError(
            f"the store {folder} is an address",
            "a folder on this machine",
            "Write the store here, then copy it there; a store is read from an address (docs/store.md).",
        )
    is_new = not (folder / MANIFEST).exists()
    made = [place for place in (folder, *folder.parents) if not place.exists()]
    create(folder, settings)
    with writing_lock(folder, INTAKE_LOCK):
        try:
            yield
        finally:
            # under the lock: whoever waits for this store finds it whole, or makes it
            if is_new and not read_manifest(folder)["sources"] and not find_staged(folder):
                for place in folder.iterdir():
                    shutil.rmtree(place) if place.is_dir() else place.unlink()
                _remove_empty(made)


def _remove_empty(folders: list[Path]) -> None:
    """Remove folders, the innermost first, up to one in which others have put something meanwhile."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return

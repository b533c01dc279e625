"""Git LFS pointers in the place of files of a store: a repository that holds it was cloned without them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from tactiledata.contract.lfs_pointer import is_lfs_pointer, not_fetched, pointer_words
from tactiledata.contract.records import Finding
from tactiledata.store.layout.places import STAGING
from tactiledata.store.read.reader import Store

LARGEST = 1024
"""Bytes; a pointer has fewer (the specification of Git LFS)."""


def pointer_files(folder: Path) -> list[str]:
    """Paths of the pointers in a local store, sorted."""
    found = []
    for place, folders, names in os.walk(folder):
        if STAGING in folders:
            folders.remove(STAGING)
        files = (Path(place) / name for name in names)
        found += [
            str(file.relative_to(folder)) for file in files if file.lstat().st_size < LARGEST and is_lfs_pointer(file)
        ]
    return sorted(found)


def pointer_findings(store: Store) -> Iterator[Finding]:
    """Damage where files were not fetched, with what fetches them; of a remote store each reading says so itself."""
    folder = Path(store.location)
    if folder.is_dir() and (pointers := pointer_files(folder)):
        message = f"{pointer_words(pointers[0], len(pointers) - 1)}. What else is said of those files follows from that"
        yield Finding("store-not-fetched", "damage", message, count=len(pointers))


def need_no_pointers(folder: Path) -> None:
    """Refuse a local store with pointers: mending would mark as lost what only was not fetched.

    Raises
    ------
    NotFetched
        It has some.
    """
    if pointers := pointer_files(folder):
        raise not_fetched(str(folder / pointers[0]), len(pointers) - 1)

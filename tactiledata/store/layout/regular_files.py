"""Files of a store that are files: a pipe or a device in a file's place would be waited for, or read without end."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from tactiledata.errors import StoreError


def need_regular(place: Path) -> None:
    """Refuse a pipe, a device or a link to one; what is not there, and a folder, is left to whoever reads it.

    Raises
    ------
    StoreError
        It is one.
    """
    try:
        kind = place.stat().st_mode
    except OSError:
        return
    if not (stat.S_ISREG(kind) or stat.S_ISDIR(kind)):
        raise StoreError(
            f"{place} is a pipe or a device, or a link to one",
            "a file, as a store holds",
            "Restore it from a copy of the store.",
        )


def need_regular_files(folder: Path) -> None:
    """Refuse a folder that holds what `need_regular` refuses; one that is not there is left to whoever reads it."""
    try:
        with os.scandir(folder) as entries:
            odd = [entry.path for entry in entries if not entry.is_file(follow_symlinks=False)]
    except OSError:
        return
    for path in odd:
        need_regular(Path(path))

"""Files that are either wholly there or not at all, whatever moment the process is killed at."""

from __future__ import annotations

import errno
import json
import os
import secrets
from pathlib import Path

from tactiledata.contract.provenance import json_bytes

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of the system where there is no more room: a full disk, a quota, a limit on the size of files."""
REFUSED = (errno.EACCES, errno.EPERM, errno.EROFS)
"""Errors of the system where nothing may be written: no right to, or a read-only disk."""


def refusal(error: OSError, place: Path | str) -> tuple[str, str, str]:
    """What is said where the system lets nothing be written: what was found, what was expected, what to do.

    Parameters
    ----------
    error : OSError
        What the system said.
    place : Path or str
        What should have been written, for the message.

    Examples
    --------
    >>> refusal(OSError(errno.EROFS, "Read-only file system"), "out/page.html")[0]
    'out/page.html cannot be written: Read-only file system'
    """
    if error.errno in FULL:
        expected, remedy = "a disk with room", "Make room there, and run the command again."
    elif error.errno == errno.EROFS:
        expected, remedy = "a place that can be written to", "Name another place, or mount this one for writing."
    elif error.errno in REFUSED:
        expected, remedy = "a place that you may write to", "Check your rights there, or name another place."
    else:
        expected, remedy = "a disk that works", "Check the disk there, or name another place."
    return f"{place} cannot be written: {error.strerror or error}", expected, remedy


def write_atomic(path: Path, content: bytes, synced: bool = True) -> None:
    """Write a file with this content: beside its place, synced, renamed into place, the folder synced.

    Parameters
    ----------
    path : Path
        Where it is written; its folder is made where it is missing.
    content : bytes
        What it holds.
    synced : bool
        Whether it outlasts a power failure. Files of a cache need not, where what is left of them is known for damaged:
        waiting for the disk takes longer than writing many small files.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.parent / f".{path.name[:60]}.{secrets.token_hex(4)}.part"
    try:
        with beside.open("wb") as stream:
            stream.write(content)
            stream.flush()
            if synced:
                os.fsync(stream.fileno())
        beside.replace(path)
    except OSError as error:
        # the system names no file where there is no room for one
        error.filename = error.filename or str(path)
        raise
    finally:
        beside.unlink(missing_ok=True)
    if synced:
        sync_folder(path.parent)


def write_json_atomic(path: Path, value: object) -> None:
    """A JSON file that people can read, whole or not at all."""
    write_atomic(path, readable_json(value))


def readable_json(value: object) -> bytes:
    """A value as JSON that people can read: canonical order, two spaces, a line break at the end."""
    json_bytes(value)  # refuses what canonical JSON refuses, NaN included
    return (json.dumps(value, sort_keys=True, indent=2, ensure_ascii=False) + "\n").encode()


def sync_folder(folder: Path) -> None:
    """The folder's entries are on disk."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)

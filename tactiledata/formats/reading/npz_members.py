"""Arrays out of .npz archives from strangers: no pickles, no names that lead elsewhere, no bombs.

Shared by all formats, as `base` is: members of the family may import it.
"""

from __future__ import annotations

import math
import zipfile
import zlib
from collections.abc import Collection
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.errors import BrokenLog, UnsafeContent

MAX_BYTES = 2**30
"""Unpacked bytes of all arrays that are asked for, above which the archive is refused."""

_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def member_names(path: Path) -> set[str]:
    """Names of the arrays in a .npz archive, without reading them; an empty set where it is none."""
    if path.suffix.lower() != ".npz" or not path.is_file():
        return set()
    try:
        with zipfile.ZipFile(path) as archive:
            return {name.removesuffix(".npy") for name in archive.namelist()}
    except (OSError, zipfile.BadZipFile, ValueError, NotImplementedError):
        return set()


def load_members(path: Path, wanted: Collection[str]) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """The wanted arrays that an archive has, and the names of its other members, which are not read.

    Raises
    ------
    UnsafeContent
        A member that leads out of the archive, an array that only unpickling could read, or more bytes than pictures
        have.
    BrokenLog
        Not an archive, or a member that is cut, damaged or no array.
    """
    refuse_lfs_pointer(path)
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            _check(path, entries, wanted)
            known = [entry for entry in entries if entry.filename.removesuffix(".npy") in wanted]
            arrays = {entry.filename.removesuffix(".npy"): _array(path, archive, entry) for entry in known}
            return arrays, [entry.filename for entry in entries if entry not in known]
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError, OSError) as error:
        raise BrokenLog(
            f"{path.name} cannot be unpacked: {error}",
            "a whole .npz archive, without a password",
            "Download it again.",
            file=str(path),
        ) from error


def _check(path: Path, entries: list[zipfile.ZipInfo], wanted: Collection[str]) -> None:
    names = [entry.filename for entry in entries]
    for name in names:
        pure = PurePosixPath(name.replace("\\", "/"))
        if pure.is_absolute() or ".." in pure.parts or ":" in name:
            raise UnsafeContent(
                f"{path.name} has a member named {name!r}, which leads out of it",
                "plain names of arrays",
                "Do not unpack it; ask where it comes from.",
                file=str(path),
            )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise BrokenLog(f"{path.name} holds {twice[0]!r} twice", "each array once", "Write it again.", file=str(path))
    total = sum(entry.file_size for entry in entries if entry.filename.removesuffix(".npy") in wanted)
    if total > MAX_BYTES:
        packed = sum(entry.compress_size for entry in entries)
        raise UnsafeContent(
            f"{path.name} unpacks from {packed} to {total} bytes",
            f"at most {MAX_BYTES} bytes of arrays",
            "If it is sound, split it into several archives.",
            file=str(path),
        )


def _array(path: Path, archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> NDArray[Any]:
    """One array; the sizes that its header claims are held against its bytes before anything is allocated."""
    with archive.open(entry) as member:
        content = member.read(entry.file_size + 1)
    stream = BytesIO(content)
    try:
        version = np.lib.format.read_magic(stream)
        shape, _, dtype = _HEADERS[version](stream)
        if dtype.hasobject:
            raise UnsafeContent(
                f"{path.name} holds {entry.filename} as pickled objects, which run code when read",
                "arrays of numbers or text",
                "Save it again without objects (`np.savez` of plain arrays).",
                file=str(path),
            )
        if math.prod(shape) * dtype.itemsize != len(content) - stream.tell():
            raise ValueError(f"{len(content) - stream.tell()} bytes for {dtype} {shape}")
        stream.seek(0)
        return np.lib.format.read_array(stream, allow_pickle=False)
    except UnsafeContent:
        raise
    except (ValueError, KeyError, TypeError, SyntaxError, OverflowError) as error:
        raise BrokenLog(
            f"{path.name}: {entry.filename} is no NumPy array ({error})",
            "an array",
            "Download it again.",
            file=str(path),
        ) from error

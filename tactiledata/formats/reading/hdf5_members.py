"""Members of HDF5 files, read with limits: nothing outside of the file, and no more than a file of its size holds."""

from __future__ import annotations

import itertools
import math
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.errors import BrokenLog, TactileDataError, UnsafeContent

HDF5_FAULTS = (OSError, RuntimeError, KeyError, TypeError, ValueError, OverflowError, MemoryError, AttributeError)
"""What h5py raises on damaged files; names of groups may come as bytes, sizes as nonsense."""
MEMBER_BYTES = 40
"""A group or a data set takes more than this in a file: a file that seems to hold more of them repeats its links."""
MOST_OPENED = 2
"""Times that each member may be opened."""
FREE_BYTES = 2**26
"""Bytes of numbers that any file may hold, however small it is."""
MOST_GROWN = 50
"""Bytes of numbers for each byte of a larger file: simulated meshes compress to a third at best."""
MOST_CHUNK = 2**26
"""Bytes of a chunk. Whoever reads one number of a chunk holds all of it."""
FILTERS = {1: "deflate", 2: "shuffle", 3: "fletcher32", 32000: "lzf"}
"""Filters of chunks that are read; the others need libraries of their own, or state how much they unpack."""
DEFLATE, LZF = 1, 32000
LZF_GROWS = 16
"""Chunks packed by lzf are this much smaller at most: what they unpack to cannot be told before."""
STORED_SPARE = 4096
"""Bytes by which a compressed chunk may be larger than its numbers."""


class UnreadableNumbers(ValueError):
    """A data set that is not read, with the reason as its message."""


class Hdf5Rows:
    """The rows of a data set of bytes, read a chunk at a time.

    Parameters
    ----------
    dataset : h5py.Dataset
        Of type uint8, or of byte strings of varying length.
    is_packed : bool
        Whether its rows are byte strings: pictures as files.
    filters : list of int
        Numbers of the filters of its chunks.
    """

    def __init__(self, dataset: Any, is_packed: bool, filters: list[int]) -> None:
        self.shape: tuple[int, ...] = dataset.shape
        self.is_packed = is_packed
        self._dataset, self._filters = dataset, filters
        self._step = dataset.chunks[0] if dataset.chunks and not is_packed else 1
        self._first = 0
        self._block: Any = None

    def __len__(self) -> int:
        return self.shape[0]

    def row(self, number: int) -> NDArray[np.uint8]:
        """Return a row; a byte string as (n,).

        Parameters
        ----------
        number : int
            From 0.

        Raises
        ------
        OSError
            It cannot be read; h5py's own errors are told as this one.
        """
        if self._block is None or not self._first <= number < self._first + self._step:
            self._first = number - number % self._step
            try:
                self._check_block()
                self._block = self._dataset[self._first : self._first + self._step]
            except HDF5_FAULTS as error:
                self._block = None
                raise OSError(0, f"cannot be read: {str(error)[:100]}") from error
        found: NDArray[np.uint8] = np.asarray(self._block[number - self._first], dtype=np.uint8)
        return found

    def _check_block(self) -> None:
        """Refuse chunks of the present rows that hold more than their numbers."""
        chunks = self._dataset.chunks
        if self.is_packed or not chunks:
            return
        others = (range(0, size, step) for size, step in zip(self.shape[1:], chunks[1:], strict=True))
        for offset in itertools.product((self._first,), *others):
            stored = self._dataset.id.get_chunk_info_by_coord(offset)
            if stored.size:
                _check_chunk(self._dataset, self._filters, offset, stored.size)


class Hdf5Members:
    """Groups and numbers of one open HDF5 file.

    Parameters
    ----------
    file : h5py.File
    size : int
        Bytes of the file on disk, by which is judged how much it can hold.
    """

    def __init__(self, file: Any, size: int) -> None:
        self.root = file
        self._size = size
        self._opened = 0
        self._bytes = 0

    def names(self, group: Any) -> list[str]:
        """Names of the members of a group; those that are no text are left out, and data sets have none."""
        import h5py

        return [name for name in group if isinstance(name, str)] if isinstance(group, h5py.Group) else []

    def group(self, parent: Any, name: str) -> Any:
        """Return a group inside a group; ``None`` where there is none of this name.

        Raises
        ------
        UnsafeContent
            The member is a link, or the file seems to hold more members than fit into it.
        """
        import h5py

        member = self._member(parent, name)
        return member if isinstance(member, h5py.Group) else None

    def numbers(self, parent: Any, name: str, most: int) -> NDArray[np.float64] | None:
        """Return the numbers of a data set inside a group, as float64 in its own shape; ``None`` where there is none.

        Parameters
        ----------
        parent : h5py.Group or None
        name : str
        most : int
            Numbers that it may hold.

        Raises
        ------
        UnreadableNumbers
            It holds something else, or more, or is stored in a way that is not read.
        UnsafeContent
            It is a link or lies in another file, or the file seems to hold more than fits into it.
        """
        found = self.values(parent, name, most)
        return None if found is None else np.asarray(found, dtype=np.float64)

    def values(self, parent: Any, name: str, most: int) -> NDArray[Any] | None:
        """Return the numbers of a data set inside a group, in their own type and shape; ``None`` where there is none.

        Parameters
        ----------
        parent, name, most
            As of `numbers`; its errors as well.
        """
        import h5py

        dataset = self._member(parent, name)
        if not isinstance(dataset, h5py.Dataset):
            return None
        if dataset.size is None or dataset.size > most or dataset.dtype.kind not in "fiu":
            raise UnreadableNumbers(f"of shape {dataset.shape} and type {str(dataset.dtype)[:60]}")
        _check_chunks(dataset)
        self._count(dataset, max(8, dataset.dtype.itemsize))
        try:
            return np.asarray(dataset[()])
        except HDF5_FAULTS as error:
            raise UnreadableNumbers(f"cannot be read ({str(error)[:100]})") from error

    def rows(self, parent: Any, name: str) -> Hdf5Rows | None:
        """Return a data set of bytes that is read row by row; ``None`` where there is none.

        Parameters
        ----------
        parent : h5py.Group or None
        name : str

        Raises
        ------
        UnreadableNumbers
            It holds something else than bytes, or is stored in a way that is not read.
        UnsafeContent
            As of `numbers`.
        """
        import h5py

        dataset = self._member(parent, name)
        if not isinstance(dataset, h5py.Dataset):
            return None
        is_packed = h5py.check_vlen_dtype(dataset.dtype) == np.uint8
        if not dataset.shape or not (is_packed or dataset.dtype == np.uint8):
            raise UnreadableNumbers(f"of shape {dataset.shape} and type {str(dataset.dtype)[:60]}")
        filters = [] if is_packed else _checked_filters(dataset)
        if not is_packed:
            self._count(dataset, 1)
        return Hdf5Rows(dataset, is_packed, filters)

    def member(self, parent: Any, name: str) -> Any:
        """Return a group or a data set inside a group, to look at its kind and shape; ``None`` where there is none.

        Parameters
        ----------
        parent : h5py.Group or None
        name : str

        Raises
        ------
        UnsafeContent
            As of `numbers`.
        """
        return self._member(parent, name)

    def _count(self, dataset: Any, width: int) -> None:
        """Refuse more numbers than a file of this size holds."""
        self._bytes += dataset.size * width
        if self._bytes > FREE_BYTES + MOST_GROWN * self._size:
            raise self._too_much("numbers")

    def _member(self, parent: Any, name: str) -> Any:
        import h5py

        link = parent.get(name, getlink=True) if isinstance(parent, h5py.Group) else None
        if link is None:
            return None
        self._opened += 1
        if self._opened * MEMBER_BYTES > MOST_OPENED * self._size:
            raise self._too_much("groups and data sets")
        member = parent[name] if isinstance(link, h5py.HardLink) else None
        if member is None or (isinstance(member, h5py.Dataset) and (member.external or member.is_virtual)):
            raise UnsafeContent(
                f"{name[:60]} in {parent.file.filename} is a link, or lies in another file",
                "HDF5 files that hold their own data",
                "Copy the data into the file (h5repack) if you trust its origin.",
                name=name,
            )
        return member

    def _too_much(self, what: str) -> UnsafeContent:
        return UnsafeContent(
            f"{self.root.filename} seems to hold more {what} than fit into its {self._size} bytes",
            "HDF5 files that hold each of their data once",
            "Write the file again without repeated links and empty data sets (h5repack) if you trust its origin.",
        )


@contextmanager
def open_hdf5(path: Path) -> Iterator[Hdf5Members]:
    """Open an HDF5 file to read its members; h5py's errors (`HDF5_FAULTS`) are the caller's."""
    import h5py

    with h5py.File(path, "r") as file:
        yield Hdf5Members(file, path.stat().st_size)


@contextmanager
def reading_hdf5(path: Path, expected: str, remedy: str) -> Iterator[Hdf5Members]:
    """Open an HDF5 file to read its members; what h5py raises of a damaged file becomes an error of the toolkit.

    Parameters
    ----------
    path : Path
    expected, remedy : str
        What was expected of the file, and what to do, for the message.

    Raises
    ------
    BrokenLog
        The file cannot be read as HDF5.
    NotFetched
        The file is a Git LFS pointer.
    """
    refuse_lfs_pointer(path)
    try:
        with open_hdf5(path) as members:
            yield members
    except TactileDataError:  # some are ValueErrors, and no damage of the file
        raise
    except HDF5_FAULTS as error:
        raise BrokenLog(
            f"{path} cannot be read as HDF5 ({str(error)[:150]})", expected, remedy, file=str(path)
        ) from error


def _check_chunks(dataset: Any) -> None:
    """Refuse chunks that are large, stored by a filter that is not read, or that unpack to more than they hold."""
    filters = _checked_filters(dataset)
    if dataset.chunks:
        for index in range(dataset.id.get_num_chunks()):
            stored = dataset.id.get_chunk_info(index)
            _check_chunk(dataset, filters, stored.chunk_offset, stored.size)


def _checked_filters(dataset: Any) -> list[int]:
    """Return the filters of a data set; refuse large chunks, and filters that are not read."""
    if not dataset.chunks:
        return []
    plan = dataset.id.get_create_plist()
    filters = [plan.get_filter(index)[0] for index in range(plan.get_nfilters())]
    held = _held(dataset)
    most = MOST_CHUNK // LZF_GROWS if LZF in filters else MOST_CHUNK
    if held > most:
        raise UnreadableNumbers(f"in chunks of {held} bytes; {most} are read at most")
    if others := [number for number in filters if number not in FILTERS]:
        raise UnreadableNumbers(f"packed by the HDF5 filter {others[0]}; {', '.join(FILTERS.values())} are read")
    if sum(number in (DEFLATE, LZF) for number in filters) > 1 or len(set(filters)) < len(filters):
        raise UnreadableNumbers("packed more than once")
    return filters


def _check_chunk(dataset: Any, filters: list[int], offset: tuple[int, ...], size: int) -> None:
    """Refuse a chunk of ``size`` stored bytes that holds more than its numbers, as it is or unpacked."""
    held = _held(dataset)
    if size > held + held // 10 + STORED_SPARE:
        raise UnreadableNumbers(f"in a chunk of {size} bytes for {held} bytes of numbers")
    if DEFLATE in filters:
        _check_deflated(dataset.id.read_direct_chunk(offset), filters, held)


def _held(dataset: Any) -> int:
    """Return the bytes of numbers of a chunk."""
    return int(math.prod(dataset.chunks) * dataset.dtype.itemsize)


def _check_deflated(chunk: tuple[int, bytes], filters: list[int], held: int) -> None:
    """Refuse a deflated chunk (mask of the filters that were left out, bytes) that unpacks to more than ``held``."""
    mask, raw = chunk
    if mask >> filters.index(DEFLATE) & 1:
        return
    unpacker = zlib.decompressobj()
    try:
        length = len(unpacker.decompress(raw, held + STORED_SPARE))
    except zlib.error as error:
        raise UnreadableNumbers(f"cannot be read ({error})") from error
    if length >= held + STORED_SPARE:
        raise UnreadableNumbers(f"in a chunk that unpacks to more than its {held} bytes of numbers")

"""Rows of Zarr arrays, read at random: chunks are decoded once and kept for a while."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Callable
from typing import Any

import numpy as np
import zarr
from numpy.typing import ArrayLike, NDArray

from tactiledata.errors import StoreError, UsageError
from tactiledata.store.read.files import StoreFiles

CACHE_BYTES = 256 * 2**20
"""Decoded chunks that one array keeps; the aligned wrench of a million frames takes 48 MB."""


class Rows:
    """An array of rows, bounded by the length that the manifest names.

    Parameters
    ----------
    files : StoreFiles
    path : str
        Of the array in the store.
    length : int
        Rows that count.
    need_recorded : callable, optional
        Called with the path and a range of rows that read as the fill value and have no file; raises where something
        was recorded there. Without it such rows are taken as they read.
    """

    def __init__(
        self,
        files: StoreFiles,
        path: str,
        length: int,
        need_recorded: Callable[[str, int, int], None] | None = None,
    ) -> None:
        self._files, self._path, self.length = files, path, length
        self._need_recorded = need_recorded
        self._array: zarr.Array | None = None
        self._chunks: OrderedDict[int, NDArray[Any]] = OrderedDict()
        self._owner = os.getpid()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_array": None, "_chunks": OrderedDict()}

    def _opened(self) -> zarr.Array:
        if self._array is None or self._owner != os.getpid():
            self._array = self._files.array(self._path)
            self._owner = os.getpid()
        if self._array.shape[0] < self.length:
            raise StoreError(
                f"array {self._path} has {self._array.shape[0]} rows",
                f"the {self.length} rows that the manifest names",
                "Run `tactiledata check` on the store.",
            )
        return self._array

    def _chunk(self, index: int) -> NDArray[Any]:
        if index in self._chunks:
            self._chunks.move_to_end(index)
            return self._chunks[index]
        array = self._opened()
        size = array.chunks[0]
        try:
            rows = np.asarray(array[index * size : min((index + 1) * size, self.length)])
        except (ValueError, RuntimeError) as error:
            self._files.need_fetched(self._path)
            # zarr's message prints both checksums as raw bytes
            why = "its bytes do not fit their checksum" if "checksum" in str(error) else str(error)
            raise StoreError(
                f"chunk {index} of array {self._path} in {self._files.location} is damaged: {why}",
                "a chunk that fits its CRC-32C",
                "Run `tactiledata check` to see what it concerns; restore the file from a copy.",
            ) from error
        if not self._files.still_there(f"{self._path}/zarr.json"):
            # zarr takes a chunk that is gone for fill
            raise StoreError(
                f"array {self._path} left {self._files.location} while it was open",
                "the store as it was opened",
                "It was moved, or a recording in it was replaced: open it again.",
            )
        need = self._need_recorded
        if (
            need is not None
            and _is_fill(rows, array.fill_value)
            and self._files.may_be_missing(self._chunk_file(index))
        ):
            need(self._path, index * size, index * size + len(rows))
        rows.setflags(write=False)
        self._chunks[index] = rows
        while len(self._chunks) > 1 and sum(chunk.nbytes for chunk in self._chunks.values()) > CACHE_BYTES:
            self._chunks.popitem(last=False)
        return rows

    def _chunk_file(self, index: int) -> str:
        array = self._opened()
        return f"{self._path}/{array.metadata.encode_chunk_key((index,) + (0,) * (array.ndim - 1))}"

    def lost_files(self, start: int, stop: int) -> list[str]:
        """Files of the chunks of rows [start, stop) that are not there; such rows read as nothing.

        A chunk in which nothing was recorded has no file either.
        """
        size = self._opened().chunks[0]
        files = (self._chunk_file(index) for index in range(start // size, (stop - 1) // size + 1))
        return [file for file in files if not self._files.still_there(file)]

    def lengthen(self, length: int) -> None:
        """More rows count from now on; the array stays open, and what was read of its last chunk is read again."""
        self.length = max(self.length, length)
        if self._chunks:
            self._chunks.pop(max(self._chunks))

    def span(self, start: int, stop: int) -> NDArray[Any]:
        """Rows [start, stop); a view where they lie in one chunk."""
        if not 0 <= start <= stop <= self.length:
            raise UsageError(f"rows {start} to {stop} of {self._path}", f"a range within its {self.length} rows")
        array = self._opened()
        size = array.chunks[0]
        if start == stop:
            return np.empty((0, *array.shape[1:]), array.dtype)
        pieces = []
        for index in range(start // size, (stop - 1) // size + 1):
            first = index * size
            pieces.append(self._chunk(index)[max(start - first, 0) : stop - first])
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    def take(self, rows: ArrayLike | None) -> NDArray[Any]:
        """Some rows in the order asked for, or all."""
        if rows is None:
            return self.span(0, self.length)
        wanted = checked_rows(rows, self.length, self._path)
        array = self._opened()
        size = array.chunks[0]
        out = np.empty((len(wanted), *array.shape[1:]), array.dtype)
        of_chunk = wanted // size
        for index in np.unique(of_chunk).tolist():
            mask = of_chunk == index
            out[mask] = self._chunk(index)[wanted[mask] - index * size]
        return out


def _is_fill(rows: NDArray[Any], fill: Any) -> bool:
    """Whether rows hold nothing but the fill value, which may be no number."""
    if not rows.size or not np.array_equal(rows.flat[0], fill, equal_nan=rows.dtype.kind == "f"):
        return False
    return bool(np.isnan(rows).all() if fill != fill else (rows == fill).all())


def checked_rows(rows: ArrayLike, length: int, what: str) -> NDArray[np.int64]:
    """Row numbers (n,) as integers; a mask of all rows is taken as the rows where it is true.

    Parameters
    ----------
    rows : (n,) int, or a mask of all rows
        The rows that are wanted, in any order.
    length : int
        Rows that there are.
    what : str
        The table or array, as the error names it.

    Raises
    ------
    UsageError
        Not whole numbers, or outside [0, length).
    """
    wanted = np.atleast_1d(np.asarray(rows))
    if wanted.dtype == bool and wanted.shape == (length,):
        return np.flatnonzero(wanted)
    if not wanted.size:
        return np.empty(0, dtype=np.int64)
    if wanted.ndim != 1 or not np.issubdtype(wanted.dtype, np.integer):
        raise UsageError(f"rows of type {wanted.dtype} and shape {wanted.shape}", "a list of row numbers")
    if wanted.min() < 0 or wanted.max() >= length:
        outside = wanted[(wanted < 0) | (wanted >= length)][0]
        raise UsageError(f"row {outside} of {what}", f"a row from 0 to {length - 1}")
    return wanted.astype(np.int64)

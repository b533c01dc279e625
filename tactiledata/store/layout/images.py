"""Payloads of a staged take into heaps and shards: bytes are moved, never decoded."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import google_crc32c
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Indices
from tactiledata.errors import StoreError
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.shards import index_bytes, is_whole, shard_bytes, shard_chunks, shard_index

BLOCK = 8 * 2**20


def place_payloads(lengths: Sequence[int], start: int, chunk: int) -> NDArray[np.int64]:
    """Offsets of payloads put one after another from byte ``start`` on, none of them across a chunk's border.

    Parameters
    ----------
    lengths : (n,) bytes
        Of the payloads, none longer than a chunk.
    start : int
        Byte of the heap from which on there is room.
    chunk : int
        Bytes of a chunk.

    Examples
    --------
    >>> place_payloads([4, 4, 4], start=1, chunk=10).tolist()
    [1, 5, 10]
    """
    offsets = np.empty(len(lengths), dtype=np.int64)
    position = start
    for index, length in enumerate(lengths):
        if length and position // chunk != (position + length - 1) // chunk:
            position = (position // chunk + 1) * chunk
        offsets[index] = position
        position += length
    return offsets


@dataclass
class HeapAppender:
    """Appends to the chunk files of a heap in place.

    Bytes beyond the manifest's length mean nothing to readers, so the tail chunk need not be rewritten; it is cut to
    that length first, so that nothing of a killed commit stays, and always stretched to its nominal size (sparse), so
    that other Zarr readers can read it.

    Parameters
    ----------
    batch : Batch
        Syncs the chunk files.
    path : str
        Of the array in the store.
    chunk : int
        Bytes of a chunk file.
    end : int
        Bytes in use; grows with each append.
    """

    batch: Batch
    path: str
    chunk: int
    end: int
    _open: tuple[int, int] | None = None

    def append(self, spool: Path, offsets: Indices, lengths: Indices, crc32c: NDArray[Any]) -> Indices:
        """Append the payloads at ``offsets`` of a spool file, and return their places in the heap.

        Parameters
        ----------
        spool : Path
            File of the payloads.
        offsets, lengths : (n,) bytes
            Where each payload lies in the spool file.
        crc32c : (n,)
            CRC-32C of each payload.

        Raises
        ------
        StoreError
            A payload larger than a chunk, or one that does not fit its CRC-32C.
        """
        if len(lengths) and lengths.max() > self.chunk:
            raise StoreError(
                f"an image of {lengths.max()} bytes",
                f"at most {self.chunk} bytes, the chunk size of this store",
                "Make a store with larger heap chunks.",
            )
        placed = place_payloads(lengths.tolist(), self.end, self.chunk)
        with spool.open("rb") as stream:
            for first, stop in _runs(offsets, lengths, placed, self.chunk):
                part = slice(first, stop)
                content = os.pread(stream.fileno(), int(lengths[part].sum()), int(offsets[first]))
                _check_payloads(content, lengths[part].tolist(), crc32c[part].tolist(), spool)
                self._write(content, int(placed[first]))
        if len(placed):
            self.end = max(self.end, int(placed[-1] + lengths[-1]))
        return placed

    def _write(self, content: bytes, start: int) -> None:
        if not content:
            return
        descriptor = self._file(start // self.chunk)
        view, position = memoryview(content), start % self.chunk
        while view:
            written = os.pwrite(descriptor, view, position)
            view, position = view[written:], position + written

    def _file(self, chunk_index: int) -> int:
        if self._open is None or self._open[0] != chunk_index:
            self.close()
            place = self.batch.root / self.path / f"c.{chunk_index}"
            descriptor = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o644)
            self._open = chunk_index, descriptor
            self.batch.note(place)
            cut_chunk(descriptor, max(0, min(self.chunk, self.end - chunk_index * self.chunk)), self.chunk)
        return self._open[1]

    def close(self) -> None:
        """No file is open any more."""
        if self._open is not None:
            os.close(self._open[1])
        self._open = None


def cut_chunk(descriptor: int, used: int, chunk: int) -> None:
    """A chunk file with zeros after its first ``used`` bytes, of its nominal size.

    Parameters
    ----------
    descriptor : int
        Of the chunk file, open for writing.
    used : int
        Bytes that stay.
    chunk : int
        Bytes of a chunk file.
    """
    os.ftruncate(descriptor, used)
    os.ftruncate(descriptor, chunk)


def _runs(offsets: Indices, lengths: Indices, placed: Indices, chunk: int) -> Iterator[tuple[int, int]]:
    """Ranges [first, stop) of payloads that lie side by side in the spool and in one chunk of the heap, of some MiB."""
    if not len(offsets):
        return
    follows = (
        (offsets[1:] == offsets[:-1] + lengths[:-1])
        & (placed[1:] == placed[:-1] + lengths[:-1])
        & (placed[1:] // chunk == placed[:-1] // chunk)
    )
    breaks = [*(np.flatnonzero(~follows) + 1).tolist(), len(offsets)]
    ends = np.cumsum(lengths)
    first = 0
    for stop in breaks:
        while first < stop:
            enough = int(np.searchsorted(ends, int(ends[first] - lengths[first]) + BLOCK)) + 1
            yield first, min(stop, enough)
            first = min(stop, enough)


def _check_payloads(content: bytes, lengths: list[int], crc32c: list[int], spool: Path) -> None:
    position = 0
    for length, crc in zip(lengths, crc32c, strict=True):
        payload = content[position : position + length]
        if len(payload) != length or google_crc32c.value(payload) != crc:
            raise damaged_spool(spool)
        position += length


def damaged_spool(place: Path) -> StoreError:
    """The error for a staged take whose files are not what was written."""
    return StoreError(
        f"{place.name} of the staged take {place.parent.name[:12]}… is damaged",
        "the bytes that were staged",
        f"The recording will be read again: delete {place.parent} and run the same command.",
        path=str(place),
    )


@dataclass
class ShardAppender:
    """Appends raw frames, compressed already, to the shards of an array; the last shard is written again as a whole.

    Parameters
    ----------
    batch : Batch
        Takes the shard files.
    path : str
        Of the array in the store.
    capacity : int
        Frames of a shard.
    count : int
        Frames in use; grows with each append.
    """

    batch: Batch
    path: str
    capacity: int
    count: int
    _chunks: list[bytes] | None = None

    def append(self, spool: Path, offsets: Indices, lengths: Indices) -> Indices:
        """The rows that the frames at ``offsets`` of a spool file got.

        Parameters
        ----------
        spool : Path
            File of the compressed frames.
        offsets, lengths : (n,) bytes
            Where each frame lies in the spool file.
        """
        chunks = self._tail() if self._chunks is None else self._chunks
        first = self.count
        is_shard = not chunks and self._is_shard(spool, offsets, lengths)
        with spool.open("rb") as stream:
            for offset, length in zip(offsets.tolist(), lengths.tolist(), strict=True):
                content = os.pread(stream.fileno(), length, offset)
                if not is_whole(content):
                    raise damaged_spool(spool)
                self.count += 1
                if is_shard:
                    continue
                chunks.append(content)
                if self.count % self.capacity == 0:
                    self._write(self.count // self.capacity - 1, chunks)
                    chunks = []
        if is_shard:
            self._take(spool, lengths)
        self._chunks = chunks
        return np.arange(first, self.count, dtype=np.int64)

    def _is_shard(self, spool: Path, offsets: Indices, lengths: Indices) -> bool:
        """Whether frames are all that a spool file holds, in its order, and as many as a shard takes.

        A commit that was killed may have written the shard's index behind them already.
        """
        ends = np.cumsum(lengths)
        return (
            len(lengths) == self.capacity
            and bool((offsets == ends - lengths).all())
            and spool.stat().st_size in (ends[-1], ends[-1] + index_bytes(self.capacity))
        )

    def _take(self, spool: Path, lengths: Indices) -> None:
        """A spool file that holds a shard's frames becomes the last shard, its bytes where they are."""
        with spool.open("r+b") as stream:
            stream.seek(int(lengths.sum()))
            stream.write(shard_index(lengths.tolist(), self.capacity))
        self.batch.link(shard_file(self.path, self.count // self.capacity - 1), spool)

    def _tail(self) -> list[bytes]:
        if self.count % self.capacity == 0:
            return []
        shard = self.batch.read(shard_file(self.path, self.count // self.capacity))
        return shard_chunks(shard, self.capacity, self.path)[: self.count % self.capacity]

    def _write(self, shard: int, chunks: list[bytes]) -> None:
        self.batch.write(shard_file(self.path, shard), shard_bytes(chunks, self.capacity))

    def rewrite_tail(self) -> None:
        """The last shard without frames beyond ``count``."""
        self._write(self.count // self.capacity, self._tail())

    def close(self) -> None:
        """The last shard is written."""
        if self._chunks:
            self._write(self.count // self.capacity, self._chunks)


def shard_file(path: str, shard: int) -> str:
    """The file of a shard of an array."""
    return f"{path}/c.{shard}.0.0.0"

"""Payloads of a staged take into heaps and shards: bytes are moved, never decoded."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.atomic import sync_folder, write_atomic
from tactiledata.errors import StoreError
from tactiledata.store.shards import index_bytes, parse_index, shard_bytes

BLOCK = 8 * 2**20


def place_payloads(lengths: Sequence[int], start: int, chunk: int) -> NDArray[np.int64]:
    """Offsets of payloads put one after another from byte ``start`` on, none of them across a chunk's border.

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
    folder : Path
        The array's folder.
    chunk : int
        Bytes of a chunk file.
    end : int
        Bytes in use; grows with each append.
    """

    folder: Path
    chunk: int
    end: int
    _open: dict[int, int] = field(default_factory=dict)

    def append(self, spool: Path, offsets: NDArray[np.int64], lengths: NDArray[np.int64]) -> NDArray[np.int64]:
        """Where the payloads at ``offsets`` of a spool file came to lie in the heap."""
        if len(lengths) and lengths.max() > self.chunk:
            raise StoreError(
                f"an image of {lengths.max()} bytes",
                f"at most {self.chunk} bytes, the chunk size of this store",
                "Make a store with larger heap chunks.",
            )
        placed = place_payloads(lengths.tolist(), self.end, self.chunk)
        with spool.open("rb") as stream:
            for first, last in _runs(offsets, lengths, placed, self.chunk):
                self._copy(stream.fileno(), int(offsets[first]), int(placed[first]), int(placed[last] + lengths[last]))
        if len(placed):
            self.end = max(self.end, int(placed[-1] + lengths[-1]))
        return placed

    def _copy(self, source: int, read_at: int, start: int, stop: int) -> None:
        if start == stop:
            return
        target = self._file(start // self.chunk)
        while start < stop:
            content = os.pread(source, min(BLOCK, stop - start), read_at)
            if not content:
                raise StoreError("a spool file is shorter than its frames say", "a staged take that is whole")
            written = os.pwrite(target, content, start % self.chunk)
            start, read_at = start + written, read_at + written

    def _file(self, chunk_index: int) -> int:
        if chunk_index not in self._open:
            self.close()
            path = self.folder / f"c.{chunk_index}"
            descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o644)
            self._open[chunk_index] = descriptor
            cut_chunk(descriptor, max(0, self._used(chunk_index)), self.chunk)
        return self._open[chunk_index]

    def _used(self, chunk_index: int) -> int:
        return min(self.chunk, self.end - chunk_index * self.chunk)

    def close(self) -> None:
        """Everything appended is on disk."""
        for descriptor in self._open.values():
            os.fsync(descriptor)
            os.close(descriptor)
        if self._open:
            sync_folder(self.folder)
        self._open.clear()


def cut_chunk(descriptor: int, used: int, chunk: int) -> None:
    """A chunk file with zeros after its first ``used`` bytes, of its nominal size."""
    os.ftruncate(descriptor, used)
    os.ftruncate(descriptor, chunk)


def _runs(
    offsets: NDArray[np.int64], lengths: NDArray[np.int64], placed: NDArray[np.int64], chunk: int
) -> list[tuple[int, int]]:
    """Ranges [first, last] of payloads that lie side by side in the spool and in one chunk of the heap."""
    if not len(offsets):
        return []
    follows = (
        (offsets[1:] == offsets[:-1] + lengths[:-1])
        & (placed[1:] == placed[:-1] + lengths[:-1])
        & (placed[1:] // chunk == placed[:-1] // chunk)
    )
    breaks = np.flatnonzero(~follows)
    firsts = np.concatenate([[0], breaks + 1])
    lasts = np.concatenate([breaks, [len(offsets) - 1]])
    return list(zip(firsts.tolist(), lasts.tolist(), strict=True))


@dataclass
class ShardAppender:
    """Appends raw frames, compressed already, to the shards of an array; the last shard is written again as a whole.

    Parameters
    ----------
    folder : Path
        The array's folder.
    capacity : int
        Frames of a shard.
    count : int
        Frames in use; grows with each append.
    """

    folder: Path
    capacity: int
    count: int
    _chunks: list[bytes] | None = None

    def append(self, spool: Path, offsets: NDArray[np.int64], lengths: NDArray[np.int64]) -> NDArray[np.int64]:
        """The rows that the frames at ``offsets`` of a spool file got."""
        chunks = self._tail() if self._chunks is None else self._chunks
        first = self.count
        with spool.open("rb") as stream:
            for offset, length in zip(offsets.tolist(), lengths.tolist(), strict=True):
                content = os.pread(stream.fileno(), length, offset)
                if len(content) != length:
                    raise StoreError("a spool file is shorter than its frames say", "a staged take that is whole")
                chunks.append(content)
                self.count += 1
                if self.count % self.capacity == 0:
                    self._write(self.count // self.capacity - 1, chunks)
                    chunks = []
        self._chunks = chunks
        return np.arange(first, self.count, dtype=np.int64)

    def _tail(self) -> list[bytes]:
        if self.count % self.capacity == 0:
            return []
        return read_shard(shard_file(self.folder, self.count // self.capacity), self.capacity)[
            : self.count % self.capacity
        ]

    def _write(self, shard: int, chunks: list[bytes]) -> None:
        write_atomic(shard_file(self.folder, shard), shard_bytes(chunks, self.capacity))

    def rewrite_tail(self) -> None:
        """The last shard without frames beyond ``count``."""
        self._write(self.count // self.capacity, self._tail())

    def close(self) -> None:
        """Everything appended is on disk."""
        if self._chunks:
            self._write(self.count // self.capacity, self._chunks)


def shard_file(folder: Path, shard: int) -> Path:
    """The file of a shard."""
    return folder / f"c.{shard}.0.0.0"


def read_shard(path: Path, capacity: int) -> list[bytes]:
    """The compressed frames of a shard, in order."""
    content = path.read_bytes()
    entries = parse_index(content[-index_bytes(capacity) :], capacity, str(path))
    return [content[offset : offset + length] for offset, length in entries if length < 2**63]

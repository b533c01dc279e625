"""Zarr arrays that grow by rows: every file is written whole and synced, so that a kill leaves the old or the new."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import zarr
from numpy.typing import NDArray
from zarr.abc.store import ByteRequest
from zarr.codecs import BytesCodec, Crc32cCodec, ZstdCodec
from zarr.core.buffer import Buffer, BufferPrototype
from zarr.storage import LocalStore

from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.places import FORMAT

ZSTD_LEVEL = 1
"""Camera noise does not compress: level 3 takes 1.6 times as long for 1 % fewer bytes (320x240 DIGIT frames)."""

SEPARATOR: dict[str, Any] = {"name": "default", "configuration": {"separator": "."}}
"""Chunk files lie flat in the array's folder (``c.0.0``), not in a folder each."""


class BatchStore(LocalStore):
    """A Zarr store on the local disk that writes into a batch, so that files appear together, whole and synced."""

    def __init__(self, batch: Batch, *, read_only: bool = False) -> None:
        super().__init__(batch.root, read_only=read_only)
        self.batch = batch

    def with_read_only(self, read_only: bool = False) -> BatchStore:
        """Return the same store, writable or not."""
        return BatchStore(self.batch, read_only=read_only)

    async def get(
        self, key: str, prototype: BufferPrototype | None = None, byte_range: ByteRequest | None = None
    ) -> Buffer | None:
        """The newest value of a key.

        Parameters
        ----------
        key : str
            Path of a file in the store.
        prototype : BufferPrototype, optional
            Kind of buffer that is returned; zarr's own by default.
        byte_range : ByteRequest, optional
            Part of the file; all of it by default.
        """
        return await super().get(self.batch.where(key), prototype, byte_range)

    async def exists(self, key: str) -> bool:
        """Whether a key has a value."""
        return await super().exists(self.batch.where(key))

    async def set(self, key: str, value: Buffer) -> None:
        """Keep a value under a key."""
        self._check_writable()
        self.batch.write(key, value.to_bytes())

    async def set_if_not_exists(self, key: str, value: Buffer) -> None:
        """Keep a value under a key that is not taken yet."""
        if not await self.exists(key):
            await self.set(key, value)

    def get_sync(
        self, key: str, *, prototype: BufferPrototype | None = None, byte_range: ByteRequest | None = None
    ) -> Buffer | None:
        """The newest value of a key, without an event loop.

        Parameters
        ----------
        key, prototype, byte_range
            As those of `get`.
        """
        return super().get_sync(self.batch.where(key), prototype=prototype, byte_range=byte_range)

    def set_sync(self, key: str, value: Buffer) -> None:
        """Keep a value under a key, without an event loop."""
        self._check_writable()
        self.batch.write(key, value.to_bytes())


def open_root(batch: Batch) -> zarr.Group:
    """The store's Zarr group, to write into."""
    return zarr.open_group(BatchStore(batch), mode="a", zarr_format=3, attributes={"format": FORMAT})


def create_rows(
    root: zarr.Group,
    path: str,
    width: int | tuple[int, ...] | None,
    dtype: str,
    fill: float,
    chunk_rows: int,
    attributes: Mapping[str, Any],
) -> None:
    """An empty array of rows, chunked along the rows, zstd and crc32c; one that lies there already is replaced.

    Parameters
    ----------
    root : zarr.Group
        The store's root, open for writing.
    path : str
        Of the new array in the store.
    width : int or tuple of int, optional
        Columns, or further axes; ``None`` for an array (n,).
    dtype : str
        Type of a number, as numpy writes it.
    fill : float
        What a row holds that was never written.
    chunk_rows : int
        Rows of one chunk.
    attributes : dict
        Kept in the array's document: columns, units and the like.
    """
    shape = (0, *(() if width is None else (width,) if isinstance(width, int) else width))
    _create(
        root,
        path,
        shape=shape,
        dtype=dtype,
        chunks=(chunk_rows, *(max(1, size) for size in shape[1:])),
        fill_value=fill,
        serializer=BytesCodec(endian="little"),
        compressors=[ZstdCodec(level=ZSTD_LEVEL), Crc32cCodec()],
        chunk_key_encoding=SEPARATOR,
        attributes=dict(attributes),
    )


def create_heap(root: zarr.Group, path: str, chunk_bytes: int) -> None:
    """An empty array of bytes whose chunk files are the bytes themselves.

    Parameters
    ----------
    root : zarr.Group
        The store's root, open for writing.
    path : str
        Of the new array in the store.
    chunk_bytes : int
        Bytes of one chunk file.
    """
    _create(
        root,
        path,
        shape=(0,),
        dtype="uint8",
        chunks=(chunk_bytes,),
        fill_value=0,
        compressors=None,
        chunk_key_encoding=SEPARATOR,
        attributes={"content": "JPEG and PNG files; the frames table has their offsets and lengths"},
    )


def create_frames(root: zarr.Group, path: str, size: tuple[int, int], shard_frames: int) -> None:
    """An empty array of raw frames (n, height, width, 3) uint8, one frame a chunk, in shards.

    Parameters
    ----------
    root : zarr.Group
        The store's root, open for writing.
    path : str
        Of the new array in the store.
    size : (height, width), pixels
    shard_frames : int
        Frames of one shard.
    """
    _create(
        root,
        path,
        shape=(0, *size, 3),
        dtype="uint8",
        chunks=(1, *size, 3),
        shards=(shard_frames, *size, 3),
        fill_value=0,
        compressors=[ZstdCodec(level=ZSTD_LEVEL), Crc32cCodec()],
        chunk_key_encoding=SEPARATOR,
        attributes={"content": "RGB"},
    )


def write_image(root: zarr.Group, path: str, image: NDArray[np.uint8], attributes: Mapping[str, Any]) -> None:
    """One picture (height, width, 3) as an array of its own.

    Parameters
    ----------
    root : zarr.Group
        The store's root, open for writing.
    path : str
        Of the new array in the store.
    image : (height, width, 3) uint8
    attributes : dict
        Kept in the array's document.
    """
    array = _create(
        root,
        path,
        shape=image.shape,
        dtype="uint8",
        chunks=image.shape,
        compressors=[ZstdCodec(level=ZSTD_LEVEL), Crc32cCodec()],
        chunk_key_encoding=SEPARATOR,
        attributes=dict(attributes),
    )
    array[...] = image


def _create(root: zarr.Group, path: str, **options: Any) -> zarr.Array:
    """A new array, and the groups above it that are not there yet."""
    assert isinstance(root.store, BatchStore)
    names = path.split("/")
    for depth in range(1, len(names)):
        group = "/".join(names[:depth])
        if not root.store.batch.has(f"{group}/zarr.json"):
            zarr.create_group(root.store, path=group)
    return zarr.create_array(root.store, name=path, overwrite=True, **options)


def set_length(batch: Batch, path: str, length: int) -> None:
    """An array's number of rows; data beyond are not touched.

    zarr's own ``resize`` would delete whole chunks where a killed commit had left a longer shape; here shrinking and
    growing are the same rewrite of one file.

    Parameters
    ----------
    batch : Batch
        Takes the changed document.
    path : str
        Of the array in the store.
    length : int
        Rows that the array has afterwards.
    """
    place = f"{path}/zarr.json"
    document = json.loads(batch.read(place))
    if document["shape"][0] != length:
        document["shape"][0] = length
        batch.write(place, json.dumps(document, indent=2).encode())


def open_rows(batch: Batch, path: str) -> zarr.Array:
    """An array of a local store, to read and write."""
    return zarr.open_array(BatchStore(batch), path=path, mode="r+", zarr_format=3)


def append_rows(batch: Batch, path: str, start: int, stop: int, blocks: Iterable[NDArray[Any]]) -> None:
    """Rows [start, stop) of an array, written from blocks; each chunk is written once.

    Parameters
    ----------
    batch : Batch
        Takes the changed files.
    path : str
        Of the array in the store.
    start, stop : int
        Rows that are written; the array has ``stop`` rows afterwards.
    blocks : iterable of (n, ...) arrays
        Of any length, together stop - start rows; one chunk of rows is kept in memory.
    """
    set_length(batch, path, stop)
    if start == stop:
        return
    array = open_rows(batch, path)
    chunk = array.chunks[0]
    row = start
    waiting: list[NDArray[Any]] = []
    for block in blocks:
        for piece in np.split(block, range(chunk, len(block), chunk)):
            waiting.append(piece)
            n_whole = (row + sum(map(len, waiting))) // chunk * chunk - row
            if n_whole > 0:
                rows = np.concatenate(waiting)
                array[row : row + n_whole] = rows[:n_whole]
                row, waiting = row + n_whole, [rows[n_whole:]]
    if sum(map(len, waiting)):
        array[row:stop] = np.concatenate(waiting)


def clear_rows(batch: Batch, path: str, length: int) -> None:
    """An array without any trace of rows beyond ``length``, as if they had never been written.

    Parameters
    ----------
    batch : Batch
        Takes the changed files.
    path : str
        Of the array in the store.
    length : int
        Rows that the array keeps.
    """
    array = open_rows(batch, path)
    chunk = array.chunks[0]
    last = -(-length // chunk)
    if length % chunk and array.shape[0] > length:
        set_length(batch, path, last * chunk)
        tail = open_rows(batch, path)
        tail[length:] = tail.fill_value
    set_length(batch, path, length)
    drop_chunks(batch.root / path, last)


def drop_chunks(folder: Path, first: int) -> None:
    """No chunk files of an array from chunk ``first`` (along the rows) on."""
    for place in folder.glob("c.*"):
        if int(place.name.split(".")[1]) >= first:
            place.unlink()

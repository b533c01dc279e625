"""Images on their way into a store: bytes on disk as they come, a row of facts each in memory."""

from __future__ import annotations

import os
import shutil
from collections import deque
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

import google_crc32c
import pyarrow as pa

from tactiledata.contract.records import Image
from tactiledata.store.layout.lock import unwritable
from tactiledata.store.layout.places import Settings, folder_name
from tactiledata.store.layout.shards import pack_frame
from tactiledata.store.write.image_columns import ImageColumns

BUFFER = 2**20
MOST_WAITING = 16
"""Images in memory that wait for their turn."""
PART_BYTES = 2**40
"""Offsets of raw frames count through the files of a camera and size, each of which begins at a multiple of this."""


class Spool:
    """An image sink that writes payloads to a folder; memory stays flat (about 100 bytes an image).

    One file a camera for encoded images. Raw ones are compressed here, once: one file a camera, size and as many frames
    as a shard of the store takes, so that a commit can take such a file as a shard.

    Parameters
    ----------
    folder : Path
        Best the source's staging folder (``writer.staging_folder``): staging then moves nothing. Emptied first.
    largest_payload : int
        Bytes that an encoded image may have.

    Examples
    --------
    >>> import tempfile
    >>> from tactiledata.contract.records import Image
    >>> with tempfile.TemporaryDirectory() as folder, Spool(Path(folder) / "spool") as spool:
    ...     spool.add(Image("digit", b"JPEG bytes", "jpeg", 320, 240, log_ns=5))
    ...     spool.columns()["length"].to_pylist()
    [10]
    """

    def __init__(self, folder: Path | str, largest_payload: int = Settings().heap_chunk_bytes) -> None:
        self.folder = Path(folder)
        self._settings = Settings()
        self._files: dict[str, BinaryIO] = {}
        self._sizes: dict[str, int] = {}
        self._raw_frames: dict[tuple[str, int, int], int] = {}
        self._columns = ImageColumns(largest_payload)
        self._waiting: deque[tuple[Image, Future[tuple[bytes, int]] | None]] = deque()
        self._threads: ThreadPoolExecutor | None = None
        try:
            if self.folder.exists():
                shutil.rmtree(self.folder)
            self.folder.mkdir(parents=True)
        except OSError as error:
            raise unwritable(self.folder, error) from error

    def __enter__(self) -> Spool:
        return self

    def __exit__(self, kind: type[BaseException] | None, _: BaseException | None, __: TracebackType | None) -> None:
        if kind is not None:
            self._waiting.clear()  # what is being thrown away need not be compressed first
        self.close()

    def __len__(self) -> int:
        return len(self._columns) + len(self._waiting)

    def add(self, image: Image) -> None:
        """Take one image; raw ones are compressed by threads meanwhile.

        Raises
        ------
        StoreError
            A payload that cannot be kept (larger than a heap's chunk; raw of another size than stated), or a full disk.
        """
        self._columns.check(image, len(self))
        if image.encoding == "raw":
            if self._threads is None:
                self._threads = ThreadPoolExecutor(default_threads(), thread_name_prefix="spool")
            self._waiting.append((image, self._threads.submit(_packed, image.payload)))
        elif self._waiting:
            self._waiting.append((image, None))
        else:
            self._keep(image, None)
        if len(self._waiting) > MOST_WAITING:
            self._keep(*self._waiting.popleft())

    def _drain(self) -> None:
        while self._waiting:
            self._keep(*self._waiting.popleft())

    def _keep(self, image: Image, packing: Future[tuple[bytes, int]] | None) -> None:
        if packing is not None:
            content, crc = packing.result()
        else:
            content = b"" if image.encoding == "missing" else image.payload
            crc = google_crc32c.value(content)
        self._columns.add(image, {"offset": self._write(image, content), "length": len(content), "crc32c": crc})

    def _write(self, image: Image, content: bytes) -> int:
        """The offset of a payload that was appended to its file."""
        if image.encoding == "missing":
            return -1
        start = self._start(image) if image.encoding == "raw" else 0
        name = spool_name(image.camera, image.encoding, image.height, image.width, start)
        try:
            if name not in self._files:
                self._files[name] = (self.folder / name).open("wb", buffering=BUFFER)
                self._sizes[name] = 0
            self._files[name].write(content)
        except OSError as error:
            raise unwritable(self.folder, error) from error
        self._sizes[name] += len(content)
        return start + self._sizes[name] - len(content)

    def _start(self, image: Image) -> int:
        """The offset at which the file of the next raw frame begins; the file before it is closed when it is full."""
        kind = image.camera, image.height, image.width
        before = self._raw_frames.get(kind, 0)
        self._raw_frames[kind] = before + 1
        part, place = divmod(before, self._settings.frames_per_shard(image.height, image.width))
        if part and not place:
            full = spool_name(image.camera, "raw", image.height, image.width, (part - 1) * PART_BYTES)
            try:
                self._files.pop(full).close()
            except OSError as error:
                raise unwritable(self.folder, error) from error
        return part * PART_BYTES

    def columns(self) -> pa.Table:
        """A row for each image, in the order in which they came, as `ImageColumns.table` has it."""
        self._drain()
        return self._columns.table()

    def bytes_written(self) -> int:
        """Bytes on disk so far."""
        self._drain()
        return sum(self._sizes.values())

    def close(self) -> None:
        """All payloads are in their files."""
        self._drain()
        if self._threads is not None:
            self._threads.shutdown()
            self._threads = None
        try:
            for stream in self._files.values():
                if not stream.closed:
                    stream.close()
        except OSError as error:
            raise unwritable(self.folder, error) from error


def _packed(payload: bytes) -> tuple[bytes, int]:
    return pack_frame(payload), google_crc32c.value(payload)


def default_threads() -> int:
    """Threads that compress raw frames: the processor cores that this process may use, at most four."""
    return max(1, min(4, len(os.sched_getaffinity(0))))


def spool_name(camera: str, encoding: str, height: int, width: int, offset: int = 0) -> str:
    """The spool file of an image: one a camera for encoded images, one a camera, size and shard for raw ones.

    Parameters
    ----------
    camera : str
        Name of the camera.
    encoding : str
        ``"raw"``, or that of encoded images.
    height, width : int
        Pixels; they count for raw images only.
    offset : int
        That of the image; it counts for raw images only, whose bytes begin at its remainder by ``PART_BYTES``.
    """
    if encoding != "raw":
        return f"{folder_name(camera)}.spool"
    part = offset // PART_BYTES
    return f"{folder_name(camera)}.rgb_{height}x{width}{f'.{part}' if part else ''}"

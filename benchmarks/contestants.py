"""Ways in which tactile frames are kept and read at random; each writes the same frames and gives batches of pixels.

Each imports its library where it uses it, so that a contestant's process holds its own library only.
"""

from __future__ import annotations

import io
import itertools
import tarfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]
SHUFFLE_BUFFER = 256


def folder_bytes(folder: Path) -> int:
    """Bytes that all files in a folder take on the disk; holes in sparse files take none."""
    return sum(path.stat().st_blocks * 512 for path in folder.rglob("*") if path.is_file())


def decode(payload: bytes) -> Pixels:
    """The picture in JPEG or PNG bytes, (H, W, 3) RGB."""
    return cv2.imdecode(np.frombuffer(payload, np.uint8), cv2.IMREAD_COLOR_RGB)


def _filled(count: int, read: Callable[[int], Pixels], pool: ThreadPoolExecutor | None) -> Pixels:
    """Pictures stacked into one array that is made once, by a pool where there is one."""
    first = read(0)
    pixels = np.empty((count, *first.shape), np.uint8)
    pixels[0] = first

    def fill(place: int) -> None:
        pixels[place] = read(place)

    places = range(1, count)
    list(pool.map(fill, places) if pool else map(fill, places))
    return pixels


class Contestant:
    """Frames in a folder, read in batches."""

    def read(self, rows: Sequence[int]) -> None:
        """Read a batch and let it go: what is timed."""
        self.batch(rows)

    def batch(self, rows: Sequence[int]) -> tuple[Sequence[int], Pixels]:
        """Rows that were read, and their pixels (n, H, W, 3) uint8 RGB."""
        raise NotImplementedError

    def checksums(self, batches: Sequence[Sequence[int]]) -> dict[int, int]:
        """A CRC of the pixels of every frame in some batches, by row."""
        return {
            int(row): zlib.crc32(np.ascontiguousarray(picture))
            for rows in batches
            for row, picture in zip(*self.batch(rows), strict=True)
        }


class LooseFiles(Contestant):
    """One JPEG or PNG file a frame, read by OpenCV; with ``threads`` > 1 from a thread pool."""

    def __init__(self, folder: Path, threads: int) -> None:
        self._files = sorted(str(path) for path in folder.iterdir())
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    @staticmethod
    def write(folder: Path, pictures: Iterator[tuple[bytes, Pixels]], extension: str) -> None:
        """Write the encoded bytes as files."""
        folder.mkdir()
        for row, (payload, _) in enumerate(pictures):
            (folder / f"{row:06d}{extension}").write_bytes(payload)

    def batch(self, rows: Sequence[int]) -> tuple[Sequence[int], Pixels]:
        """Rows and pixels."""
        return rows, _filled(len(rows), lambda place: self._read(rows[place]), self._pool)

    def _read(self, row: int) -> Pixels:
        return cv2.imread(self._files[row], cv2.IMREAD_COLOR_RGB)


class Hdf5Chunked(Contestant):
    """Decoded frames in an HDF5 dataset, one frame a chunk, gzip, read in a loop: h5py has one lock for all threads."""

    def __init__(self, folder: Path) -> None:
        import h5py

        self._frames = h5py.File(folder / "frames.h5", "r")["frames"]

    @staticmethod
    def write(folder: Path, pictures: Iterator[tuple[bytes, Pixels]], count: int) -> None:
        """Write the decoded pixels."""
        import h5py

        folder.mkdir()
        first = next(pictures)
        shape = first[1].shape
        with h5py.File(folder / "frames.h5", "w") as file:
            frames = file.create_dataset(
                "frames", (count, *shape), np.uint8, chunks=(1, *shape), compression="gzip", compression_opts=4
            )
            for row, (_, pixels) in enumerate(itertools.chain([first], pictures)):
                frames[row] = pixels

    def batch(self, rows: Sequence[int]) -> tuple[Sequence[int], Pixels]:
        """Rows and pixels."""
        return rows, _filled(len(rows), lambda place: self._frames[rows[place]], None)


class Hdf5Bytes(Contestant):
    """Encoded bytes as variable-length entries of an HDF5 dataset, decoded by OpenCV; a thread pool may decode."""

    def __init__(self, folder: Path, threads: int) -> None:
        import h5py

        self._frames = h5py.File(folder / "bytes.h5", "r")["frames"]
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    @staticmethod
    def write(folder: Path, pictures: Iterator[tuple[bytes, Pixels]], count: int) -> None:
        """Write the encoded bytes."""
        import h5py

        folder.mkdir()
        with h5py.File(folder / "bytes.h5", "w") as file:
            frames = file.create_dataset("frames", (count,), h5py.vlen_dtype(np.uint8))
            for row, (payload, _) in enumerate(pictures):
                frames[row] = np.frombuffer(payload, np.uint8)

    def batch(self, rows: Sequence[int]) -> tuple[Sequence[int], Pixels]:
        """Rows and pixels."""
        payloads = [self._frames[row] for row in rows]
        return rows, _filled(len(rows), lambda place: decode(payloads[place]), self._pool)


class ZarrPlain(Contestant):
    """Decoded frames in a Zarr array, one frame a chunk, zstd, read in a loop.

    zarr-python's batch index (``array.oindex[rows]``) is several times slower than the loop on Python 3.11.
    """

    def __init__(self, folder: Path) -> None:
        import zarr

        self._frames: Any = zarr.open_array(folder / "frames.zarr", mode="r")

    @staticmethod
    def write(folder: Path, pictures: Iterator[tuple[bytes, Pixels]], count: int) -> None:
        """Write the decoded pixels."""
        import zarr

        from tactiledata.store.layout.arrays import ZSTD_LEVEL

        folder.mkdir()
        first = next(pictures)
        shape = first[1].shape
        frames = zarr.create_array(
            folder / "frames.zarr",
            shape=(count, *shape),
            chunks=(1, *shape),
            dtype=np.uint8,
            compressors=zarr.codecs.ZstdCodec(level=ZSTD_LEVEL),
        )
        for row, (_, pixels) in enumerate(itertools.chain([first], pictures)):
            frames[row] = pixels

    def batch(self, rows: Sequence[int]) -> tuple[Sequence[int], Pixels]:
        """Rows and pixels."""
        return rows, _filled(len(rows), lambda place: self._frames[rows[place]], None)


class WebDatasetShards(Contestant):
    """Encoded bytes in tar shards, read in sequence through a shuffle buffer: no random access, for comparison."""

    def __init__(self, folder: Path) -> None:
        import webdataset

        shards = sorted(str(path) for path in folder.glob("*.tar"))
        samples = webdataset.WebDataset(shards, shardshuffle=False, empty_check=False)
        self._stream = iter(samples.shuffle(SHUFFLE_BUFFER, initial=SHUFFLE_BUFFER).repeat())

    @staticmethod
    def write(folder: Path, pictures: Iterator[tuple[bytes, Pixels]], extension: str, per_shard: int = 500) -> None:
        """Write the encoded bytes as tar shards."""
        folder.mkdir()
        for shard in itertools.count():
            part = list(itertools.islice(pictures, per_shard))
            if not part:
                return
            with tarfile.open(folder / f"data-{shard:06d}.tar", "w") as tar:
                for place, (payload, _) in enumerate(part):
                    entry = tarfile.TarInfo(f"{shard * per_shard + place:06d}{extension}")
                    entry.size = len(payload)
                    tar.addfile(entry, io.BytesIO(payload))

    def batch(self, rows: Sequence[int]) -> tuple[Sequence[int], Pixels]:
        """The next frames of the stream, whatever rows were asked for."""
        samples = list(itertools.islice(self._stream, len(rows)))
        keys = [int(sample["__key__"]) for sample in samples]
        payloads = [sample.get("jpg", sample.get("png")) for sample in samples]
        return keys, _filled(len(keys), lambda place: decode(payloads[place]), None)

"""Images of a store, found and decoded in batches; safe to use after a fork."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Literal, Protocol

import google_crc32c
import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.contract import image_bytes
from tactiledata.contract.image_bytes import decode_rgb
from tactiledata.contract.take import FrameFlag
from tactiledata.errors import BrokenLog, StoreError
from tactiledata.store.layout.manifest import settings_of
from tactiledata.store.layout.places import heap_path, rgb_path
from tactiledata.store.layout.shards import Entries, index_bytes, parse_index, unpack_frame
from tactiledata.store.read.files import Span, StoreFiles, missing_file
from tactiledata.store.read.scaled_pictures import average_into, decode_jpeg_into, decode_smaller_jpeg, need_smaller

COLUMNS = ("camera", "encoding", "height", "width", "offset", "length", "crc32c", "flags")
MOST_THREADS = 16


class KeptPictures(Protocol):
    """Decoded pictures that are kept somewhere, by rows of frames; asked by several threads at once."""

    def read(self, row: int, target: PictureArray) -> bool:
        """Whether the picture of a frame is kept, and was put into ``target`` (h, w, 3)."""

    def keep(self, row: int, picture: PictureArray) -> None:
        """Keep the picture (h, w, 3) of a frame, where there is room for it."""


class Pictures:
    """The images of a store: their places, and what they show.

    tensorstore would read shards as fast, but ends the process when it is used on both sides of a fork, which is how
    PyTorch starts its workers; a shard's index and frames are read here instead (`shards`).

    Parameters
    ----------
    files : StoreFiles
    manifest : dict
    frames : callable
        Gives columns of the frames table.
    """

    def __init__(
        self, files: StoreFiles, manifest: Mapping[str, Any], frames: Callable[[Sequence[str]], pa.Table]
    ) -> None:
        self._files, self._settings, self._frames = files, settings_of(manifest), frames
        self._columns: dict[str, NDArray[Any]] = {}
        self._cameras: list[str] = []
        self._encodings: list[str] = []
        self._indexes: dict[str, Entries] = {}
        self._pool: tuple[int, int, ThreadPoolExecutor] | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_columns": {}, "_indexes": {}, "_pool": None}

    def _load(self) -> dict[str, NDArray[Any]]:
        if not self._columns:
            table = self._frames(COLUMNS).combine_chunks()
            columns = {name: table[name].to_numpy() for name in COLUMNS[2:]}
            for name in ("camera", "encoding"):
                chunks = table[name].chunks
                columns[name] = np.asarray(chunks[0].indices) if chunks else np.empty(0, np.int32)
                setattr(self, f"_{name}s", chunks[0].dictionary.to_pylist() if chunks else [])
            self._columns = columns
        return self._columns

    def facts(self, row: int) -> tuple[str, str, int, int]:
        """Camera, encoding, height and width of a frame."""
        columns = self._load()
        camera, encoding = self._cameras[columns["camera"][row]], self._encodings[columns["encoding"][row]]
        return camera, encoding, int(columns["height"][row]), int(columns["width"][row])

    def _spans(self, rows: Sequence[int]) -> list[tuple[str, Span | None]]:
        """Each frame's encoding, and where its bytes lie; ``None`` where there are none."""
        columns, wanted = self._load(), np.asarray(rows, np.int64)
        names = ("camera", "encoding", "height", "width", "offset", "length")
        # picked in bulk: one by one, looking places up takes a tenth of the time that decoding takes
        facts = zip(*(columns[name][wanted].tolist() for name in names), strict=True)
        heaps = {code: heap_path(camera) for code, camera in enumerate(self._cameras)}
        chunk = self._settings.heap_chunk_bytes
        spans: list[tuple[str, Span | None]] = []
        for camera, code, height, width, offset, length in facts:
            encoding = self._encodings[code]
            if encoding == "raw":
                spans.append((encoding, self._raw_span(self._cameras[camera], height, width, offset)))
            elif encoding == "missing" or not length:
                spans.append((encoding, None))
            else:
                start = offset % chunk
                spans.append((encoding, (f"{heaps[camera]}/c.{offset // chunk}", start, start + length)))
        return spans

    def _raw_span(self, camera: str, height: int, width: int, offset: int) -> Span:
        capacity = self._settings.frames_per_shard(height, width)
        path = f"{rgb_path(camera, height, width)}/c.{offset // capacity}.0.0.0"
        start, size = self._index(path, capacity, offset % capacity)[offset % capacity]
        return path, start, start + size

    def _index(self, path: str, capacity: int, position: int) -> Entries:
        """A shard's index; read again where a frame was appended since."""
        entries = self._indexes.get(path)
        if entries is None or entries[position][1] >= 2**63:
            forget = getattr(self._files, "forget", None)
            if entries is not None and forget:
                forget(path)
            content = self._fetch([(path, -index_bytes(capacity), 0)])[0]
            entries = self._indexes[path] = parse_index(content, capacity, path)
        if entries[position][1] >= 2**63:
            raise StoreError(f"shard {path} holds no frame at {position}", "every frame that the manifest names")
        return entries

    def _fetch(self, spans: Sequence[Span]) -> list[bytes]:
        try:
            return self._files.spans(spans)
        except FileNotFoundError as error:
            path = str(error.filename or error).removeprefix(f"{self._files.location}/")
            raise missing_file(path, self._files.location) from error

    def payloads(self, rows: Sequence[int], verify: bool) -> list[bytes | None]:
        """The bytes of frames as kept: JPEG or PNG files, raw RGB unpacked, ``None`` where no image was recorded."""
        found = self._spans(rows)
        contents = iter(self._fetch([span for _, span in found if span]))
        payloads: list[bytes | None] = []
        for row, (encoding, span) in zip(rows, found, strict=True):
            if encoding == "missing":
                payloads.append(None)
                continue
            content = next(contents) if span else b""
            if encoding == "raw":
                content = self._unpacked(row, content).tobytes()
            elif verify:
                self._verify(row, content)
            payloads.append(content)
        return payloads

    def _verify(self, row: int, content: bytes) -> None:
        """A damaged JPEG usually still decodes, to other pixels: only its CRC-32C tells."""
        if google_crc32c.value(content) != self._load()["crc32c"][row]:
            raise self._damaged(row, content, "does not fit its CRC-32C", "the bytes that were recorded")

    def _damaged(self, row: int, content: bytes, what: str, expected: str) -> StoreError:
        marked = bool(self._load()["flags"][row] & FrameFlag.BROKEN)
        return StoreError(
            f"the image of frame {row} ({len(content)} bytes) {what}"
            + (" (the store marks it as broken)" if marked else ""),
            expected,
            "Leave out frames with the flag BROKEN; `tactiledata check --decode --repair` marks damaged ones.",
            row=row,
        )

    def pictures(
        self,
        rows: Sequence[int],
        threads: int | None,
        when_missing: Literal["error", "zeros"],
        size: Sequence[int] | None = None,
        kept: KeptPictures | None = None,
    ) -> list[PictureArray] | PictureArray:
        """Return decoded frames: one array (n, H, W, 3) where they all have one size, else a list of (H, W, 3).

        Parameters
        ----------
        rows : sequence of n int
            Rows of frames.
        threads : int, optional
            Threads that decode; one a core where ``None``.
        when_missing : "error" or "zeros"
            What to do for captured moments without an image.
        size : (rows, columns), optional
            A smaller size, at which pictures are decoded.
        kept : KeptPictures, optional
            Pictures that were decoded before, at this size; others are added.

        Raises
        ------
        StoreError
            An image that is damaged, or missing where ``when_missing`` is "error".
        UsageError
            A size that is larger than that of a picture.
        """
        if not len(rows):
            return []
        self._require_decodable(rows)
        out = self._targets(rows, size)
        places = list(range(len(rows)))
        if kept is not None:
            lacking: list[int] = []

            def look(place: int) -> None:
                if not kept.read(rows[place], out[place]):
                    lacking.append(place)

            self._each(look, places, threads)
            places = sorted(lacking)
        found = self._spans([rows[place] for place in places])
        contents = iter(self._fetch([span for _, span in found if span]))
        jobs = [
            (place, encoding, next(contents) if span else b"")
            for place, (encoding, span) in zip(places, found, strict=True)
        ]

        def decode(job: tuple[int, str, bytes]) -> None:
            place, encoding, content = job
            self._decode(rows[place], encoding, content, out[place], when_missing)
            if kept is not None and encoding != "missing":
                kept.keep(rows[place], out[place])

        self._each(decode, jobs, threads)
        return out

    def _targets(self, rows: Sequence[int], size: Sequence[int] | None) -> list[PictureArray] | PictureArray:
        """Arrays to decode into: one (n, H, W, 3) where all pictures get one size, else a list of (H, W, 3)."""
        columns, wanted = self._load(), list(rows)
        heights, widths = columns["height"][wanted], columns["width"][wanted]
        if size is not None:
            return np.empty((len(rows), *need_smaller(size, (int(heights.min()), int(widths.min()))), 3), np.uint8)
        if (heights == heights[0]).all() and (widths == widths[0]).all():
            return np.empty((len(rows), int(heights[0]), int(widths[0]), 3), np.uint8)
        sizes = zip(heights.tolist(), widths.tolist(), strict=True)
        return [np.empty((height, width, 3), np.uint8) for height, width in sizes]

    def _each(self, work: Callable[[Any], None], jobs: Sequence[Any], threads: int | None) -> None:
        """Every job, done by some threads."""
        # threads take the next job when they are done with one: shares fixed beforehand would wait for the slowest
        waiting = iter(jobs)

        def run(_: int) -> None:
            for job in waiting:
                work(job)

        n_threads = min(threads or default_threads(), len(jobs), MOST_THREADS)
        if n_threads <= 1:
            run(0)
        else:
            list(self._threads(n_threads).map(run, range(n_threads)))

    def _threads(self, count: int) -> ThreadPoolExecutor:
        if self._pool is None or self._pool[0] != os.getpid() or self._pool[1] < count:
            self._pool = os.getpid(), count, ThreadPoolExecutor(count, thread_name_prefix="pictures")
        return self._pool[2]

    def _decode(self, row: int, encoding: str, content: bytes, target: PictureArray, when_missing: str) -> None:
        if encoding == "missing":
            if when_missing != "zeros":
                raise StoreError(
                    f"frame {row} has no image: the recording says that it was not kept",
                    "frames with an image",
                    "Leave such frames out (flag MISSING), or ask with missing='zeros'.",
                    row=row,
                )
            target[...] = 0
            return
        _, _, height, width = self.facts(row)
        shape = (height, width, 3)
        if encoding == "raw":
            if shape == target.shape:
                self._unpacked(row, content, target)
            else:
                average_into(self._unpacked(row, content), target)
            return
        self._verify(row, content)
        if encoding == "jpeg" and (
            decode_jpeg_into(content, target) if shape == target.shape else decode_smaller_jpeg(content, shape, target)
        ):
            return
        average_into(self._decoded(row, content, shape), target)

    def _decoded(self, row: int, content: bytes, shape: tuple[int, ...]) -> PictureArray:
        expected = f"a JPEG or PNG file of {shape[0]} x {shape[1]} pixels"
        try:
            picture = decode_rgb(content)
        except BrokenLog as error:
            raise self._damaged(row, content, f"does not decode: {error.found}", expected) from error
        if picture.shape != shape:
            raise self._damaged(row, content, f"decodes to {picture.shape}", expected)
        return picture

    def _require_decodable(self, rows: Sequence[int]) -> None:
        """Refuse frames beyond the limit of decoded size with a `StoreError`, before memory is taken."""
        columns, wanted = self._load(), np.asarray(rows, np.int64)
        sizes = columns["height"][wanted].astype(np.int64) * columns["width"][wanted]
        for row in wanted[sizes > image_bytes.MAX_DECODED_PIXELS].tolist():
            if fault := image_bytes.size_fault(int(columns["height"][row]), int(columns["width"][row])):
                raise StoreError(
                    f"the image of frame {row} is not decoded: its {fault}",
                    f"images of at most {image_bytes.MAX_DECODED_PIXELS} pixels",
                    "`tactiledata check --repair` marks it, so that it is left out.",
                    row=row,
                )

    def _unpacked(self, row: int, content: bytes, target: PictureArray | None = None) -> PictureArray:
        _, _, height, width = self.facts(row)
        if target is None:
            self._require_decodable([row])
        picture = np.empty((height, width, 3), np.uint8) if target is None else target
        try:
            unpack_frame(content, picture)
        except ValueError as error:
            raise self._damaged(row, content, f"is damaged: {error}", "an intact shard") from error
        return picture


def default_threads() -> int:
    """Threads that decode a batch where the caller does not say: the processor cores that this process may use."""
    return max(1, min(8, len(os.sched_getaffinity(0))))

"""Mean and spread of streams over the train part of a split, kept beside the split."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fsspec
import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.sealed import fits_seal, sealed_json
from tactiledata.errors import UsageError
from tactiledata.loaders.picture_reading import PictureReading
from tactiledata.loaders.streams import Stream, values_at_frames
from tactiledata.splits.manifest import Split, frame_rows, partition_rows

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

FORMAT = "tactiledata-normalisation/2"
SUFFIX = ".normalisation.json"
CHUNK_ROWS = 8192
"""Rows read at once; part of the result's last digits, hence fixed."""

IMAGE_SAMPLE = 2048
"""At most so many train frames, evenly spaced, stand for all of them where images are measured."""

IMAGE_CHUNK = 64


@dataclass(frozen=True)
class Normaliser:
    """Values scaled to mean 0 and standard deviation 1, column by column.

    Parameters
    ----------
    columns : (k,) names
        Of a signal's columns, or ``red``, ``green``, ``blue``.
    units : (k,) names
    mean, std : (k,) float
        In ``units``; ``std`` is 1 for a column that never changes.
    minimum, maximum : (k,) float
    rows : int
        Rows with finite values that it was computed from.
    left_out : int
        Train rows without a finite value.
    """

    columns: tuple[str, ...]
    units: tuple[str, ...]
    mean: tuple[float, ...]
    std: tuple[float, ...]
    minimum: tuple[float, ...]
    maximum: tuple[float, ...]
    rows: int
    left_out: int = 0

    def apply(self, values: NDArray[Any]) -> NDArray[np.float32]:
        """Values (..., k) in units, scaled."""
        return ((values - np.asarray(self.mean)) / np.asarray(self.std)).astype(np.float32)

    def invert(self, values: NDArray[Any]) -> NDArray[np.float32]:
        """Scaled values (..., k), back in units."""
        return (values * np.asarray(self.std) + np.asarray(self.mean)).astype(np.float32)

    def document(self) -> dict[str, Any]:
        """Means and spreads as JSON values."""
        return {name: list(value) if isinstance(value, tuple) else value for name, value in vars(self).items()}

    @classmethod
    def from_document(cls, document: Mapping[str, Any]) -> Normaliser:
        """The inverse of `document`."""
        facts: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value for name, value in document.items()
        }
        return cls(**facts)


def measure(chunks: Iterable[NDArray[Any]], columns: tuple[str, ...], units: tuple[str, ...]) -> Normaliser:
    """Return mean and spread of rows that come in chunks; rows that are not finite are left out and counted.

    Chunk moments are merged as in Chan, Golub and LeVeque (1979), so that millions of rows lose no digits.

    Parameters
    ----------
    chunks : iterable of (n, k)
        Rows of k numbers.
    columns, units : tuple of k str
        Names and units of the numbers.

    Raises
    ------
    UsageError
        No row is finite.

    Examples
    --------
    >>> measure([np.array([[0.0], [2.0]]), np.array([[4.0]])], ("fz",), ("N",)).mean
    (2.0,)
    """
    width = len(columns)
    count, left_out = 0, 0
    mean, squares = np.zeros(width), np.zeros(width)
    minimum, maximum = np.full(width, np.inf), np.full(width, -np.inf)
    for chunk in chunks:
        values = np.asarray(chunk, np.float64)
        finite = values[np.isfinite(values).all(axis=1)]
        n = len(finite)
        left_out += len(values) - n
        values = finite
        if n == 0:
            continue
        chunk_mean = values.mean(axis=0)
        step, total = chunk_mean - mean, count + n
        squares += ((values - chunk_mean) ** 2).sum(axis=0) + step**2 * (count * n / total)
        mean = mean + step * (n / total)
        minimum, maximum = np.minimum(minimum, values.min(axis=0)), np.maximum(maximum, values.max(axis=0))
        count = total
    if count == 0:
        raise UsageError(
            f"none of {left_out} train rows has finite values of {', '.join(columns)}",
            "values to compute a mean from",
            "Leave this stream out of `normalise`, or look at `tactiledata info`.",
        )
    std = np.where(maximum == minimum, 1.0, np.sqrt(squares / count))
    return Normaliser(columns, units, _floats(mean), _floats(std), _floats(minimum), _floats(maximum), count, left_out)


def _floats(array: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(float(number) for number in array)


def image_moments(
    pictures: Callable[[NDArray[np.int64]], Iterable[NDArray[np.uint8]]], rows: NDArray[np.int64]
) -> Normaliser:
    """Mean and spread of the colours, in [0, 1], over at most ``IMAGE_SAMPLE`` of the frames, evenly spaced."""
    if len(rows) > IMAGE_SAMPLE:
        rows = rows[np.linspace(0, len(rows) - 1, IMAGE_SAMPLE).round().astype(np.int64)]

    counts = np.zeros((3, 256), np.int64)
    for start in range(0, len(rows), IMAGE_CHUNK):
        for picture in pictures(rows[start : start + IMAGE_CHUNK]):
            counts += [np.bincount(picture[..., colour].ravel(), minlength=256) for colour in range(3)]
    return _from_counts(counts)


def _from_counts(counts: NDArray[np.int64]) -> Normaliser:
    """Moments of 8-bit colours from how often each level occurs, (3, 256): exact, whatever the number of pixels."""
    pixels = int(counts[0].sum())
    if pixels == 0:
        raise UsageError("no train frame has an image", "images to compute a mean from", "Leave images out.")
    level = np.arange(256) / 255.0
    mean = counts @ level / pixels
    squares = [(count * (level - one) ** 2).sum() for count, one in zip(counts, mean, strict=True)]
    seen = [np.flatnonzero(count) for count in counts]
    minimum, maximum = (np.array([level[which[end]] for which in seen]) for end in (0, -1))
    std = np.where(maximum == minimum, 1.0, np.sqrt(np.array(squares) / pixels))
    return Normaliser(
        ("red", "green", "blue"),
        ("1", "1", "1"),
        _floats(mean),
        _floats(std),
        _floats(minimum),
        _floats(maximum),
        pixels,
    )


def in_chunks(read: Callable[[NDArray[np.int64]], NDArray[Any]], rows: NDArray[np.int64]) -> Iterable[NDArray[Any]]:
    """What ``read`` gives for rows, some thousand rows at a time."""
    return (read(rows[start : start + CHUNK_ROWS]) for start in range(0, len(rows), CHUNK_ROWS))


class Cache:
    """Normalisers of one split, kept in ``splits/<name>.normalisation.json`` and tied to the split and the store.

    A file of another split or of another state of the store is not used and is written anew. Where the store cannot be
    written to, nothing is kept.
    """

    def __init__(self, store: Store, split: Split) -> None:
        self._path = str(store.split_path(split.name)).removesuffix(".parquet") + SUFFIX
        self._key = {
            "format": FORMAT,
            "split": split.name,
            "part": "train",
            "split_sha256": split.document["table"]["sha256"],
            "store_digest": store.digest,
        }

    def read(self) -> dict[str, Normaliser]:
        """The normalisers that are kept, by stream; none where the file is missing, damaged or of other data."""
        try:
            with fsspec.open(self._path, "rb") as stream:
                content = stream.read()
            document = json.loads(content)
            if not fits_seal(content) or {name: document.get(name) for name in self._key} != self._key:
                return {}
            return {name: Normaliser.from_document(value) for name, value in document["streams"].items()}
        except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError):
            return {}

    def write(self, normalisers: Mapping[str, Normaliser]) -> str:
        """Keep these beside those that are kept; why they are not kept, else an empty text."""
        if "://" in self._path:
            return f"normalisation is not kept: {self._path} is not a local file"
        streams = {name: one.document() for name, one in {**self.read(), **normalisers}.items()}
        try:
            write_atomic(Path(self._path), sealed_json({**self._key, "streams": streams}))
        except OSError as error:
            return f"normalisation is not kept: {error.strerror} ({self._path})"
        return ""


def normalisers(
    store: Store, split: Split, streams: Sequence[Stream], size: tuple[int, int] | None = None
) -> tuple[dict[str, Normaliser], tuple[str, ...]]:
    """Return normalisers by stream, from the cache or computed and kept, and notes: rows left out, not kept and why.

    Parameters
    ----------
    store : Store
        Where the values are; its folder of splits holds the cache.
    split : Split
        A split of the store.
    streams : sequence of Stream
        Streams that are to be normalised.
    size : (rows, columns), optional
        Of pictures, where they are read smaller: means over areas spread less.
    """
    cache = Cache(store, split)
    kept = cache.read()
    keys = {stream.name: f"{stream.kind}:{stream.name}{_state(store, stream, size)}" for stream in streams}
    fresh = {
        keys[stream.name]: measure_stream(store, split, stream, size)
        for stream in streams
        if keys[stream.name] not in kept
    }
    note = cache.write(fresh) if fresh else ""
    found = {**kept, **fresh}
    chosen = {name: found[key] for name, key in keys.items()}
    left_out = [
        f"normalisation of {name}: {one.left_out} of {one.left_out + one.rows} train rows have no finite value and do "
        "not count"
        for name, one in chosen.items()
        if one.left_out
    ]
    return chosen, (*left_out, *([note] if note else []))


def _state(store: Store, stream: Stream, size: tuple[int, int] | None) -> str:
    """What tells sizes of pictures apart, and states of a mesh: the store's digest is that of what was recorded."""
    if stream.is_picture:
        return f"@{size[0]}x{size[1]}" if size else ""
    return f":{store.mesh(stream.mesh).facts['digest']}" if stream.is_of_mesh else ""


def measure_stream(store: Store, split: Split, stream: Stream, size: tuple[int, int] | None = None) -> Normaliser:
    """Return mean and spread of one stream over the train part of a split.

    Values and pictures are those of the frames in train; a signal at its native rate is taken over the whole of the
    trajectories in train, free air included; backgrounds are those of the sensors in train, one each.

    Parameters
    ----------
    store : Store
        Where the values are.
    split : Split
        A split of the store.
    stream : Stream
        The stream.
    size : (rows, columns), optional
        Of pictures, where they are read smaller.

    Raises
    ------
    UsageError
        The stream has no finite value in train.
    """
    rows = frame_rows(store, split, "train")
    if stream.kind == "image":
        camera = pc.equal(store.frames(["camera"])["camera"].cast(pa.string()), stream.name).to_numpy()
        return image_moments(partial(store.images, size=size), rows[camera[rows]])
    if stream.kind == "background":
        sensors = sorted(set(store.frames(["sensor"])["sensor"].take(rows).to_pylist()))
        references = PictureReading(size).of_sensors(store)
        images = [references[sensor] for sensor in sensors]
        return image_moments(lambda places: [images[place] for place in places], np.arange(len(images)))
    if stream.kind == "signal":
        chunks: Iterable[NDArray[Any]] = _segments(store, split, stream.name)
    else:
        chunks = in_chunks(partial(values_at_frames, store, stream), rows)
    return measure(chunks, stream.columns, stream.units)


def _segments(store: Store, split: Split, name: str) -> Iterable[NDArray[Any]]:
    trajectories = store.trajectories(["uid", "signal_rows"])
    in_train = partition_rows(split, trajectories["uid"]) == "train"
    signal = store.signal(name)
    for text in trajectories["signal_rows"].filter(pa.array(in_train)).to_pylist():
        start, stop = json.loads(text or "{}").get(name, (0, 0))
        yield signal.values(start, stop)

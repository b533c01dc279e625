"""The store as arrays: frames or whole trajectories of one part of a split, without torch."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.contract.provenance import digest_of
from tactiledata.errors import StoreError, UnknownName, UsageError
from tactiledata.loaders.cache_room import CACHE_BYTES
from tactiledata.loaders.facts import item_table
from tactiledata.loaders.fit import require_one_size, require_references
from tactiledata.loaders.index import build_index
from tactiledata.loaders.missing import Missing, treat_missing
from tactiledata.loaders.normalise import Normaliser, normalisers
from tactiledata.loaders.order import Order, item_number
from tactiledata.loaders.picture_arrays import fill_fractions
from tactiledata.loaders.picture_reading import picture_reading
from tactiledata.loaders.selection import LoadReport, Selection, select
from tactiledata.loaders.streams import Stream, Unit, find_streams, nodes_at_frames, values_at_frames
from tactiledata.store.read.reader import RowState, Store

Item = dict[str, Any]
IMAGE_DTYPES = ("float32", "uint8")
TIMES = "_t_ns"
"""Added to a signal's name: the key of its sample times."""


class TactileArrays:
    """One part of a split as numpy arrays; it can be pickled, and every process opens the store for itself.

    Parameters
    ----------
    location : str or Path
        A store, local or any fsspec URL.
    split : str
        ``"<split>/<part>"``; there is no default. ``"all"`` only with ``allow_leaks``.
    streams : sequence of str
        A camera (pictures), a signal (in frame mode its values at the moments of the frames, in trajectory mode its
        samples at their native rate, their times under ``<name>_t_ns``), ``"background"`` (the sensor's picture without
        contact), values that a corpus annotates image by image, or what a replay attached: ``"mesh"`` (displacements
        (k, 3), m), ``"mesh_wrench"`` (6,), ``"contact_mask"`` (m,) bool. Values that were not recorded are NaN.
    unit : "frame" or "trajectory"
        What an item is. A trajectory has all its readable frames; ``in_split`` marks those that the split's contact
        filter takes.
    normalise : bool or sequence of str
        Streams to scale to mean 0 and standard deviation 1, by the train part of the split; ``True``: all streams of
        numbers, but for the nodes of a mesh.
    missing : "warn", "keep" or "drop"
        What to do where a stream of numbers has NaN, or a trajectory no samples of a signal: warn
        (`MissingValuesWarning`) and keep, keep, or leave the item out. ``report.missing`` counts them by stream.
    image_dtype : "float32" or "uint8"
        float32 in [0, 1], or the bytes as stored.
    image_size : (rows, columns), optional
        A smaller size for all pictures, at which they are decoded: cheaper than making them smaller afterwards.
    cache : path, optional
        A folder on a local disk in which decoded pictures are kept: filled as they are read, shared by workers and by
        processes. Not used where a recording of the store changed.
    cache_bytes : int
        What all caches of that folder may take; pictures beyond are decoded each time.
    allow_leaks : bool
    threads : int, optional
        Threads that decode images; by default the store chooses.
    storage_options : dict, optional
        For fsspec.

    Attributes
    ----------
    report : LoadReport
        What it holds, and what it leaves out and why.
    normalisers : dict of Normaliser, by stream
    fingerprint : str
        The same for the same items of the same store.

    Raises
    ------
    MissingSplit, UnknownName, UsageError, StoreError, LeakError
    """

    def __init__(
        self,
        location: str | os.PathLike[str],
        split: str | None = None,
        streams: Sequence[str] | str = ("digit", "wrench"),
        unit: Unit = "frame",
        *,
        normalise: bool | Sequence[str] = False,
        missing: Missing = "warn",
        image_dtype: str = "float32",
        image_size: Sequence[int] | None = None,
        cache: str | os.PathLike[str] | None = None,
        cache_bytes: int = CACHE_BYTES,
        allow_leaks: bool = False,
        threads: int | None = None,
        storage_options: Mapping[str, Any] | None = None,
    ) -> None:
        if image_dtype not in IMAGE_DTYPES:
            raise UnknownName("image_dtype", str(image_dtype), IMAGE_DTYPES)
        if threads is not None and threads < 1:
            raise UsageError(f"{threads} threads", "at least 1, or None to let the store choose")
        self.location = os.fspath(location)
        self.unit = unit
        self.image_dtype = image_dtype
        self.threads = threads
        self._storage_options = dict(storage_options or {})
        self._process = -1
        self._row_state: RowState | None = None
        store = self.store
        self._row_state = store.row_state
        self.streams = find_streams(store, streams, unit)
        camera = next((stream.name for stream in self.streams if stream.kind == "image"), None)
        selection = select(store, split, camera, whole=unit == "trajectory", allow_leaks=allow_leaks)
        self.index = build_index(store, selection, unit)
        self.report: LoadReport = selection.report
        self._require_items("Name another part, or make the split again with other fractions or another force filter.")
        self.index, self.report = treat_missing(store, self.index, self.streams, self.report, missing)
        self._require_items("Name other streams, or say missing='keep' to have those items with NaN.")
        require_references(store, self.index, self.streams)
        require_one_size(store, self.index, camera)
        self._pictures = picture_reading(store, self.index, self.streams, image_size, cache, cache_bytes)
        self.normalisers, notes = self._find_normalisers(selection, normalise)
        self.report = self.report.noted(self._pictures.note, *notes)
        self.fingerprint = digest_of([store.digest, selection.report.split, unit, self._rows_digest()])

    def _rows_digest(self) -> str:
        return hashlib.sha256(self.index.rows.tobytes() + self.index.starts.tobytes()).hexdigest()

    @property
    def store(self) -> Store:
        """The store, opened by this process: handles and threads do not survive a fork."""
        if self._process != os.getpid():
            self._store = Store.open(self.location, self._storage_options or None)
            if self._row_state is not None and not self._store.continues(self._row_state):
                raise StoreError(
                    f"in the store {self.location} a recording was replaced since this dataset was made",
                    "the rows that it was made of",
                    "Draw the split anew and make the dataset anew.",
                )
            self._references: dict[str, NDArray[np.uint8]] = {}
            self._process = os.getpid()
        return self._store

    def __getstate__(self) -> dict[str, Any]:
        kept = {name: value for name, value in vars(self).items() if name not in ("_store", "_references")}
        return {**kept, "_process": -1}

    def __len__(self) -> int:
        return len(self.index)

    def __getitem__(self, item: int) -> Item:
        return self.items([item_number(item, len(self))])[0]

    def __iter__(self) -> Iterator[Item]:
        return (self[item] for item in range(len(self)))

    def table(self) -> pa.Table:
        """Facts of the items, a row each: trajectory, sensor, indenter, peak force, and the recordings' free columns as
        ``extra.NAME``, null where a recording has none; in the order of the items, ready to be used as covariates.
        """
        return item_table(self.store, self.index)

    def items(self, numbers: Sequence[int]) -> list[Item]:
        """Items, read together.

        Returns
        -------
        list of dict
            In frame mode, for each frame ``sensor``, ``indenter``, ``trajectory`` (uid), ``frame`` (row in the store),
            ``t_ns``, and each stream: pictures (H, W, 3), values (k,). In trajectory mode ``frame``, ``t_ns`` and
            ``in_split`` are (n,), pictures of a camera (n, H, W, 3), signals (m, k) with times (m,).
        """
        if self.unit == "trajectory":
            return [self._finished(item) for item in self.read_trajectories(numbers)]
        batch = self.batch(numbers)
        return [{name: value[place] for name, value in batch.items()} for place in range(len(numbers))]

    def batch(self, numbers: Sequence[int]) -> Item:
        """Frames stacked, each entry with the frames along its first axis; names are lists. Frame mode only."""
        return self._finished(self.read_frames(numbers))

    def batches(
        self, batch_size: int, *, seed: int = 0, shuffle: bool = True, drop_last: bool = False
    ) -> Iterator[Item | list[Item]]:
        """Return one epoch in batches: stacked frames, or lists of trajectories.

        Parameters
        ----------
        batch_size : int
            Items of a batch.
        seed : int
            Seed of the order.
        shuffle : bool
            Whether items come in an order of chance; otherwise in that of the store.
        drop_last : bool
            Whether a last batch with fewer items is left out.
        """
        order = Order(len(self), seed=seed, shuffle=shuffle, batch_size=batch_size, drop_last=drop_last)
        read = self.batch if self.unit == "frame" else self.items
        return (read(numbers) for numbers in order)

    def _finished(self, item: Item) -> Item:
        if self.image_dtype == "uint8":
            return item
        pictures = [stream.name for stream in self.streams if stream.is_picture]
        return {**item, **{name: self._as_float(name, item[name]) for name in pictures}}

    def _as_float(self, name: str, pictures: NDArray[np.uint8]) -> NDArray[np.float32]:
        fractions = np.empty(pictures.shape, np.float32)
        fill_fractions(pictures, fractions)
        return self.normalisers[name].apply(fractions) if name in self.normalisers else fractions

    def read_frames(self, numbers: Sequence[int]) -> Item:
        """Read frames like `batch`, with pictures as stored: uint8, neither scaled nor normalised."""
        if self.unit != "frame":
            raise UsageError("frames of a dataset of trajectories", "unit='frame'", "Use `items` for trajectories.")
        _require_some(numbers)
        places = np.asarray(numbers, np.int64)
        rows, facts = self.index.rows[places], self._facts(places)
        for stream in self.streams:
            facts[stream.name] = self._at_frames(stream, rows, facts["sensor"])
        return facts

    def _facts(self, places: NDArray[np.int64]) -> Item:
        index = self.index
        trajectory = index.trajectory[places]
        return {
            "sensor": index.sensors(places),
            "indenter": index.indenters[trajectory].tolist(),
            "trajectory": index.uids[trajectory].tolist(),
            "frame": index.rows[places],
            "t_ns": index.t_ns[places],
        }

    def read_trajectories(self, numbers: Sequence[int]) -> list[Item]:
        """Read trajectories like `items`, with pictures as stored: uint8, neither scaled nor normalised."""
        if self.unit != "trajectory":
            raise UsageError("trajectories of a dataset of frames", "unit='trajectory'", "Use `batch` for frames.")
        _require_some(numbers)
        index = self.index
        places = index.places(np.asarray(numbers, np.int64))
        ends = np.cumsum([index.starts[number + 1] - index.starts[number] for number in numbers])
        facts = self._facts(places)
        whole = {
            **{name: facts[name] for name in ("frame", "t_ns")},
            "in_split": index.in_split[places],
            **{
                stream.name: self._at_frames(stream, facts["frame"], facts["sensor"])
                for stream in self.streams
                if stream.kind in ("image", "frame_value") or stream.is_of_mesh
            },
        }
        items: list[Item] = []
        for start, stop in zip([0, *ends[:-1]], ends, strict=True):
            names = {name: facts[name][start] for name in ("sensor", "indenter", "trajectory")}
            item = {**names, **{name: value[start:stop] for name, value in whole.items()}}
            self._add_native(item, int(index.trajectory[places[start]]))
            items.append(item)
        return items

    def _add_native(self, item: Item, trajectory: int) -> None:
        for stream in self.streams:
            if stream.kind == "background":
                item[stream.name] = self._reference(item["sensor"])
            elif stream.kind == "signal":
                start, stop = self.index.segment(trajectory, stream.name)
                signal = self.store.signal(stream.name)
                item[stream.name] = self._scaled(stream.name, signal.values(start, stop))
                item[stream.name + TIMES] = signal.t_ns(start, stop).copy()  # the store's own is read-only

    def _at_frames(self, stream: Stream, rows: NDArray[np.int64], sensors: Sequence[str]) -> NDArray[Any]:
        if stream.kind == "image":
            return self._pictures.of_frames(self.store, rows, self.threads)
        if stream.kind == "background":
            return np.stack([self._reference(sensor) for sensor in sensors])
        if stream.kind in ("mesh", "contact_mask"):
            return nodes_at_frames(self.store, stream, rows)
        return self._scaled(stream.name, values_at_frames(self.store, stream, rows))

    def _scaled(self, name: str, values: NDArray[np.float64]) -> NDArray[np.float32]:
        return (
            self.normalisers[name].apply(values) if name in self.normalisers else values.astype(np.float32)
        )  # a copy: the store's values are read-only

    def _reference(self, sensor: str) -> NDArray[np.uint8]:
        store = self.store
        if not self._references:
            self._references = self._pictures.of_sensors(store)
        return self._references[sensor]

    def _require_items(self, remedy: str) -> None:
        if not len(self.index):
            raise UsageError(
                f"{self.report} of the store {self.location}",
                "at least one frame",
                remedy,
                report=self.report.document(),
            )

    def _find_normalisers(
        self, selection: Selection, normalise: bool | Sequence[str]
    ) -> tuple[dict[str, Normaliser], tuple[str, ...]]:
        by_name = {stream.name: stream for stream in self.streams}
        if isinstance(normalise, bool):
            names = [
                name for name, stream in by_name.items() if normalise and not stream.is_picture and stream.is_scalable
            ]
        else:
            names = [normalise] if isinstance(normalise, str) else list(normalise)
        for name in names:
            if name not in by_name:
                raise UnknownName("stream to normalise", name, by_name)
            if not by_name[name].is_scalable:
                raise UsageError(
                    f"normalise names {name!r}", "streams of columns", "Scale the nodes of a mesh yourself."
                )
            if by_name[name].is_picture and self.image_dtype == "uint8":
                raise UsageError(f"normalise names {name!r} with image_dtype='uint8'", "float32 for scaled pictures")
        if not names:
            return {}, ()
        if selection.split is None:
            raise UsageError(
                "normalise with split='all'",
                "a split, whose train part mean and spread are taken from",
                "Name a split.",
            )
        return normalisers(self.store, selection.split, [by_name[name] for name in names], self._pictures.size)


def _require_some(numbers: Sequence[int]) -> None:
    if not len(numbers):
        raise UsageError("a batch of no items", "at least one item number")

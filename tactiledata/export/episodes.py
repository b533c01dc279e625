"""Which trajectories of a store go out, in which part, with which frames and values; read batch by batch."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.errors import StoreError
from tactiledata.export.meanings import stream_facts
from tactiledata.export.pictures import encoded_picture
from tactiledata.loaders.index import FrameIndex
from tactiledata.loaders.streams import Stream, values_at_frames
from tactiledata.store.read.flags import Flag, flagged_trajectories
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import trajectory_kinds

BATCH_FRAMES = 64
BATCH_BYTES = 32 * 2**20
"""Bytes of pictures that a batch holds at most, unless a single one is larger."""


@dataclass(frozen=True)
class FrameBatch:
    """Neighbouring frames of one episode.

    Parameters
    ----------
    episode : int
    part : str
        Of the split, as the episode's.
    first : int
        Place of the first frame in the episode.
    rows, t_ns : (n,) int64
        Rows in the store, and the host clock in ns.
    in_split : (n,) bool
        Whether the split's contact filter takes the frame.
    pictures : list of (bytes, kind, unchanged)
        Encoded pictures, ``jpeg`` or ``png``, and whether they are the store's bytes.
    values : dict of (n, k) float64
        By stream; NaN where nothing was recorded. The action is called ``action``.
    """

    episode: int
    part: str
    first: int
    rows: NDArray[np.int64]
    t_ns: NDArray[np.int64]
    in_split: NDArray[np.bool_]
    pictures: Sequence[tuple[bytes, str, bool]]
    values: Mapping[str, NDArray[np.float64]]

    def __len__(self) -> int:
        return len(self.rows)


@dataclass(frozen=True)
class EpisodeFacts:
    """Who touched what, a value for each episode.

    Parameters
    ----------
    uids, names, sensors, indenters : lists of str
    kinds : list of "simulated", "real" or "not stated"
    """

    uids: list[str]
    names: list[str]
    sensors: list[str]
    indenters: list[str]
    kinds: list[str]


@dataclass(frozen=True)
class Episodes:
    """Trajectories that are exported, those of one part side by side, each with its readable frames.

    Parameters
    ----------
    store : Store
    camera : str
        Empty where the store has no camera, and so no frames.
    streams : tuple of Stream
        With a row of numbers a frame.
    action : Stream, optional
        Its value at the next frame is the action.
    index : FrameIndex
        An item is an episode.
    parts : tuple of str
        The part of each episode.
    left_out : dict
        Reason -> number of frames that do not go out.
    """

    store: Store
    camera: str
    streams: tuple[Stream, ...]
    action: Stream | None
    index: FrameIndex
    parts: tuple[str, ...]
    left_out: Mapping[str, int] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.index)

    @property
    def trajectories(self) -> NDArray[np.int64]:
        """Rows (n,) of the episodes in the store's table of trajectories."""
        return self.index.trajectory[self.index.starts[:-1]].astype(np.int64)

    @property
    def lengths(self) -> NDArray[np.int64]:
        """Number of frames (n,) of each episode."""
        return np.diff(self.index.starts)

    def part_ranges(self) -> dict[str, tuple[int, int]]:
        """Return the range of episodes [start, stop) of each part that has any, in order."""
        ranges: dict[str, tuple[int, int]] = {}
        for number, part in enumerate(self.parts):
            ranges[part] = (ranges.get(part, (number, 0))[0], number + 1)
        return ranges

    @cached_property
    def facts(self) -> EpisodeFacts:
        """Who touched what in each episode."""
        table = self.store.trajectories(["uid", "trajectory", "sensor", "indenter"]).take(self.trajectories)
        kinds = trajectory_kinds(self.store)
        columns = (table[name].to_pylist() for name in table.column_names)
        uids, names, sensors, indenters = ([value or "" for value in column] for column in columns)
        return EpisodeFacts(uids, names, sensors, indenters, [kinds[row] for row in self.trajectories.tolist()])

    @cached_property
    def flags(self) -> dict[str, Flag]:
        """Flags of the episodes' trajectories, by uid."""
        uids = set(self.facts.uids)
        return {uid: flag for uid, flag in flagged_trajectories(self.store).items() if uid in uids}

    @cached_property
    def stream_facts(self) -> dict[str, dict[str, Any]]:
        """Columns, units, frame and meaning of each stream, as JSON values."""
        return {stream.name: stream_facts(self.store, stream) for stream in self.streams}

    @cached_property
    def picture_sizes(self) -> NDArray[np.int64]:
        """Height and width (n_frames, 2) of the frames."""
        frames = self.store.frames(["height", "width"]).take(self.index.rows)
        return np.stack([frames[name].to_numpy().astype(np.int64) for name in ("height", "width")], axis=1)

    @cached_property
    def is_raw(self) -> NDArray[np.bool_]:
        """Whether each frame (n_frames,) is kept as pixels, not as a JPEG or PNG file."""
        encodings = self.store.frames(["encoding"]).take(self.index.rows)["encoding"].cast(pa.string())
        return np.asarray(pc.equal(encodings, "raw").combine_chunks().to_numpy(zero_copy_only=False), bool)

    @cached_property
    def frame_bytes(self) -> NDArray[np.int64]:
        """Size (n_frames,) in bytes of the frames' pictures, as the store keeps them; of raw ones unpacked."""
        lengths = self.store.frames(["length"]).take(self.index.rows)["length"].to_numpy()
        return np.where(lengths > 0, lengths, self.picture_sizes.prod(axis=1) * 3).astype(np.int64)

    def groups(self, largest: int) -> list[tuple[int, int]]:
        """Return ranges of episodes [start, stop), none over two parts, whose pictures have about ``largest`` bytes."""
        sizes = np.add.reduceat(self.frame_bytes, self.index.starts[:-1]) if len(self) else np.empty(0, np.int64)
        ranges = []
        for start, stop in self.part_ranges().values():
            first, held = start, 0
            for number in range(start, stop):
                if number > first and held + sizes[number] > largest:
                    ranges.append((first, number))
                    first, held = number, 0
                held += int(sizes[number])
            ranges.append((first, stop))
        return ranges

    def batches(self, start: int, stop: int) -> Iterator[FrameBatch]:
        """Yield the frames of the episodes [start, stop) in order, a bounded number at a time."""
        for episode in range(start, stop):
            first, end = int(self.index.starts[episode]), int(self.index.starts[episode + 1])
            place = first
            while place < end:
                reach = np.cumsum(self.frame_bytes[place : min(place + BATCH_FRAMES, end)])
                count = max(1, int(np.searchsorted(reach, BATCH_BYTES, side="right")))
                yield self._batch(episode, first, place, min(place + count, end), end)
                place += count

    def _batch(self, episode: int, first: int, start: int, stop: int, end: int) -> FrameBatch:
        rows = self.index.rows[start:stop]
        values = {stream.name: values_at_frames(self.store, stream, rows) for stream in self.streams}
        if self.action is not None:
            following = np.minimum(np.arange(start, stop) + 1, end - 1)
            values["action"] = values_at_frames(self.store, self.action, self.index.rows[following])
        return FrameBatch(
            episode,
            self.parts[episode],
            start - first,
            rows,
            self.index.t_ns[start:stop],
            self.index.in_split[start:stop],
            self._pictures(start, stop),
            values,
        )

    def _pictures(self, start: int, stop: int) -> list[tuple[bytes, str, bool]]:
        """Return the encoded pictures of frames, by their places, each held against its checksum."""
        rows = self.index.rows[start:stop]
        sizes = self.picture_sizes[start:stop].tolist()
        pictures = []
        for row, is_raw, (height, width), payload in zip(
            rows.tolist(), self.is_raw[start:stop].tolist(), sizes, self.store.encoded(rows), strict=True
        ):
            if payload is None:
                raise StoreError(f"frame {row} of {self.store.location} has no image", "a frame with an image")
            pictures.append(encoded_picture(payload, is_raw, height, width))
        return pictures

"""Items of a dataset and the facts of their frames, in plain arrays that travel to worker processes."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactiledata.loaders.selection import Selection
from tactiledata.loaders.streams import Unit

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store


@dataclass(frozen=True)
class FrameIndex:
    """Frames and how they group into items.

    Parameters
    ----------
    rows : (n_frames,) int64
        Rows over all frames of the store; the frames of an item are neighbours.
    t_ns : (n_frames,) int64
        Host clock.
    trajectory : (n_frames,) int32
        Rows in the store's table of trajectories, -1 outside any.
    in_split : (n_frames,) bool
    starts : (n_items + 1,) int64
        Item i has the frames ``starts[i]`` to ``starts[i + 1]``, without the last.
    sensor_code : (n_frames,) int32
        Place of each frame's sensor in ``sensor_names``.
    sensor_names : tuple of str
    uids, indenters : (n_trajectories + 1,) object of str
        Of the store's trajectories; the last entry is empty, for frames outside any.
    signal_rows : (n_trajectories + 1,) object of str
        JSON as in the table; empty in frame mode.
    """

    rows: NDArray[np.int64]
    t_ns: NDArray[np.int64]
    trajectory: NDArray[np.int32]
    in_split: NDArray[np.bool_]
    starts: NDArray[np.int64]
    sensor_code: NDArray[np.int32]
    sensor_names: tuple[str, ...]
    uids: NDArray[np.object_]
    indenters: NDArray[np.object_]
    signal_rows: NDArray[np.object_]

    def __len__(self) -> int:
        return len(self.starts) - 1

    def places(self, items: NDArray[np.int64]) -> NDArray[np.int64]:
        """Places in ``rows`` of all frames of some items, item after item."""
        return np.concatenate(
            [np.arange(self.starts[item], self.starts[item + 1]) for item in items] or [np.empty(0, int)]
        )

    def only(self, items: NDArray[np.bool_]) -> FrameIndex:
        """The index of some items, by a mask (n_items,)."""
        lengths = np.diff(self.starts)
        places = np.repeat(items, lengths)
        return replace(
            self,
            rows=self.rows[places],
            t_ns=self.t_ns[places],
            trajectory=self.trajectory[places],
            in_split=self.in_split[places],
            sensor_code=self.sensor_code[places],
            starts=np.concatenate([[0], np.cumsum(lengths[items])]),
        )

    def sensors(self, places: NDArray[np.int64]) -> list[str]:
        """Sensors of some frames."""
        return [self.sensor_names[code] for code in self.sensor_code[places].tolist()]

    def segment(self, trajectory: int, signal: str) -> tuple[int, int]:
        """Rows [start, stop) of a signal in a trajectory; (0, 0) where it has none."""
        start, stop = json.loads(self.signal_rows[trajectory] or "{}").get(signal, (0, 0))
        return int(start), int(stop)


def build_index(store: Store, selection: Selection, unit: Unit) -> FrameIndex:
    """Return the index of selected frames: an item for each frame, or for each trajectory.

    Parameters
    ----------
    store : Store
        Where the frames are.
    selection : Selection
        The frames of the dataset.
    unit : "frame" or "trajectory"
        What an item is; frames outside any trajectory are in no item of trajectories.
    """
    frames = store.frames(["trajectory", "sensor", "t_ns"]).take(selection.rows)
    trajectories = store.trajectories(["uid", "indenter", "signal_rows"])
    trajectory = frames["trajectory"].to_numpy()
    sensors = frames["sensor"].cast(pa.string()).combine_chunks().dictionary_encode()  # only those that occur
    rows, in_split = selection.rows, selection.in_split
    starts = np.arange(len(rows) + 1, dtype=np.int64)
    order: Any = slice(None)
    if unit == "trajectory":
        order = np.flatnonzero(trajectory >= 0)
        order = order[np.argsort(trajectory[order], kind="stable")]
        changes = np.flatnonzero(np.diff(trajectory[order])) + 1
        starts = np.concatenate([[0], changes, [len(order)]]) if len(order) else np.zeros(1, np.int64)
    texts = {name: _texts(trajectories[name]) for name in ("uid", "indenter", "signal_rows")}
    return FrameIndex(
        rows[order],
        frames["t_ns"].to_numpy()[order],
        trajectory[order],
        in_split[order],
        starts,
        np.asarray(sensors.indices)[order],
        tuple(sensors.dictionary.to_pylist()),
        texts["uid"],
        texts["indenter"],
        texts["signal_rows"] if unit == "trajectory" else np.empty(0, object),
    )


def _texts(column: Any) -> NDArray[np.object_]:
    return np.array([*column.to_pylist(), ""], object)

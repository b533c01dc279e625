"""Frames of one unit over several parts of a split, and pairs of frames of two units that show the same touch."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from split_models.learning.data import TouchFrames
from tactiledata.arrays import PictureArray
from tactiledata.errors import UnknownName

Numbers = NDArray[np.int64]


class UnitFrames:
    """Frames of one unit, numbered from 0.

    Parameters
    ----------
    parts : sequence of TouchFrames
        Parts of the split of one store.
    sensor : str
        The unit.

    Attributes
    ----------
    touches : (n,) object of str
        Name of the touch that each frame shows. Where recordings name touches, a touch has the same name on two units.
    moments : (n, 2) int64
        Number of frames of the touch's recording, and the place of the frame among them.

    Raises
    ------
    UnknownName
        No part has a frame of the sensor.
    """

    def __init__(self, parts: Sequence[TouchFrames], sensor: str) -> None:
        self.sensor = sensor
        self._parts = list(parts)
        mine = [np.flatnonzero(frames.sensors == sensor) for frames in parts]
        self._which = np.repeat(np.arange(len(parts)), [len(numbers) for numbers in mine])
        self._inside = np.concatenate(mine)
        if not len(self._inside):
            known = sorted({name for frames in parts for name in frames.sensor_names})
            raise UnknownName(f"sensor with frames in {', '.join(frames.part for frames in parts)}", sensor, known)
        facts = [_touches(frames, numbers) for frames, numbers in zip(parts, mine, strict=True)]
        self.touches = np.concatenate([touches for touches, _ in facts])
        self.moments = np.concatenate([moments for _, moments in facts])

    def __len__(self) -> int:
        return len(self._inside)

    @property
    def background(self) -> PictureArray:
        """Picture (h, w, 3), uint8, of the unit without contact."""
        return self._parts[0].background(self.sensor)

    def pictures(self, numbers: Numbers) -> PictureArray:
        """Pictures (n, h, w, 3), uint8, of frames by their number."""
        pictures = np.empty((len(numbers), *self.background.shape), np.uint8)
        for part, frames in enumerate(self._parts):
            here = np.flatnonzero(self._which[numbers] == part)
            if len(here):
                pictures[here] = frames.pictures(self._inside[numbers[here]])
        return pictures


def spread_evenly(count: int, most: int) -> Numbers:
    """Evenly spaced numbers below ``count``, at most ``most``, with the first and the last."""
    return np.unique(np.linspace(0, count - 1, most).astype(np.int64)) if count else np.empty(0, np.int64)


def paired_frames(first: UnitFrames, second: UnitFrames, most: int) -> tuple[Numbers, Numbers]:
    """Numbers of frames of two units that show the same moment of the same touch, evenly spaced.

    Frames of a touch whose two recordings differ in length are left out.

    Parameters
    ----------
    first, second : UnitFrames
    most : int
        Largest number of pairs.

    Returns
    -------
    (p,) int, (p,) int
        Numbers in ``first``, and in ``second``.
    """
    places = {key: number for number, key in enumerate(_moment_keys(second))}
    both = [(number, places[key]) for number, key in enumerate(_moment_keys(first)) if key in places]
    pairs = np.array(both, np.int64).reshape(-1, 2)
    chosen = pairs[spread_evenly(len(pairs), most)]
    return chosen[:, 0], chosen[:, 1]


def _moment_keys(frames: UnitFrames) -> list[tuple[str, int, int]]:
    """Touch, length of its recording and place in it, for each frame."""
    return [(touch, *moment) for touch, moment in zip(frames.touches, frames.moments.tolist(), strict=True)]


def _touches(frames: TouchFrames, numbers: Numbers) -> tuple[NDArray[np.object_], Numbers]:
    """Touch names (n,) of frames; lengths of their recordings and places of the frames in them (n, 2)."""
    table = frames.arrays.store.trajectories(["uid", "extra", "frame_start", "frame_stop"])
    names = [
        str(json.loads(extra or "{}").get("touch", uid))
        for uid, extra in zip(table["uid"].to_pylist(), table["extra"].to_pylist(), strict=True)
    ]
    start, stop = (np.asarray(table[name], np.int64) for name in ("frame_start", "frame_stop"))
    owner = frames.arrays.index.trajectory[numbers]
    places = np.stack([(stop - start)[owner], frames.rows[numbers] - start[owner]], axis=1)
    return np.array(names, object)[owner], places

"""Frames of one unit over several parts of a split, and which frames of two units show the same touch."""

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
        Of one store.
    sensor : str

    Attributes
    ----------
    touches : (n,) object of str
        The touch that each frame is of. Where the recordings name touches, the same touch on two units has one name.
    moments : (n, 2) int64
        How many frames the touch's recording has, and the place of this one among them.

    Raises
    ------
    UnknownName
        No part has a frame of that sensor.
    """

    def __init__(self, parts: Sequence[TouchFrames], sensor: str) -> None:
        self.sensor = sensor
        self._parts = list(parts)
        mine = [np.flatnonzero(frames.sensors == sensor) for frames in parts]
        self._which = np.repeat(np.arange(len(parts)), [len(one) for one in mine])
        self._inside = np.concatenate(mine)
        if not len(self._inside):
            known = sorted({name for frames in parts for name in frames.sensor_names})
            raise UnknownName(f"sensor with frames in {', '.join(frames.part for frames in parts)}", sensor, known)
        facts = [_touches(frames, numbers) for frames, numbers in zip(parts, mine, strict=True)]
        self.touches = np.concatenate([one for one, _ in facts])
        self.moments = np.concatenate([one for _, one in facts])

    def __len__(self) -> int:
        return len(self._inside)

    @property
    def background(self) -> PictureArray:
        """The unit's picture (h, w, 3) without contact."""
        return self._parts[0].background(self.sensor)

    def pictures(self, numbers: Numbers) -> PictureArray:
        """Pictures (n, h, w, 3), uint8."""
        found = np.empty((len(numbers), *self.background.shape), np.uint8)
        for part, frames in enumerate(self._parts):
            here = np.flatnonzero(self._which[numbers] == part)
            if len(here):
                found[here] = frames.pictures(self._inside[numbers[here]])
        return found


def spread_evenly(count: int, most: int) -> Numbers:
    """At most so many numbers below a count, evenly spaced, the first and the last among them."""
    return np.unique(np.linspace(0, count - 1, most).astype(np.int64)) if count else np.empty(0, np.int64)


def paired_frames(one: UnitFrames, other: UnitFrames, most: int) -> tuple[Numbers, Numbers]:
    """Numbers of frames of two units that show the same moment of the same touch, at most so many, evenly spaced.

    Of a touch whose two recordings differ in length no frame is taken.
    """
    places = {key: number for number, key in enumerate(_moment_keys(other))}
    both = [(number, places[key]) for number, key in enumerate(_moment_keys(one)) if key in places]
    pairs = np.array(both, np.int64).reshape(-1, 2)
    chosen = pairs[spread_evenly(len(pairs), most)]
    return chosen[:, 0], chosen[:, 1]


def _moment_keys(frames: UnitFrames) -> list[tuple[str, int, int]]:
    return [(touch, *moment) for touch, moment in zip(frames.touches, frames.moments.tolist(), strict=True)]


def _touches(frames: TouchFrames, numbers: Numbers) -> tuple[NDArray[np.object_], Numbers]:
    """Names (n,) of the touches of some frames; their recordings' lengths and the frames' places in them (n, 2)."""
    table = frames.arrays.store.trajectories(["uid", "extra", "frame_start", "frame_stop"])
    names = [
        str(json.loads(extra or "{}").get("touch", uid))
        for uid, extra in zip(table["uid"].to_pylist(), table["extra"].to_pylist(), strict=True)
    ]
    start, stop = (np.asarray(table[name], np.int64) for name in ("frame_start", "frame_stop"))
    owner = frames.arrays.index.trajectory[numbers]
    places = np.stack([(stop - start)[owner], frames.rows[numbers] - start[owner]], axis=1)
    return np.array(names, object)[owner], places

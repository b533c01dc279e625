"""How much of recorded touches is kept in pictures that were made of them: strength, correlation and mask overlap."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import PictureArray
from tactiledata.contract.records import Finding
from tactiledata.contract.wording import counted
from tactiledata.metrics.bootstrap import bootstrap
from tactiledata.metrics.kept_touch import KEPT_TOUCH, change_of
from tactiledata.scoring.sensor_pairs import PairScore
from tactiledata.scoring.sensor_sets import SensorSet, background_of, load_pictures
from tactiledata.store.read.reader import Store

LEAST_KEPT = 0.8
"""Least strength, correlation and mask overlap of a touch that counts as kept."""
TOUCH = "the touch"
"""What the scores of kept touches look at, in tables."""


@dataclass(frozen=True)
class KeptTouch:
    """How much of the touches of one sensor is kept, as medians over frames.

    Parameters
    ----------
    sensor : str
        Sensor that recorded the touches.
    frames : int
        Number of frames that were compared and show a touch.
    strength : float
        Magnitude of what the touch changes, over that of the recorded change; 1 is best. NaN where no frame shows a
        touch, as the other two.
    correlation : float
        Correlation of the magnitudes of both changes.
    overlap : float
        Intersection over union of where both changes show the touch.
    """

    sensor: str
    frames: int
    strength: float
    correlation: float
    overlap: float

    @property
    def least(self) -> float:
        """The lowest of the three; NaN where no frame shows a touch."""
        return float(np.min([self.strength, self.correlation, self.overlap]))

    @property
    def is_kept(self) -> bool:
        """Whether all three are at least `LEAST_KEPT`; not where no frame shows a touch."""
        return self.least >= LEAST_KEPT

    def sentence(self, what: str) -> str:
        """The figures in a line; ``what`` says what was compared."""
        if not self.frames:
            return f"{what}, {self.sensor}: no frame that shows a touch"
        return (
            f"{what}, {self.sensor}: strength {self.strength:.2f}, correlation {self.correlation:.2f}, mask overlap "
            f"{self.overlap:.2f} (medians of {counted(self.frames, 'frame')})"
        )

    def document(self) -> dict[str, Any]:
        """The figures as values for JSON; None where there are none."""
        return {name: None if value != value else value for name, value in vars(self).items()}


def kept_touch(
    sensor: str,
    pictures: PictureArray,
    background: PictureArray,
    recorded: PictureArray,
    recorded_background: PictureArray,
) -> KeptTouch:
    """How much of recorded touches pictures show that were made of them.

    Parameters
    ----------
    sensor : str
        Sensor that recorded the touches.
    pictures, recorded : (n, H, W, 3) uint8
        Pictures that were made, and those that they were made of, in the same order and of one size.
    background, recorded_background : (H, W, 3) uint8
        The sensors of both without contact.
    """
    ours, theirs = change_of(pictures, background), change_of(recorded, recorded_background)
    values = np.stack([score(ours, theirs) for score in KEPT_TOUCH.scores.values()])
    shown = values[:, np.isfinite(values).all(axis=0)]
    if not shown.shape[1]:
        return KeptTouch(sensor, 0, np.nan, np.nan, np.nan)
    return KeptTouch(sensor, shown.shape[1], *(float(value) for value in np.median(shown, axis=1)))


def touch_findings(kept: Sequence[KeptTouch], method: str, target: str) -> Iterator[Finding]:
    """Yield a warning for each sensor whose touches a method does not keep.

    Parameters
    ----------
    kept : list of KeptTouch
        What the method keeps, sensor by sensor.
    method : str
        Name of the method.
    target : str
        Sensor that touches are transferred to.
    """
    for facts in kept:
        if facts.frames and not facts.is_kept:
            text = (
                f"{method} does not keep the touches of {facts.sensor}: the lowest of strength, correlation and mask "
                f"overlap is {facts.least:.2f}, and {LEAST_KEPT:g} is needed. {_better(method)}"
            )
            yield Finding("touch-not-kept", "warning", text, stream=target)


def _better(method: str) -> str:
    """Say what to do where a method does not keep the touches; none changes them less than relit."""
    if method != "relit":
        return "`--method relit` keeps them"
    return "No other method changes a touch less: compare the pictures before and after, and train on none that is lost"


def kept_scores(store: Store, sets: Sequence[SensorSet]) -> tuple[list[PairScore], list[str]]:
    """Return what synthetic sets keep of the touches that they were made of, and sentences on those without figures.

    Parameters
    ----------
    store : Store
        The store of the sets; parents are looked for in it.
    sets : list of SensorSet
        Sets; recorded ones are passed over.
    """
    scores, notes = [], []
    for made in (one for one in sets if one.is_derived):
        ours, theirs = _parents(store, made)
        parent = _sensor_of(store, made)
        backgrounds = background_of(store, made), _background(store, parent)
        if not len(ours):
            notes.append(f"{made.name}: how much of its touches is kept is not known, as their parents are not here.")
            continue
        pictures = load_pictures(store, SensorSet(made.name, made.sensor, True, made.is_simulated, ours, ours))
        recorded = load_pictures(store, SensorSet(parent, parent, False, made.is_simulated, theirs, theirs))
        shapes = {pictures.shape[1:], recorded.shape[1:], *(one.shape for one in backgrounds if one is not None)}
        if any(one is None for one in backgrounds) or len(shapes) > 1:
            notes.append(
                f"{made.name}: how much of its touches is kept is not known; that takes pictures without contact of "
                f"{made.sensor} and {parent}, and pictures of one size."
            )
            continue
        first, second = backgrounds
        assert first is not None
        assert second is not None
        changes = change_of(pictures, first), change_of(recorded, second)
        owners = np.asarray(store.frames(["trajectory"])["trajectory"])[ours]
        kind = "simulated recording" if made.is_simulated else "recorded"
        for score in KEPT_TOUCH.scores.values():
            values = score(*changes)
            if np.isnan(values).all():
                notes.append(f"{made.name}: none of the recorded frames that it was made of shows a touch.")
                break
            interval = bootstrap(values, owners)
            scores.append(PairScore("kept_touch", score, made.name, parent, made.kind, kind, TOUCH, interval))
    return scores, notes


def _parents(store: Store, made: SensorSet) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows of a set's frames, and rows of the frames that they were made of, by parent trajectory and time."""
    table = store.trajectories(["uid", "parent", "frame_start", "frame_stop"]).to_pylist()
    place = {row["uid"]: number for number, row in enumerate(table)}
    times = np.asarray(store.frames(["t_ns"])["t_ns"])
    ours, theirs = [], []
    for row, owner in zip(made.rows.tolist(), made.trajectories.tolist(), strict=True):
        parent = place.get(table[owner]["parent"])
        if parent is None:
            continue
        start, stop = table[parent]["frame_start"], table[parent]["frame_stop"]
        same = start + np.flatnonzero(times[start:stop] == times[row])
        if len(same) == 1:
            ours.append(row)
            theirs.append(int(same[0]))
    return np.array(ours, np.int64), np.array(theirs, np.int64)


def _sensor_of(store: Store, made: SensorSet) -> str:
    """Name of the sensor that recorded the touches of a synthetic set."""
    extra = store.trajectories(["extra"])["extra"][int(made.trajectories[0])].as_py()
    return str(json.loads(extra).get("parent_sensor", ""))


def _background(store: Store, sensor: str) -> PictureArray | None:
    """Picture of a sensor without contact, or None where the store has none."""
    return store.reference(sensor).image if sensor in store.manifest["references"] else None

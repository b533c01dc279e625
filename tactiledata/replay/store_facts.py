"""Inputs of effects from a store, apart from pose and wrench: gravity, joints, power-on, mountings, earlier touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.effects.touch.imprint import ImprintTable, strongest_imprint
from tactiledata.replay.opened import OpenedStore
from tactiledata.replay.plan import GAP_LIMIT_NS, PlannedTouch
from tactiledata.transforms import pose_matrices

GRAVITY = np.array([0.0, 0.0, -9.81])
"""Acceleration of gravity, m/s^2, in the base frame of an arm that stands upright."""
SPOT = 2e-3
"""Largest distance, m, between the deepest points of touches on the same spot."""


@dataclass(frozen=True)
class Visit:
    """Time, place and imprint of one touch of a gel, at its deepest frame.

    Parameters
    ----------
    t_ns : int
        Time of the touch's first frame.
    place : (2,) m
        Deepest point in the gel frame.
    imprint : m^4
        Strength of the imprint: see `tactiledata.effects.touch.imprint`.
    """

    t_ns: int
    place: Array
    imprint: float


class StoreFacts:
    """Inputs of effects for a store's trajectories, at rows of its table of frames.

    Parameters
    ----------
    opened : OpenedStore
        Its times, streams and descriptions are read. All its trajectories count, because earlier touches of a gel do.
    """

    def __init__(self, opened: OpenedStore) -> None:
        self._opened, self._store = opened, opened.store
        self._tables: dict[str, ImprintTable] = {}
        self._t_ns = opened.frame_t_ns
        self._touches = opened.plan.touches
        self._mounts = _mounts(self._touches, {uid: row["source"] for uid, row in opened.by_uid.items()})

    def seconds(self, rows: Indices) -> Array:
        """Time (n,), s, of rows since the first of them."""
        return np.asarray((self._t_ns[rows] - self._t_ns[rows[0]]) / 1e9)

    def gravity(self, planned: PlannedTouch, rows: Indices) -> Array | None:
        """Acceleration of gravity (n, 3), m/s^2, in the gel frame; ``None`` where a pose is missing."""
        poses = self._values(planned.poses, rows)
        if poses is None or planned.tcp_from_gel is None:
            return None
        base_from_gel = pose_matrices(poses) @ planned.tcp_from_gel
        return np.asarray(np.einsum("nij,i->nj", base_from_gel[:, :3, :3], GRAVITY))

    def joints(self, rows: Indices) -> Array | None:
        """Joint angles (n, 6), rad; ``None`` where any is missing."""
        for name in self._store.aligned_names:
            if name.partition("@")[0] == "joints" and self._store.meaning("aligned", name).units[0] == "rad":
                values = self._values(name, rows)
                if values is not None:
                    return np.asarray(values[:, :6])
        return None

    def powered(self, planned: PlannedTouch, rows: Indices) -> Array | None:
        """Time (n,), s, since the sensor was last switched on; ``None`` where the recording does not state it."""
        description = self._opened.description_of(planned.uid)
        switched_on = description.switched_on(planned.sensor, int(self._t_ns[rows[0]]))
        return None if switched_on is None else np.asarray((self._t_ns[rows] - switched_on) / 1e9)

    def mount(self, planned: PlannedTouch) -> str:
        """Name of the mounting of a trajectory's indenter."""
        return self._mounts[planned.uid]

    def earlier(self, planned: PlannedTouch, places: Array, rows: Indices) -> tuple[Array, Array]:
        """Return earlier load and number of earlier touches at places of this gel.

        The load (n,), m, is the depth at which this indenter would leave the strongest earlier imprint at each place.
        The number (n,) counts earlier touches within ``SPOT``. Touches before the store began are unknown and ignored.

        Parameters
        ----------
        planned : PlannedTouch
            The present trajectory.
        places : (n, 2) m
            Places in the gel frame.
        rows : (n,) int
            Rows of its frames; the first one sets the time.
        """
        before = [visit for visit in self._visits.get(planned.sensor, []) if visit.t_ns < self._t_ns[rows[0]]]
        if not before:
            return np.zeros(len(places)), np.zeros(len(places))
        pressed = np.array([visit.place for visit in before])
        strongest = strongest_imprint(places, pressed, np.array([visit.imprint for visit in before]))
        distances = np.linalg.norm(places[:, None] - pressed, axis=2)
        return self._table(planned).depth(strongest), (distances < SPOT).sum(axis=1).astype(float)

    def _table(self, planned: PlannedTouch) -> ImprintTable:
        """Table of depth against imprint of a trajectory's indenter."""
        assert planned.solid is not None
        if planned.indenter not in self._tables:
            self._tables[planned.indenter] = ImprintTable.of(planned.solid)
        return self._tables[planned.indenter]

    def _values(self, name: str, rows: Indices) -> Array | None:
        """Values of an aligned stream at rows, or ``None`` where any is missing or across a long gap."""
        values, gap_ns = self._store.aligned(name, rows)
        is_known = np.isfinite(values).all(axis=1) & (gap_ns <= GAP_LIMIT_NS)
        return values if is_known.all() else None

    @cached_property
    def _visits(self) -> dict[str, list[Visit]]:
        """All touches of each sensor's gel, in the order of the store."""
        visits: dict[str, list[Visit]] = {}
        for planned in self._touches:
            if planned.obstacle is not None:
                continue
            tips = planned.gel_touch(self._store, 0.0).poses[:, :3, 3]
            if np.isfinite(tips[:, 2]).any():
                deepest = int(np.nanargmin(tips[:, 2]))
                moment = int(self._t_ns[planned.frames[0]])
                imprint = float(self._table(planned).imprint(-tips[deepest, 2]))
                visit = Visit(moment, tips[deepest, :2], imprint)
                visits.setdefault(planned.sensor, []).append(visit)
        return visits


def _mounts(touches: Sequence[PlannedTouch], source: dict[str, int]) -> dict[str, str]:
    """Mounting of each trajectory, by uid; another recording or another indenter in between starts a new one."""
    count, mounts = 0, {}
    for before, planned in pairwise([None, *touches]):
        assert planned is not None
        if before is None or (source[before.uid], before.indenter) != (source[planned.uid], planned.indenter):
            count += 1
        mounts[planned.uid] = f"{planned.indenter} {count}"
    return mounts

"""What a store tells of its touches beside pose and wrench: gravity, joints, time since power-on, mounts, history."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.contract.description import LogDescription
from tactiledata.effects.touch.imprint import ImprintTable, strongest_imprint
from tactiledata.replay.plan import GAP_LIMIT_NS, PlannedTouch
from tactiledata.store.read.reader import Store
from tactiledata.transforms import pose_matrices

GRAVITY = np.array([0.0, 0.0, -9.81])
"""m/s^2, base frame, of an arm that stands upright."""
SPOT = 2e-3
"""m: touches whose deepest points lie nearer than this are of one spot."""


@dataclass(frozen=True)
class Visit:
    """A touch of a gel, at its deepest frame.

    Parameters
    ----------
    t_ns : int
    place : (2,) m, gel frame
    imprint : m^4
        See `tactiledata.effects.touch.imprint`.
    """

    t_ns: int
    place: Array
    imprint: float


class StoreFacts:
    """Facts of a store's trajectories, at rows of its table of frames.

    Parameters
    ----------
    store : Store
    touches : sequence of PlannedTouch
        All of the store, drawn or not: what came before counts.
    """

    def __init__(self, store: Store, touches: Sequence[PlannedTouch]) -> None:
        self._store = store
        self._tables: dict[str, ImprintTable] = {}
        self._t_ns: Array = np.asarray(store.frames(["t_ns"])["t_ns"])
        table = store.trajectories(["uid", "source"])
        self._source = dict(zip(table["uid"].to_pylist(), table["source"].to_pylist(), strict=True))
        self._descriptions = [
            LogDescription(json.loads(text)) for text in store.sources(["description"])["description"].to_pylist()
        ]
        self._touches = touches
        self._mounts = _mounts(touches, self._source)

    def seconds(self, rows: Indices) -> Array:
        """Since the first of the rows (n,)."""
        return np.asarray((self._t_ns[rows] - self._t_ns[rows[0]]) / 1e9)

    def gravity(self, planned: PlannedTouch, rows: Indices) -> Array | None:
        """Acceleration (n, 3) in the gel frame, m/s^2."""
        poses = self._values(planned.poses, rows)
        if poses is None or planned.tcp_from_gel is None:
            return None
        base_from_gel = pose_matrices(poses) @ planned.tcp_from_gel
        return np.asarray(np.einsum("nij,i->nj", base_from_gel[:, :3, :3], GRAVITY))

    def joints(self, rows: Indices) -> Array | None:
        """Angles (n, 6), rad."""
        for name in self._store.aligned_names:
            if name.partition("@")[0] == "joints" and self._store.meaning("aligned", name).units[0] == "rad":
                values = self._values(name, rows)
                if values is not None:
                    return np.asarray(values[:, :6])
        return None

    def powered(self, planned: PlannedTouch, rows: Indices) -> Array | None:
        """Seconds (n,) since the sensor was last switched on."""
        description = self._descriptions[self._source[planned.uid]]
        switched_on = description.switched_on(planned.sensor, int(self._t_ns[rows[0]]))
        return None if switched_on is None else np.asarray((self._t_ns[rows] - switched_on) / 1e9)

    def mount(self, planned: PlannedTouch) -> str:
        """Which mounting of the indenter."""
        return self._mounts[planned.uid]

    def earlier(self, planned: PlannedTouch, places: Array, rows: Indices) -> tuple[Array, Array]:
        """What was done at places (n, 2) of this gel before this touch, as the depth (n,), m, at which this indenter
        would do as much, and the number of touches (n,) of the spot.

        What was done to a gel before this store began is not known, and counts as nothing.
        """
        before = [visit for visit in self._visits.get(planned.sensor, []) if visit.t_ns < self._t_ns[rows[0]]]
        if not before:
            return np.zeros(len(places)), np.zeros(len(places))
        pressed = np.array([one.place for one in before])
        strongest = strongest_imprint(places, pressed, np.array([one.imprint for one in before]))
        away = np.linalg.norm(places[:, None] - pressed, axis=2)
        return self._table(planned).depth(strongest), (away < SPOT).sum(axis=1).astype(float)

    def _table(self, planned: PlannedTouch) -> ImprintTable:
        """Of its indenter."""
        assert planned.solid is not None
        if planned.indenter not in self._tables:
            self._tables[planned.indenter] = ImprintTable.of(planned.solid)
        return self._tables[planned.indenter]

    def _values(self, name: str, rows: Indices) -> Array | None:
        values, gap_ns = self._store.aligned(name, rows)
        known = np.isfinite(values).all(axis=1) & (gap_ns <= GAP_LIMIT_NS)
        return values if known.all() else None

    @cached_property
    def _visits(self) -> dict[str, list[Visit]]:
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
    """Of each trajectory: another recording or another indenter in between is another mounting."""
    count, mounts = 0, {}
    for before, planned in pairwise([None, *touches]):
        assert planned is not None
        if before is None or (source[before.uid], before.indenter) != (source[planned.uid], planned.indenter):
            count += 1
        mounts[planned.uid] = f"{planned.indenter} {count}"
    return mounts

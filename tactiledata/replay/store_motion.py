"""Inputs of effects from a store: motion of the indenter between frames, and place of the force sensor."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.effects.touch.moved_until import moved_until
from tactiledata.replay.opened import OpenedStore
from tactiledata.replay.plan import PlannedTouch
from tactiledata.replay.poses import gel_from_indenter


class StoreMotion:
    """Motion of the indenter and place of the sensor for a store's trajectories, at rows of its table of frames.

    Parameters
    ----------
    opened : OpenedStore
        Its poses at the native rate and its descriptions are read.
    """

    def __init__(self, opened: OpenedStore) -> None:
        self._opened, self._store = opened, opened.store
        self._t_ns = opened.frame_t_ns

    def facts(self, planned: PlannedTouch, rows: Indices) -> dict[str, Any]:
        """Return fields of a `Touch`: motion until each frame and ``gel_from_sensor``, as far as they are known."""
        places = self.places(planned)
        seconds = (self._t_ns[rows] - self._t_ns[planned.frames[0]]) / 1e9
        return {**({} if places is None else moved_until(seconds, *places)), **self.sensor(planned, len(rows))}

    def places(self, planned: PlannedTouch) -> tuple[Array, Array] | None:
        """Return times (m,), s from the first frame, and positions (m, 3), m, of the tip in the gel frame.

        They have the native rate of the poses. ``None`` where poses or the mounts of gel and indenter are unknown.
        """
        spans = self._opened.by_uid[planned.uid]["spans"]
        if planned.poses not in spans or planned.tcp_from_gel is None or planned.base_from_indenter is None:
            return None
        signal, span = self._store.signal(planned.poses), spans[planned.poses]
        values, t_ns = signal.values(*span), signal.t_ns(*span)
        places = gel_from_indenter(values, planned.tcp_from_gel, planned.base_from_indenter, 0.0)[:, :3, 3]
        is_known = np.isfinite(places).all(axis=1)
        return (t_ns[is_known] - self._t_ns[planned.frames[0]]) / 1e9, places[is_known]

    def sensor(self, planned: PlannedTouch, count: int) -> dict[str, Any]:
        """Return ``gel_from_sensor`` of a `Touch`, (count, 4, 4), m; nothing where the sensor's place is unknown."""
        tcp_from_ft = self._opened.description_of(planned.uid).transform("tcp_from_ft")
        if tcp_from_ft is None or planned.tcp_from_gel is None:
            return {}
        gel_from_sensor = np.linalg.inv(planned.tcp_from_gel) @ tcp_from_ft.matrix
        return {"gel_from_sensor": np.tile(gel_from_sensor, (count, 1, 1))}

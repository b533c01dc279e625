"""Which recordings and trajectories of a store are simulated, by the descriptions that it keeps of its recordings."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable
from typing import TYPE_CHECKING

from tactiledata.contract.simulated import Kind, SimulatedCount, recording_kind

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store


def kinds_of(descriptions: Iterable[str]) -> list[Kind]:
    """What each of the descriptions in a sources table, JSON, states of its recording."""
    return [recording_kind(json.loads(text)) for text in descriptions]


def simulated_recordings(store: Store) -> SimulatedCount:
    """How many of a store's recordings are simulated, real, or do not state it."""
    return SimulatedCount.of(kinds_of(store.sources(["description"])["description"].to_pylist()))


def trajectory_kinds(store: Store) -> list[Kind]:
    """What is stated of the recording that each trajectory of a store is part of, or was derived from."""
    kinds = kinds_of(store.sources(["description"])["description"].to_pylist())
    return [kinds[source] for source in store.trajectories(["source"])["source"].to_pylist()]


def touch_mark(store: Store, trajectory: int) -> str:
    """What tells a trajectory, by its row, from those of other kinds in its store; empty where all are of one kind."""
    kinds = trajectory_kinds(store)
    marks = {"simulated": "simulated recording", "real": "real recording", "not stated": ""}
    return marks[kinds[trajectory]] if "simulated" in kinds and len({*kinds}) > 1 else ""


def simulated_sensors(store: Store) -> list[str]:
    """Names of the sensors of which a store holds simulated recordings."""
    sensors = zip(store.trajectories(["sensor"])["sensor"].to_pylist(), trajectory_kinds(store), strict=True)
    return sorted({sensor for sensor, kind in sensors if kind == "simulated"})


def simulated_trajectories(store: Store, uids: Collection[str] | None = None) -> SimulatedCount:
    """How many of a store's trajectories, all or those with these uids, are of simulated recordings."""
    named = zip(store.trajectories(["uid"])["uid"].to_pylist(), trajectory_kinds(store), strict=True)
    wanted = None if uids is None else set(uids)
    return SimulatedCount.of((kind for uid, kind in named if wanted is None or uid in wanted), "trajectory")

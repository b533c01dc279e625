"""Pictures of touches by sensor, recorded ones apart from those that were made of others."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.take import UNUSABLE
from tactiledata.errors import StoreError
from tactiledata.sensors.image_checks import shows_contact
from tactiledata.store.reader import Store

CONTACT_FORCE = (1.0, 13.0)
"""N; frames whose contact force lies between show a touch, as in splits. Without forces every frame counts."""


@dataclass(frozen=True)
class SensorSet:
    """Frames that bear one sensor's name and were made in one way.

    Parameters
    ----------
    name : str
        The sensor; of derived frames ``SENSOR of PARENT by METHOD``.
    sensor : str
    is_derived : bool
    rows : (n,) int64
        Of the store.
    trajectories : (n,) int64
        Row of each frame's trajectory.
    """

    name: str
    sensor: str
    is_derived: bool
    rows: NDArray[np.int64]
    trajectories: NDArray[np.int64]


def sensor_sets(store: Store, most: int) -> list[SensorSet]:
    """The sets of a store, with at most so many frames each, spread evenly over each set's frames.

    Raises
    ------
    StoreError
        Fewer than two sets.
    """
    frames = store.frames(["trajectory", "flags", "contact_force", "camera"])
    owner = np.asarray(frames["trajectory"])
    whole = (np.asarray(frames["flags"]) & UNUSABLE) == 0
    force = np.asarray(frames["contact_force"].to_numpy(), np.float64)
    in_contact = np.isnan(force).all() | ((force >= CONTACT_FORCE[0]) & (force <= CONTACT_FORCE[1]))
    usable = np.flatnonzero(whole & in_contact & (owner >= 0) & _own_camera(store))
    labels = [_label(row) for row in store.trajectories(["sensor", "parent", "extra"]).to_pylist()]
    found = []
    for label in sorted(set(labels)):
        rows = usable[np.isin(owner[usable], [row for row, one in enumerate(labels) if one == label])]
        if len(rows):
            kept = rows[np.unique(np.linspace(0, len(rows) - 1, most).astype(int))]
            found.append(SensorSet(label[0], label[1], label[2], kept, owner[kept].astype(np.int64)))
    if len(found) < 2:
        raise StoreError(
            f"{store.location} holds touches of {', '.join(one.name for one in found) or 'no sensor'}",
            "two sensors to compare, or one and what was transferred to it",
            "Merge stores first: `tactiledata merge S1 S2 --into both.zarr`.",
        )
    return found


def _own_camera(store: Store) -> NDArray[np.bool_]:
    """Whether each frame is of the sensor that its trajectory is of, not of a camera beside it."""
    sensors = np.array([*store.trajectories(["sensor"])["sensor"].to_pylist(), ""], object)
    frames = store.frames(["sensor", "trajectory"])
    return np.array(frames["sensor"].to_pylist(), object) == sensors[np.asarray(frames["trajectory"])]


def _label(row: dict[str, str]) -> tuple[str, str, bool]:
    if not row["parent"]:
        return row["sensor"], row["sensor"], False
    extra = json.loads(row["extra"])
    made = f"{row['sensor']} of {extra.get('parent_sensor', '?')} by {extra.get('transfer', '?')}"
    return made, row["sensor"], True


def load_pictures(store: Store, one: SensorSet) -> NDArray[np.uint8]:
    """Pictures (n, H, W, 3) of a set.

    Raises
    ------
    StoreError
        Its pictures differ in size.
    """
    pictures = store.images(one.rows)
    if not isinstance(pictures, np.ndarray):
        sizes = sorted({f"{picture.shape[0]} x {picture.shape[1]}" for picture in pictures})
        raise StoreError(f"pictures of {one.name} have sizes {', '.join(sizes)}", "one size a sensor", "")
    return pictures


def background_of(store: Store, one: SensorSet) -> NDArray[np.uint8] | None:
    """The picture without contact (H, W, 3) of a set's sensor; None where the store has none."""
    return store.reference(one.sensor).image if one.sensor in store.manifest["references"] else None


def contact_masks(pictures: NDArray[np.uint8], background: NDArray[np.uint8] | None) -> NDArray[np.bool_] | None:
    """Masks (n, H, W) of where each picture shows its touch; None without a background of that size."""
    if background is None or background.shape != pictures.shape[1:]:
        return None
    return np.stack([shows_contact(picture, background).mask for picture in pictures])

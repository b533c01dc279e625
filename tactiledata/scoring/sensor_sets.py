"""Pictures of touches by sensor: recorded, simulated and synthetic ones apart."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.image_bytes import size_fault
from tactiledata.contract.take import UNUSABLE
from tactiledata.errors import StoreError
from tactiledata.sensors.image_checks import shows_contact
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import trajectory_kinds

CONTACT_FORCE = (1.0, 13.0)
"""N; frames whose contact force lies between show a touch, as in splits. Without forces every frame counts."""
PIXELS_OF_SET = 2**26
"""Largest number of pixels of a set, 192 MiB of RGB: 200 frames of 640 x 480 are fewer. Two sets are in memory."""


@dataclass(frozen=True)
class SensorSet:
    """Frames that bear one sensor's name and were made in one way.

    Parameters
    ----------
    name : str
        The sensor; of derived frames ``SENSOR of PARENT by METHOD``.
    sensor : str
    is_derived : bool
        Made of another sensor's frames.
    is_simulated : bool
        The touches, its own or those that it was made of, are of recordings that state that they are simulated.
    rows : (n,) int64
        Of the store.
    trajectories : (n,) int64
        Row of each frame's trajectory.
    left_out : int
        Frames that were asked for beside these, and would have taken more than `PIXELS_OF_SET`.
    """

    name: str
    sensor: str
    is_derived: bool
    is_simulated: bool
    rows: NDArray[np.int64]
    trajectories: NDArray[np.int64]
    left_out: int = 0

    @property
    def kind(self) -> str:
        """What the pictures are, for people: recorded, a simulated recording, or synthetic."""
        if self.is_derived:
            return "synthetic, of a simulated recording" if self.is_simulated else "synthetic"
        return "simulated recording" if self.is_simulated else "recorded"


def sensor_sets(store: Store, most: int, least: int = 2) -> list[SensorSet]:
    """The sets of a store, sorted by name; those of one name that are recorded and simulated are two.

    Parameters
    ----------
    store : Store
    most : int
        Frames of each set, spread evenly over those that it has; fewer where their pictures are so large that they
        would not fit into memory (`PIXELS_OF_SET`).
    least : int
        Sets that there must be: one is enough where its target is known without touches.

    Raises
    ------
    StoreError
        Fewer sets.
    """
    frames = store.frames(["trajectory", "flags", "contact_force", "camera", "height", "width"])
    owner = np.asarray(frames["trajectory"])
    whole = (np.asarray(frames["flags"]) & UNUSABLE) == 0
    force = np.asarray(frames["contact_force"].to_numpy(), np.float64)
    in_contact = np.isnan(force).all() | ((force >= CONTACT_FORCE[0]) & (force <= CONTACT_FORCE[1]))
    usable = np.flatnonzero(whole & in_contact & (owner >= 0) & _own_camera(store))
    height, width = (frames[side].to_numpy().astype(np.int64) for side in ("height", "width"))
    pixels = np.maximum(height * width, 1)
    labels = _labels(store)
    found = []
    for label in sorted(set(labels)):
        rows = usable[np.isin(owner[usable], [row for row, one in enumerate(labels) if one == label])]
        if len(rows):
            wanted = min(most, len(rows))
            fit = min(wanted, max(1, PIXELS_OF_SET // int(pixels[rows].max())))
            kept = rows[np.unique(np.linspace(0, len(rows) - 1, most if fit == wanted else fit).astype(int))]
            found.append(SensorSet(*label, kept, owner[kept].astype(np.int64), wanted - fit))
    require_sets(store, found, least)
    return found


def size_sentences(sets: Sequence[SensorSet]) -> list[str]:
    """Sentences on the sets that have fewer frames than were asked for, because their pictures are large."""
    return [
        f"{one.name}: {len(one.rows)} of {len(one.rows) + one.left_out} frames are scored; its pictures are so large "
        "that more would not fit into memory. Scaled down before they are ingested, all can be."
        for one in sets
        if one.left_out
    ]


def require_sets(store: Store, sets: Sequence[SensorSet], least: int) -> None:
    """Refuse a store that has fewer sets.

    Parameters
    ----------
    store : Store
    sets : list of SensorSet
    least : int

    Raises
    ------
    StoreError
        Fewer.
    """
    if len(sets) < least:
        raise StoreError(
            f"{store.location} holds touches of {', '.join(some.name for some in sets) or 'no sensor'}",
            "two sensors to compare, or one and what was transferred to it" if least > 1 else "frames in contact",
            "Merge stores first: `tactiledata merge S1 S2 --into both.zarr`.",
        )


def _own_camera(store: Store) -> NDArray[np.bool_]:
    """Whether each frame is of the sensor that its trajectory is of, not of a camera beside it."""
    sensors = np.array([*store.trajectories(["sensor"])["sensor"].to_pylist(), ""], object)
    frames = store.frames(["sensor", "trajectory"])
    return np.array(frames["sensor"].to_pylist(), object) == sensors[np.asarray(frames["trajectory"])]


Label = tuple[str, str, bool, bool]
"""Name, sensor, whether derived, whether simulated, of a set."""


def _labels(store: Store) -> list[Label]:
    """The set that each trajectory belongs to; a name says what tells sets apart that would have the same."""
    rows = store.trajectories(["sensor", "parent", "extra"]).to_pylist()
    labels = [
        (_name(row), row["sensor"], bool(row["parent"]), kind == "simulated")
        for row, kind in zip(rows, trajectory_kinds(store), strict=True)
    ]
    recorded = {name for name, _, _, is_simulated in labels if not is_simulated}
    return [
        (f"{name}, simulated" if is_simulated and name in recorded else name, sensor, is_derived, is_simulated)
        for name, sensor, is_derived, is_simulated in labels
    ]


def _name(row: Mapping[str, str]) -> str:
    if not row["parent"]:
        return row["sensor"]
    extra = json.loads(row["extra"])
    return f"{row['sensor']} of {extra.get('parent_sensor', '?')} by {extra.get('transfer', '?')}"


def load_pictures(store: Store, one: SensorSet) -> NDArray[np.uint8]:
    """Pictures (n, H, W, 3) of a set.

    Raises
    ------
    StoreError
        Its pictures differ in size.
    """
    # before any is decoded: pictures of several sizes would be, all of them, for nothing
    sides = store.frames(["height", "width"]).take(one.rows)
    sizes = sorted(set(zip(*(sides[side].to_pylist() for side in ("height", "width")), strict=True)))
    # one beyond the limit is refused by the store, which names its frame
    if len(sizes) > 1 and not any(size_fault(*size) for size in sizes):
        raise StoreError(
            f"pictures of {one.name} have sizes {', '.join(f'{rows} x {columns}' for rows, columns in sizes)} "
            "(rows x columns)",
            "one size a sensor",
            "Ingest its recordings again with --replace: single images of another size are then marked and left out.",
        )
    return np.asarray(store.images(one.rows))


def background_of(store: Store, one: SensorSet) -> NDArray[np.uint8] | None:
    """The picture without contact (H, W, 3) of a set's sensor; None where the store has none."""
    return store.reference(one.sensor).image if one.sensor in store.manifest["references"] else None


def contact_masks(pictures: NDArray[np.uint8], background: NDArray[np.uint8] | None) -> NDArray[np.bool_] | None:
    """Masks (n, H, W) of where each picture shows its touch; None without a background of that size."""
    if background is None or background.shape != pictures.shape[1:]:
        return None
    return np.stack([shows_contact(picture, background).mask for picture in pictures])

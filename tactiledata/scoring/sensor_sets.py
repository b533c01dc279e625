"""Frames of touches by sensor; recorded, simulated and synthetic ones are different sets."""

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
"""Range of contact forces, N, of frames that count as a touch, as in splits. Without forces every frame counts."""
PIXELS_OF_SET = 2**26
"""Largest number of pixels of a set, 192 MiB of RGB: 200 frames of 640 x 480 have fewer. Two sets are in memory."""


@dataclass(frozen=True)
class SensorSet:
    """Frames that bear one sensor's name and were made in one way.

    Parameters
    ----------
    name : str
        Name of the sensor; of derived frames ``SENSOR of PARENT by METHOD``.
    sensor : str
        Serial of the sensor.
    is_derived : bool
        Whether the frames were made from frames of another sensor.
    is_simulated : bool
        Whether the recordings, or those from which the frames were made, state that they are simulated.
    rows : (n,) int64
        Row of each frame in the store.
    trajectories : (n,) int64
        Row of the trajectory of each frame.
    left_out : int
        Number of frames that were requested too, but would have taken more than `PIXELS_OF_SET`.
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
        """Kind of the pictures, in words: recorded, a simulated recording, or synthetic."""
        if self.is_derived:
            return "synthetic, of a simulated recording" if self.is_simulated else "synthetic"
        return "simulated recording" if self.is_simulated else "recorded"


def sensor_sets(store: Store, most: int, least: int = 2) -> list[SensorSet]:
    """Return the sets of a store, sorted by name; recorded and simulated frames of one name are two sets.

    Parameters
    ----------
    store : Store
        The store to read.
    most : int
        Largest number of frames of a set, spread evenly over those that it has; fewer where their pictures are so
        large that they would not fit into memory (`PIXELS_OF_SET`).
    least : int
        Least number of sets; one is enough where the target is known without touches.

    Raises
    ------
    StoreError
        A store with fewer sets.
    """
    # usable frames in contact
    frames = store.frames(["trajectory", "flags", "contact_force", "camera", "height", "width"])
    owner = np.asarray(frames["trajectory"])
    whole = (np.asarray(frames["flags"]) & UNUSABLE) == 0
    force = np.asarray(frames["contact_force"].to_numpy(), np.float64)
    in_contact = np.isnan(force).all() | ((force >= CONTACT_FORCE[0]) & (force <= CONTACT_FORCE[1]))
    usable = np.flatnonzero(whole & in_contact & (owner >= 0) & _own_camera(store))
    height, width = (frames[side].to_numpy().astype(np.int64) for side in ("height", "width"))
    pixels = np.maximum(height * width, 1)
    # for each set as many of them as were requested, and as fit into memory
    labels = _labels(store)
    sets = []
    for label in sorted(set(labels)):
        rows = usable[np.isin(owner[usable], [row for row, other in enumerate(labels) if other == label])]
        if len(rows):
            requested = min(most, len(rows))
            fit = min(requested, max(1, PIXELS_OF_SET // int(pixels[rows].max())))
            kept = rows[np.unique(np.linspace(0, len(rows) - 1, most if fit == requested else fit).astype(int))]
            sets.append(SensorSet(*label, kept, owner[kept].astype(np.int64), requested - fit))
    require_sets(store, sets, least)
    return sets


def size_sentences(sets: Sequence[SensorSet]) -> list[str]:
    """Return a sentence on each set that has fewer frames than requested, because its pictures are large."""
    return [
        f"{cut.name}: {len(cut.rows)} of {len(cut.rows) + cut.left_out} frames are scored; its pictures are so large "
        "that more would not fit into memory. Scaled down before they are ingested, all can be."
        for cut in sets
        if cut.left_out
    ]


def require_sets(store: Store, sets: Sequence[SensorSet], least: int) -> None:
    """Refuse a store that has fewer sets than are needed.

    Parameters
    ----------
    store : Store
        The store, for the message.
    sets : list of SensorSet
        Sets that it has.
    least : int
        Least number of sets.

    Raises
    ------
    StoreError
        Fewer sets than ``least``.
    """
    if len(sets) < least:
        raise StoreError(
            f"{store.location} holds touches of {', '.join(present.name for present in sets) or 'no sensor'}",
            "two sensors to compare, or one and what was transferred to it" if least > 1 else "frames in contact",
            "Merge stores first: `tactiledata merge S1 S2 --into both.zarr`.",
        )


def _own_camera(store: Store) -> NDArray[np.bool_]:
    """Return whether each frame (f,) is of the sensor of its trajectory, and not of a camera beside it."""
    sensors = np.array([*store.trajectories(["sensor"])["sensor"].to_pylist(), ""], object)
    frames = store.frames(["sensor", "trajectory"])
    return np.array(frames["sensor"].to_pylist(), object) == sensors[np.asarray(frames["trajectory"])]


Label = tuple[str, str, bool, bool]
"""Name, sensor, whether derived, whether simulated, of a set."""


def _labels(store: Store) -> list[Label]:
    """Return the label of the set of each trajectory; simulated sets say so where a recorded one has their name."""
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
    """Return the name of the set of a trajectory: its sensor, and for derived frames parent and method."""
    if not row["parent"]:
        return row["sensor"]
    extra = json.loads(row["extra"])
    return f"{row['sensor']} of {extra.get('parent_sensor', '?')} by {extra.get('transfer', '?')}"


def load_pictures(store: Store, sensor_set: SensorSet) -> NDArray[np.uint8]:
    """Return the pictures (n, H, W, 3), uint8 RGB, of a set.

    Raises
    ------
    StoreError
        Pictures of several sizes.
    """
    # before any picture is decoded: where sizes differ, all of them would be decoded in vain
    sides = store.frames(["height", "width"]).take(sensor_set.rows)
    sizes = sorted(set(zip(*(sides[side].to_pylist() for side in ("height", "width")), strict=True)))
    # the store refuses a picture beyond the limit, and names its frame
    if len(sizes) > 1 and not any(size_fault(*size) for size in sizes):
        raise StoreError(
            f"pictures of {sensor_set.name} have sizes {', '.join(f'{rows} x {columns}' for rows, columns in sizes)} "
            "(rows x columns)",
            "one size a sensor",
            "Ingest its recordings again with --replace: single images of another size are then marked and left out.",
        )
    return np.asarray(store.images(sensor_set.rows))


def background_of(store: Store, sensor_set: SensorSet) -> NDArray[np.uint8] | None:
    """Return the picture (H, W, 3) without contact of the sensor of a set; None where the store has none."""
    sensor = sensor_set.sensor
    return store.reference(sensor).image if sensor in store.manifest["references"] else None


def contact_masks(pictures: NDArray[np.uint8], background: NDArray[np.uint8] | None) -> NDArray[np.bool_] | None:
    """Return masks (n, H, W) of where each picture shows its touch; None without a background of that size."""
    if background is None or background.shape != pictures.shape[1:]:
        return None
    return np.stack([shows_contact(picture, background).mask for picture in pictures])

"""What a sensor looks like in free air, as a store's own frames tell."""

from __future__ import annotations

import numpy as np
import pyarrow.compute as pc
from numpy.typing import NDArray

from tactiledata.contract.take import UNUSABLE
from tactiledata.store.read.reader import Store

FREE_AIR = 0.2
"""N; frames below it show no contact, as where ingest looks for a background."""
LEAST_FRAMES = 3
MOST_FRAMES = 16


def free_air_median(store: Store, sensor: str) -> NDArray[np.uint8] | None:
    """The median (H, W, 3) of a sensor's frames without contact force; None where there are fewer than three."""
    frames = store.frames(["sensor", "flags", "contact_force"])
    force = np.asarray(frames["contact_force"].to_numpy(), np.float64)
    whole = (np.asarray(frames["flags"]) & UNUSABLE) == 0
    rows = np.flatnonzero(whole & (force < FREE_AIR) & np.asarray(pc.equal(frames["sensor"].cast("string"), sensor)))
    if len(rows) < LEAST_FRAMES:
        return None
    chosen = rows[np.unique(np.linspace(0, len(rows) - 1, MOST_FRAMES).astype(int))]
    pictures = [np.asarray(image) for image in store.images(chosen)]
    alike = [picture for picture in pictures if picture.shape == pictures[0].shape]
    return np.rint(np.median(alike, axis=0)).astype(np.uint8)

"""Backgrounds that nothing may be learned from: those of sensors that are held out to be tested on."""

from __future__ import annotations

from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.store.reader import Store

Picture = NDArray[np.uint8]
SAME = 3.0
"""Grey levels on average; two pictures without contact that differ by less are of one unit."""


def refuse_held_out(name: str, picture: Picture, store: Store, known: Collection[str], remedy: str) -> None:
    """Nothing, where a background (h, w, 3) is of no sensor of the store beside those that may be learned from.

    A bundled picture that is a held-out sensor's own is found by its pixels, whatever it is called.

    Raises
    ------
    UsageError
        It is a held-out sensor's.
    """
    for sensor, reference in store.references().items():
        if sensor in known:
            continue
        size = picture.shape[1::-1]
        other = np.asarray(cv2.resize(reference.image, size, interpolation=cv2.INTER_AREA), np.float64)
        if np.abs(other - picture).mean() < SAME:
            raise UsageError(
                f"the background {name!r} is that of sensor {sensor}, which is held out of training",
                "backgrounds of sensors that are not tested on",
                remedy,
            )

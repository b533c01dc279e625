"""Backgrounds that nothing may be learned from: those of sensors that are held out to be tested on."""

from __future__ import annotations

from collections.abc import Collection

from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError
from tactiledata.sensors.same_sensor import is_same_sensor
from tactiledata.store.read.reader import Store


def refuse_held_out(name: str, picture: PictureArray, store: Store, known: Collection[str], remedy: str) -> None:
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
        if is_same_sensor(reference.image, picture):
            raise UsageError(
                f"the background {name!r} is that of sensor {sensor}, which is held out of training",
                "backgrounds of sensors that are not tested on",
                remedy,
            )

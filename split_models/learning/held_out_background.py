"""A check that no background of a held-out sensor is learned from."""

from __future__ import annotations

from collections.abc import Collection

from tactiledata.arrays import PictureArray
from tactiledata.errors import UsageError
from tactiledata.sensors.same_sensor import is_same_sensor
from tactiledata.store.read.reader import Store


def refuse_held_out(name: str, picture: PictureArray, store: Store, known: Collection[str], remedy: str) -> None:
    """Refuse a background (h, w, 3) of a sensor that is held out of training.

    Backgrounds are compared by their pixels, so that a bundled picture of a held-out sensor is refused under any name.

    Parameters
    ----------
    name : str
        Name of the background, for the message.
    picture : (h, w, 3) uint8 RGB
        The background.
    store : Store
        The store whose sensors are held out, but for the known ones.
    known : collection of str
        Sensors that may be learned from.
    remedy : str
        Advice at the end of the message.

    Raises
    ------
    UsageError
        The background is that of a held-out sensor.
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

"""Sensors: what are the instruments, and what do pictures say about them?

A sensor is one frozen description in one file, and one line in the table below. Read in this order:

- ``base``: what a description states; every number has its source.
- ``digit``, ``gelsight_r15``, ``robotiq_ft300s``: the descriptions.
- ``backgrounds``: pictures of untouched DIGIT sensors that come with the package.
- ``image_checks``: whether a picture is turned, has swapped channels, or shows a touch.
- ``average_background``, ``same_sensor``: one background from several frames; whether two are of one sensor.

Nothing here reads logs or stores.
"""

from tactiledata.registry import Registry

SENSORS = Registry(
    "sensor",
    {
        "digit": "tactiledata.sensors.digit:DIGIT",
        "gelsight_r15": "tactiledata.sensors.gelsight_r15:GELSIGHT_R15",
        "robotiq_ft300s": "tactiledata.sensors.robotiq_ft300s:ROBOTIQ_FT300S",
    },
    group="tactiledata.sensors",
)
"""Sensor models by name; each is a frozen ``Sensor``. Units of a model are known by serial, and not listed here."""

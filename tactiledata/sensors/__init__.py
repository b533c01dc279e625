"""Sensors: what an instrument is, one file and one line each."""

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
"""Sensor models by name; each is a frozen ``Sensor``. A unit of a model is known by its serial, not listed here."""

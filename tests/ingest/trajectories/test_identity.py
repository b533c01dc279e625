"""Which sensor an image belongs to: serials are taken where they are stated, and contradictions are said."""

import numpy as np
import pyarrow as pa
import pytest

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Recording, Source, Trajectory
from tactiledata.ingest.trajectories.frames import CapturedFrames
from tactiledata.ingest.trajectories.identity import name_sensors


def named(sensors, cameras, trajectories=()):
    """Sensors of images one second apart, trajectories and findings."""
    images = pa.table({"camera": cameras, "trajectory": [""] * len(cameras)})
    captured = CapturedFrames(images, np.arange(len(cameras)) * 10**9, sensors, {}, [])
    recording = Recording(Source("run.mcap", "run.mcap", "mcap", ()), LogDescription(), {}, (), (), "log")
    findings = []
    sensors, trajectories = name_sensors(recording, captured, tuple(trajectories), "ab" * 32, findings.append)
    return sensors, trajectories, [(finding.code, finding.severity) for finding in findings]


def test_one_serial_on_two_cameras_is_damage():
    """Two cameras that claim one sensor cannot both be right."""
    _, _, said = named(["D20542", "D20542"], ["left", "right"])
    assert said == [("serial-shared", "damage")]
    _, _, said = named(["D20542", "D20001", "D20542"], ["left", "right", "left"])
    assert said == []


def test_images_of_nobody_get_a_name_of_their_own():
    """Images without a serial are filed under a name that no other recording has."""
    sensors, _, said = named(["", ""], ["digit", "digit"])
    assert sensors == ["unknown-abababab"] * 2
    assert said == [("sensor-unknown", "warning")]


def test_two_cameras_of_nobody_are_two_sensors():
    """Each unknown camera of a recording has a name of its own; a known one beside an unknown one keeps its serial."""
    sensors, _, said = named(["", "", ""], ["digit", "digit_2", "digit"])
    assert sensors == ["unknown-abababab-digit", "unknown-abababab-digit_2", "unknown-abababab-digit"]
    assert said == [("sensor-unknown", "warning")]
    assert named(["D20542", ""], ["digit", "digit_2"])[0] == ["D20542", "unknown-abababab"]


@pytest.mark.parametrize(("second", "expected"), [("", "D20542"), ("D20001", "D20001")])
def test_a_trajectory_lends_its_sensor(second, expected):
    """An image without a serial inside a trajectory takes that of the trajectory; its own serial wins."""
    sensors, _, said = named(["D20542", second], ["digit", "digit"], [Trajectory("t", 0, 2 * 10**9, "D20542")])
    assert sensors == ["D20542", expected]
    assert said == []


def test_a_trajectory_takes_the_sensor_of_its_images():
    """A trajectory without a sensor is called after the images inside it."""
    _, (one,), _ = named(["D20542"], ["digit"], [Trajectory("t", 0, 10**9)])
    assert one.sensor == "D20542"

"""What the table of sensors says."""

import dataclasses

import pytest

from tactiledata.errors import UnknownName, UsageError
from tactiledata.sensors import SENSORS
from tactiledata.sensors.base import ForceSpecification, GelGeometry, Sensor, TactileCamera


@pytest.mark.parametrize("name", SENSORS)
def test_sensor_is_complete_and_plausible(name):
    """Every model is under its own name, frozen, in SI units, each number with a source."""
    sensor = SENSORS[name]
    assert sensor.name == name
    with pytest.raises(dataclasses.FrozenInstanceError):
        sensor.name = "other"
    assert all(len(source) > 10 for source in sensor.sources.values())
    if sensor.kind == "tactile":
        short, long = sensor.gel.outline
        assert 0.005 < short <= long < 0.05
        assert 0 < sensor.gel.edge_thickness <= sensor.gel.thickness < 0.01
        assert all(1e-5 < pitch < 2e-4 for pitch in sensor.camera.pixel_pitch)
    else:
        assert 0 < sensor.force.force_quantum <= sensor.force.force_noise < sensor.force.force_range


def test_digit_is_the_canonical_picture():
    """DIGIT pictures have 320 rows and 240 columns, its gel is domed and its short side is first."""
    digit = SENSORS["digit"]
    assert digit.camera.shape == (320, 240)
    assert not digit.gel.is_flat
    assert digit.camera.field_of_view[1] < digit.gel.outline[0]
    assert digit.camera.field_of_view[0] < digit.gel.outline[1]


def test_gelsight_pixel_is_the_packs():
    """The GelSight's pitch is the calibration pack's, in both directions."""
    assert SENSORS["gelsight_r15"].camera.pixel_pitch == pytest.approx((0.1245e-3, 0.1245e-3))


def test_number_without_source_is_refused():
    """A sensor cannot be described by numbers from nowhere."""
    with pytest.raises(UsageError, match=r"sources of gel\.outline"):
        Sensor(
            "x",
            "X",
            "us",
            "tactile",
            GelGeometry((0.01, 0.02), 0.002, 0.002),
            TactileCamera((1, 1), (0.01, 0.01), 30.0),
        )


def test_kind_without_its_part_is_refused():
    """A tactile sensor has a gel and a camera."""
    force = ForceSpecification(1.0, 1.0, 0.1, 0.1, 0.1, 0.1, 100.0)
    sources = {f"force.{field.name}": "made up for this test" for field in dataclasses.fields(force)}
    Sensor("x", "X", "us", "force", force=force, sources=sources)
    with pytest.raises(UsageError, match="gel, camera or force"):
        Sensor("x", "X", "us", "tactile", force=force, sources=sources)


def test_unknown_sensor_lists_near_names():
    """A misspelt model is told the nearest one."""
    with pytest.raises(UnknownName, match="Did you mean digit"):
        SENSORS["digitt"]

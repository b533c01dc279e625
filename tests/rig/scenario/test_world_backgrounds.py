"""Units of the bundled worlds have backgrounds of their own."""

import pytest

from tactiledata.rig.logs.sampling import background_of
from tactiledata.rig.scenario.scenario import load_scenario
from tactiledata.rig.scenario.worlds import bundled_worlds, find_scenario
from tactiledata.sensors.backgrounds import ALIASES, load_background
from tactiledata.sensors.same_sensor import is_same_sensor


def units_of(name):
    """Pictures of the units of a bundled world, by serial."""
    scenario = load_scenario(find_scenario(name))
    return {serial: background_of(scenario, serial) for serial in scenario.sensors}


@pytest.mark.parametrize("name", bundled_worlds())
def test_no_unit_is_a_transfer_target(name):
    """No unit's picture is that of ycb-sensorA or ycb-sensorB, by pixels: those must be unseen sensors."""
    for serial, picture in units_of(name).items():
        for target in ALIASES:
            assert not is_same_sensor(picture, load_background(target)), f"{serial} of {name} is {target}"


def test_units_have_one_picture_each():
    """Two serials are two pictures, and a serial has one picture in all worlds, whose stores can be merged."""
    seen = {}
    for name in bundled_worlds():
        units = units_of(name)
        for serial, picture in units.items():
            assert sum(is_same_sensor(picture, other) for other in units.values()) == 1
            assert is_same_sensor(seen.setdefault(serial, picture), picture)

"""Of what E, nu and mu are said to be, under effects that make them depend on something."""

import pytest

from tactiledata.diagnose.answer.sentences import material_is_of
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting


def told(*effects):
    return material_is_of([EffectSetting(name, values) for name, values in effects])


def test_each_is_said_once():
    """Effects that change what E, nu and mu mean are each told in one clause; others are not told."""
    relaxing = ("relaxation", {"share": 0.1})
    assert told(relaxing, relaxing) == ["E is then that of the gel once relaxed."]
    assert told(relaxing, ("heating", {})) == ["E is then that of the gel once relaxed and the gel at power-on."]
    assert told(("wear", {})) == ["E and mu are then those of an unused spot."]
    assert told(("rate_friction", {"speed": 5e-4}), ("lag", {})) == ["mu is then that of a slide at 0.5 mm/s."]
    assert told(("lag", {}), ("frame_rotation", {})) == []


@pytest.mark.parametrize("name", EFFECTS)
def test_only_of_the_material(name):
    """What an effect says is of E, nu or mu."""
    effect = EFFECTS[name]()
    assert set(effect.material_of(effect.complete({}))) <= {"E", "nu", "mu"}

"""Settings as files, and simulators with effects as simulators."""

import json

import numpy as np
import pytest

from tactiledata.effects import EFFECTS
from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.simulate.setting import (
    EffectSetting,
    effects_document,
    read_material,
    read_settings,
    settings_of,
    write_settings,
)
from tactiledata.effects.simulate.simulator import Simulator, with_effects
from tactiledata.effects.touch.response import GelVariant, SoftSpot
from tactiledata.errors import MissingFile, SchemaError, UnknownName, UsageError
from tactiledata.gel.elasticity.material import GelMaterial


def test_every_setting_survives_its_file(tmp_path, touch, medium):
    """Written and read again: equal settings, the same bytes of wrench."""
    settings = [EffectSetting(name, medium(name), {"mount": "first"}) for name in reversed(list(EFFECTS))]
    write_settings(settings, tmp_path / "effects.json")
    back = read_settings(tmp_path / "effects.json")
    assert [setting.effect for setting in back] == list(EFFECTS)
    assert sorted(map(str, back)) == sorted(map(str, settings))
    here, there = (with_effects(BallOnLayer, some).play(touch).wrench for some in (settings, back))
    assert here.tobytes() == there.tobytes()
    assert np.isfinite(here).all()


def test_the_gel_that_was_fitted_goes_along(tmp_path):
    """E, nu and mu are kept beside the effects; a file may have none."""
    material = GelMaterial(9.05e5, 0.485, 0.8)
    write_settings([EffectSetting("thickness", {"error": 0.1})], tmp_path / "fit.json", material)
    write_settings([], str(tmp_path / "none.json"))
    assert read_material(tmp_path / "fit.json") == material
    assert read_material(tmp_path / "none.json") is None
    assert read_settings(tmp_path / "fit.json")[0].values == {"error": 0.1}


def test_the_gel_of_several_effects_is_one(touch):
    """Factors multiply, the rest adds; what is null, or restricted to another sensor, is not in it."""
    simulator = with_effects(
        BallOnLayer,
        [
            EffectSetting("thickness", {"error": 0.1}),
            EffectSetting("strain_stiffening", {"c20": 0.1}),
            EffectSetting("soft_region", {"normal_loss": 0.2, "x": 1e-3}),
            EffectSetting("dome", {"curvature": 0.0}),
            EffectSetting("skin", {"excess": 1e-4}, {"sensor": "another"}),
            EffectSetting("relaxation", {"share": 0.1}),
        ],
    )
    spot = SoftSpot(1e-3, 0.0, 2e-3, 0.2)
    assert simulator.variant(touch) == GelVariant(thickness=1.1, c20=0.1, spots=(spot,))


def test_missing_values_have_their_defaults():
    """A document may leave shapes out; what is written is complete."""
    document = {"format": "tactiledata-effects/1", "effects": [{"effect": "relaxation", "values": {"share": 0.1}}]}
    (setting,) = settings_of(document, "here")
    assert setting.values == {"share": 0.1, "time": 3.0}
    assert effects_document([setting])["effects"][0]["values"] == {"share": 0.1, "time": 3.0}


@pytest.mark.parametrize(
    ("entry", "error", "message"),
    [
        ({"effect": "relaxatoin", "values": {}}, UnknownName, "Did you mean relaxation"),
        ({"effect": "relaxation", "values": {"tau": 1.0}}, UnknownName, "parameter of effect 'relaxation' 'tau'"),
        ({"effect": "relaxation", "values": {"share": 7.0}}, UsageError, "from 0 to 1"),
        ({"effect": "relaxation", "values": {"share": "much"}}, SchemaError, "docs/effects.md"),
        ({"effect": "relaxation", "values": {}, "where": {"camera": "x"}}, SchemaError, "camera"),
        ({"effect": "relaxation"}, SchemaError, "values"),
        ("relaxation", SchemaError, "object"),
    ],
)
def test_wrong_documents_are_refused(tmp_path, entry, error, message):
    """Each with what was found and what to do."""
    path = tmp_path / "effects.json"
    path.write_text(json.dumps({"format": "tactiledata-effects/1", "effects": [entry]}))
    with pytest.raises(error, match=message):
        read_settings(path)


def test_files_that_are_none_are_refused(tmp_path):
    """A file that is not there, is no JSON or has another format is refused."""
    with pytest.raises(MissingFile):
        read_settings(tmp_path / "none.json")
    (tmp_path / "torn.json").write_text('{"format": "tactile')
    with pytest.raises(SchemaError):
        read_settings(tmp_path / "torn.json")
    with pytest.raises(SchemaError, match="format"):
        settings_of({"format": "tactiledata-effects/2", "effects": []}, "here")


def test_effects_on_a_simulator_give_a_simulator(touch, play, medium):
    """Effects given one after the other or all at once, in any order, give the same simulator."""
    weak, strong = EffectSetting("relaxation", medium("relaxation")), EffectSetting("thickness", medium("thickness"))
    once = with_effects(BallOnLayer, [weak, strong])
    twice = Simulator(BallOnLayer).with_effects([weak]).with_effects([strong])
    assert once == twice
    assert once.play(touch).wrench.tobytes() == twice.play(touch).wrench.tobytes()
    assert Simulator(BallOnLayer).play(touch).wrench.tobytes() == play().wrench.tobytes()

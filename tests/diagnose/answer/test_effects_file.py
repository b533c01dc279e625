"""`effects.json`: what a replay reads of a diagnosis."""

from types import SimpleNamespace

import numpy as np
import pytest

from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.provenance import provenance
from tactiledata.diagnose.answer.documents import effects_file
from tactiledata.effects.simulate.setting import EffectSetting, effects_document, read_material, read_settings
from tactiledata.gel.elasticity.material import GelMaterial

LAG = EffectSetting("lag", {"delay": 0.01})
GEL = GelMaterial(0.9e6, 0.47, 0.7)


def done(offsets):
    fit = SimpleNamespace(model=SimpleNamespace(offsets=np.array(offsets)))
    naming = SimpleNamespace(decision=SimpleNamespace(best=SimpleNamespace(fit=fit)))
    return SimpleNamespace(naming=naming, played=SimpleNamespace(uids=("first", "second")))


def document(effects):
    return {
        "naming": {"effects": effects},
        "provenance": provenance("diagnose", {"store": "0"}, {"fidelity": "linear"}),
    }


def test_it_holds_effects_material_offsets_and_what_made_it(tmp_path):
    """The file gives back effects and material, and holds each trajectory's offset and the settings of the fit."""
    found = effects_file(done([1e-5, -2e-5]), document(effects_document([LAG], GEL)))
    write_json_atomic(tmp_path / "effects.json", found)
    assert read_settings(tmp_path / "effects.json") == (LAG,)
    assert read_material(tmp_path / "effects.json") == GEL
    assert found["offsets"] == {"first": 1e-5, "second": -2e-5}
    assert found["provenance"]["settings"] == {"fidelity": "linear"}


def test_nothing_is_written_where_nothing_is_claimed():
    """Without a claim there is no file of effects."""
    assert effects_file(done([0.0, 0.0]), document(None)) is None


def test_offsets_belong_to_the_trajectories_that_took_part():
    """Another number of offsets than of trajectories is refused."""
    with pytest.raises(ValueError, match="zip"):
        effects_file(done([1e-5]), document(effects_document([LAG], GEL)))

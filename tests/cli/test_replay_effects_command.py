"""`replay --effects`: what it takes from the file, what it says, and which files it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.effects.simulate.setting import EffectSetting, write_settings
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.mesh import structured_pad
from tactiledata.gel.mesh.structured_pad import GridPlan
from tactiledata.store.read.reader import Store

ROUGH = GridPlan(5, 6, 1.2e-3, (4.8e-3, 6.0e-3), (0.0, 0.6, 1.0))
TURN = EffectSetting("frame_rotation", {"yaw": 0.1})


@pytest.fixture
def store(tiny_store, tmp_path, monkeypatch):
    """A copy of the tiny store in the working folder; the pad called low is a coarse one."""
    monkeypatch.setenv("TACTILEDATA_CACHE", str(tmp_path / "cache"))
    monkeypatch.setitem(structured_pad.PLANS, "low", ROUGH)
    monkeypatch.chdir(tmp_path)
    return copy_tree(tiny_store, tmp_path / "ds.zarr")


@pytest.mark.slow
def test_material_and_effects_come_from_the_file(store, capsys):
    """A mesh beside the plain one, labelled; what is stated wins, and each number says where it comes from."""
    write_settings([TURN], Path("effects.json"), GelMaterial(0.9e6, 0.45, 0.7))
    given = ("replay", "--fidelity", "linear", "--effects", "effects.json", "--friction", "0.8")
    code, out, err = run_command(capsys, *given)
    assert code == 0, err
    assert "mesh low-linear-effects" in out
    assert "rotation of the force frame (yaw 0.1 rad)" in out
    assert "E 9e+05 Pa (from the effects), nu 0.45 (from the effects), mu 0.8 (stated)" in out
    page = next(line.partition("look: ")[2] for line in out.splitlines() if line.startswith("look: "))
    assert "rotation of the force frame" in Path(page).read_text(encoding="utf-8")
    assert "linear, with frame_rotation" in run_command(capsys, "info")[1]
    settings = Store.open(store).mesh("low-linear-effects").settings
    assert settings["effects"] == [TURN.document]
    code, out, _ = run_command(capsys, *given, "--json")
    assert (code, json.loads(out)["new_frames"]) == (0, 0)
    write_settings([EffectSetting("frame_rotation", {"yaw": 0.0})], Path("null.json"), GelMaterial(0.9e6, 0.45, 0.8))
    code, out, _ = run_command(capsys, "replay", "--fidelity", "linear", "--effects", "null.json")
    assert code == 0
    assert "every effect in the file has no strength" in out
    plain, turned = (Store.open(store).mesh(name) for name in ("low-linear", "low-linear-effects"))
    assert np.array_equal(plain.displacement(), turned.displacement())


FORMAT = {"format": "tactiledata-effects/1"}
MATERIAL = {"material": {"youngs_modulus": 0.9e6, "poisson_ratio": 0.45, "friction": 0.8}}
GOOD = {"effect": "lag", "values": {"delay": 0.01}}


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "effects.json"),
        ("no json", "effects.json"),
        ({"format": "tactiledata-calibration/1"}, "effect"),
        ({**FORMAT, **MATERIAL, "effects": [{"effect": "gremlins", "values": {}}]}, "gremlins"),
        ({**FORMAT, **MATERIAL, "effects": [{"effect": "lag", "values": {"speed": 1.0}}]}, "speed"),
        ({**FORMAT, **MATERIAL, "effects": [{"effect": "lag", "values": {"delay": 5.0}}]}, "-0.5"),
        ({**FORMAT, **MATERIAL, "effects": [{**GOOD, "where": {"sensor": "D99999"}}]}, "another store"),
        ({**FORMAT, "effects": [GOOD]}, "--youngs-modulus"),
    ],
)
def test_files_that_are_no_effects_of_this_store_are_wrong_usage(store, content, words, capsys):
    """A file without usable effects exits with 2 and its cause, and attaches no mesh."""
    if content is not None:
        Path("effects.json").write_text(content if isinstance(content, str) else json.dumps(content))
    code, _, err = run_command(capsys, "replay", "--fidelity", "linear", "--effects", "effects.json")
    assert code == 2, err
    assert words in err
    assert "rror: " in err
    assert "Traceback" not in err
    assert Store.open(store).mesh_names == ()

"""A recipe's world is replayed with a calibrated material, unless the recipe asks for the planted one."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from touch_world import tiny_recipe

from split_models.recipe import prepare
from split_models.recipe.prepare import prepare_store, replayed_name, store_place
from split_models.recipe.recipe import load_recipe
from tactiledata.errors import MissingFile
from tactiledata.rig.scenario.worlds import find_scenario

FITTED = {"youngs_modulus": 8.5e5, "poisson_ratio": 0.47, "friction": 0.6, "offsets": {"uid": 1e-5}}


@pytest.fixture
def prepared(tmp_path, monkeypatch):
    """Prepare a world with a section ``replay``; no step does its work, and what the steps were given is returned."""
    world = dict(find_scenario("tiny"))
    world["generate"] = {**world["generate"], "count": 2}
    (tmp_path / "world.yaml").write_text(yaml.safe_dump(world))
    given = {"calibrations": 0}

    def calibrate(store, options, progress):
        given["calibrations"] += 1
        given["fidelity"] = options.fidelity
        return FITTED

    def write(found, path):
        Path(path).write_text(json.dumps(found))
        return found

    monkeypatch.setattr("tactiledata.calibrate.calibrate.calibrate", calibrate)
    monkeypatch.setattr("tactiledata.calibrate.document.write_calibration", write)
    monkeypatch.setattr(prepare, "record", lambda *words: None)
    monkeypatch.setattr(prepare, "ingest", lambda *words, **options: SimpleNamespace(fell_short=False))
    monkeypatch.setattr(prepare, "Store", SimpleNamespace(open=lambda place: place))
    monkeypatch.setattr(prepare, "replay", lambda store, options, workers, progress: given.update(options=options))
    monkeypatch.setattr(prepare, "read_document", lambda path, kind: json.loads(Path(path).read_text()))
    monkeypatch.setattr(prepare, "make_split", lambda *words, **options: None)
    monkeypatch.setattr(prepare, "_scenario_document", lambda name: world)

    def run(**section):
        recipe = tiny_recipe("ds.zarr", "mesh")
        recipe["data"] = {"world": str(tmp_path / "world.yaml"), "replay": {"fidelity": "linear", **section}}
        (tmp_path / "recipe.yaml").write_text(yaml.safe_dump(recipe))
        loaded = load_recipe(tmp_path / "recipe.yaml")
        prepare_store(loaded, tmp_path / "out", 1, lambda *told: None)
        return given, loaded, store_place(loaded, tmp_path / "out")

    return run


def test_a_store_that_is_not_there_is_told_with_the_recipe(tmp_path, monkeypatch):
    """The message says which recipe names the store, and from where its path is seen."""
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text(yaml.safe_dump(tiny_recipe("stores/ds.zarr", "mesh")))
    with pytest.raises(MissingFile, match=r"the recipe mine names the store stores/ds\.zarr.* working folder"):
        store_place(load_recipe("mine.yaml"), tmp_path / "out")
    Path("stores/ds.zarr").mkdir(parents=True)
    assert store_place(load_recipe("mine.yaml"), tmp_path / "out") == Path("stores/ds.zarr")


def test_a_world_is_calibrated_before_it_is_replayed(prepared):
    """By default E, nu, mu and offsets of the replay are the calibration's, which a second run does not repeat."""
    given, loaded, place = prepared()
    material = given["options"].material
    assert (material.youngs_modulus, material.poisson_ratio, material.friction) == (8.5e5, 0.47, 0.6)
    assert given["options"].offsets == FITTED["offsets"]
    assert given["options"].name == "low-linear-calibrated" == replayed_name(loaded.data["replay"])
    assert given["fidelity"] == "linear"
    assert (place.parent / "calibration-linear.json").exists()
    assert prepared()[0]["calibrations"] == 1


def test_the_planted_material_is_an_option(prepared):
    """A recipe may ask for the material of the world, or state all three; then nothing is calibrated."""
    given, _, _ = prepared(material="planted")
    material = given["options"].material
    assert material.youngs_modulus != 8.5e5
    assert given["options"].offsets == {}
    assert given["options"].name == "low-linear"
    given, _, _ = prepared(youngs_modulus=9e5, poisson_ratio=0.48, friction=0.7)
    assert given["options"].material.friction == 0.7
    assert given["options"].name == "low-linear"
    assert given["calibrations"] == 0


def test_a_stated_parameter_goes_before_the_calibrated_one(prepared):
    """What a recipe states holds; the rest is calibrated."""
    given, _, _ = prepared(friction=0.9)
    assert given["options"].material.friction == 0.9
    assert given["options"].material.poisson_ratio == 0.47

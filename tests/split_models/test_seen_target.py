"""A transfer to a sensor that the store or the model has seen says so; one to an unseen sensor says nothing."""

import json
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml
from cli.command import run_command
from copied_trees import copy_tree
from small_models import image_vae
from touch_world import UNSEEN, tiny_recipe

from split_models.learning.checkpoint import Checkpoint, TrainedOn, load_checkpoint, save_checkpoint
from split_models.networks.learned_backgrounds import kept_small
from split_models.recipe.recipe import load_recipe
from split_models.recipe.recipe_run import RecipeRun
from split_models.transfer.methods import BUNDLED_MODEL
from tactiledata.sensors.backgrounds import ALIASES, load_background
from tactiledata.sensors.same_sensor import is_same_sensor
from tactiledata.store.read.seen_target import target_findings
from tactiledata.store.read.targets import Target

BOTH = ("D20001", "D20002")


class Sensors:
    """A store of sensors with these pictures without contact."""

    def __init__(self, **pictures):
        self.pictures = pictures

    def references(self):
        return {name: type("Kept", (), {"image": picture}) for name, picture in self.pictures.items()}


STORE = Sensors(D1=load_background("digit-bg-3"), D2=load_background("digit-bg-9"))
LEARNED = kept_small([("D7", load_background("digit-bg-6")), ("D8", load_background("digit-bg-7"))])


def noisy(name):
    picture = load_background(name)
    return np.clip(picture + np.random.default_rng(0).normal(2, 4, picture.shape), 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("name", "picture", "sources", "codes"),
    [
        ("new", "digit-bg-12", ["D1", "D2"], []),
        ("new", "digit-bg-3", ["D1"], ["target-in-store"]),
        ("new", "digit-bg-9", ["D1"], ["target-in-store"]),  # the store has it, although its touches are left out
        ("D2", "digit-bg-9", ["D1"], []),  # asked for by its name
        ("D2", "digit-bg-9", ["D1", "D2"], ["target-in-store"]),  # its own touches are transferred to it
        ("new", "digit-bg-7", ["D1"], ["target-in-training"]),
    ],
)
def test_who_has_seen_a_target_by_its_pixels(name, picture, sources, codes):
    """Whatever a target is called, a near copy of a picture of the store or of the training is found, and no other."""
    found = target_findings(Target(name, noisy(picture), ""), STORE, sources, LEARNED)
    assert [finding.code for finding in found] == codes
    assert all(finding.severity == "warning" for finding in found)


def test_a_model_that_does_not_say_is_no_unseen_one():
    """An old checkpoint names no sensors: that is said, and nothing is said where there is no model."""
    target = Target("new", noisy("digit-bg-12"), "")
    assert [finding.code for finding in target_findings(target, STORE, ["D1"], ())] == ["model-sensors-unknown"]
    assert target_findings(target, STORE, ["D1"], None) == []


@pytest.mark.slow
def test_the_command_says_it(short_store, tmp_path, monkeypatch, capsys):
    """The verb prints the warning, and its document has it; to ycb-sensorA it has none to give."""
    copy_tree(short_store, tmp_path / "ds.zarr")
    monkeypatch.chdir(tmp_path)
    typed = ("transfer", "--method", "background-swap", "--to")
    code, out, _ = run_command(capsys, *typed, "digit-bg-12")
    assert code == 0
    assert "that of D20001 of this store" in " ".join(out.split())
    code, out, _ = run_command(capsys, *typed, "digit-bg-12", "--json")
    assert [finding["code"] for finding in json.loads(out)["findings"]] == ["target-in-store"]
    code, out, _ = run_command(capsys, *typed, "ycb-sensorA", "--json")
    assert json.loads(out)["findings"] == []


def test_a_checkpoint_keeps_what_it_learned_from(tmp_path):
    """Names and small pictures come back from the file, in their order, two of one name too."""
    vae = image_vae()
    vae.learned_from = kept_small([("D/1", load_background("digit-bg-6")), ("D/1", load_background("digit-bg-7"))])
    save_checkpoint(tmp_path / "vae.ckpt", Checkpoint.of(vae, TrainedOn()))
    kept = load_checkpoint(tmp_path / "vae.ckpt").network().learned_from
    assert [name for name, _ in kept] == ["D/1", "D/1"]
    np.testing.assert_array_equal([picture for _, picture in kept], [picture for _, picture in vae.learned_from])


def test_the_bundled_model_has_not_seen_the_targets():
    """It knows the fourteen sensors that its recipe names, and neither ycb-sensorA nor ycb-sensorB is one of them."""
    root = Path(__file__).parents[2]
    learned = load_checkpoint(BUNDLED_MODEL).network().learned_from
    world = yaml.safe_load((root / "recipes/worlds/split_small.yaml").read_text())["sensors"]
    recipe = load_recipe(root / "recipes/split_backbone.yaml", "small")
    lit = recipe.models["image_vae"]["relighting"]["backgrounds"]
    held_out = recipe.data["split"]["hold_out"]["sensor"]
    expected = {**{serial: unit["background"] for serial, unit in world.items() if serial not in held_out}}
    expected |= dict(zip(lit, lit, strict=True))
    assert [name for name, _ in learned] == list(expected)
    assert all(is_same_sensor(picture, load_background(expected[name])) for name, picture in learned)
    assert not any(is_same_sensor(picture, load_background(target)) for _, picture in learned for target in ALIASES)


@pytest.mark.slow
def test_training_keeps_the_sensors_of_the_train_part(tmp_path, touch_store):
    """Units of the train part and the lights of the recipe are kept in the checkpoint; the held-out unit is not."""
    relighting = {"relit": 0.5, "exchanged": 0.5, "contact_weight": 4.0, "backgrounds": ["digit-bg-5"]}
    document = tiny_recipe(touch_store, "digit_images")
    variants = {"relit": {"image_vae": {"learns_on": True, "relighting": relighting}}}
    (tmp_path / "recipe.yaml").write_text(yaml.safe_dump({**document, "variants": variants}))
    shop = RecipeRun(load_recipe(tmp_path / "recipe.yaml"), tmp_path / "out", torch.device("cpu"))
    plain, relit = (
        load_checkpoint(Path(some.kept.folders["image_vae"]) / "best.pt").network()
        for some in (shop, shop.variant("relit"))
        if some.image_vae is not None
    )
    assert {name for name, _ in plain.learned_from} == set(BOTH)
    assert {name for name, _ in relit.learned_from} == {*BOTH, "digit-bg-5"}
    assert UNSEEN not in BOTH

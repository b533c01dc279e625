"""Every network at the paper's sizes learns for two steps on a processor."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import torch
from touch_world import coarse_replay, scenario

from split_models.learning.train import _Loop
from split_models.methods.cycle import cycle_pair
from split_models.methods.zhu_row import zhu
from split_models.recipe.recipe import laid_over, load_recipe
from split_models.recipe.recipe_run import RecipeRun
from tactiledata.ingest.pipeline import ingest
from tactiledata.replay.attach import replay
from tactiledata.rig.record import record
from tactiledata.splits.make import make_split
from tactiledata.store.read.reader import Store

STEPS = 2
FORCE = (2.5, 13.0)


@pytest.fixture(scope="module")
def paper_store(tmp_path_factory):
    """A few touches with meshes of the pad's whole volume; of so few, a seed is sought that fills every part."""
    place = tmp_path_factory.mktemp("paper") / "ds.zarr"
    world = scenario()
    ingest(record(world, place.parent / "recordings", "mcap"), place)
    replay(place, coarse_replay(keep="all"))
    split = partial(
        make_split, Store.open(place), by="trajectory", hold_out="none", fractions=(0.25, 0.25, 0.5), force=FORCE,
        replace=True,
    )  # fmt: skip
    found = [split(seed=seed).counts for seed in range(40)]
    frames = [(counts["train"].frames, counts["val"].frames) for counts in found]
    # both steps of two pieces each, and no more pictures than that takes
    split(seed=min(range(40), key=lambda seed: (min(frames[seed]) < 2 * STEPS, sum(frames[seed]))))
    return place


@pytest.mark.nightly
def test_every_network_takes_two_steps_at_paper_scale(paper_store, tmp_path, monkeypatch):
    """Sizes and losses are those of ``--scale paper``; the batches of what little there is come in two pieces each."""
    recipe = load_recipe("split_backbone", "paper")
    counted = len(_frames(recipe, paper_store, tmp_path))
    batch = -(-counted // STEPS)
    training = {"epochs": 1, "batch_size": batch, "patience": 0, "accumulate": 2}
    models = {
        name: {
            **section,
            "training": {**section["training"], **training},
            **({"background_copies": 0} if name == "image_vae" else {}),
        }
        for name, section in recipe.models.items()
        if isinstance(section, dict)
    }
    run = RecipeRun(_on(recipe, paper_store, models), tmp_path, torch.device("cpu"))
    steps = {}
    taken = _Loop._step

    def step(loop, *given):
        steps[loop.folder.name.rpartition("-")[0]] = steps.get(loop.folder.name.rpartition("-")[0], 0) + 1
        return taken(loop, *given)

    monkeypatch.setattr(_Loop, "_step", step)
    assert run.image_vae.size == (320, 240)
    assert run.image_vae.latent == 256
    assert run.mesh_vae.latent == 128
    assert run.end_to_end.size == (320, 240)
    for direction in ("mesh_to_image", "image_to_mesh"):
        for is_split in (True, False):
            run.projection(direction, is_split)
    run.force_head("deformation", 0)
    run.raw_forces("mesh", 0)
    run.raw_forces("image", 0)
    cycle_pair(run, learns_own=True)
    zhu(run)
    assert len(steps) == 12
    assert set(steps.values()) == {STEPS}
    for folder in run.kept.folders.values():
        losses = np.genfromtxt(f"{folder}/curve.csv", delimiter=",", names=True)
        assert np.isfinite(losses["train_loss"]), folder
        assert np.isfinite(losses["val_loss"]), folder


def _on(recipe, store, models=None):
    """The recipe on another store and split; all else stays as it is."""
    data = {"store": str(store), "world": None, "split": {"name": "default", "make": False}}
    return replace(recipe, document=laid_over(recipe.document, {"data": data, "models": models or {}}))


def _frames(recipe, store, folder):
    """Frames of the train part at the recipe's size."""
    return RecipeRun(_on(recipe, store), folder, torch.device("cpu")).frames("train")

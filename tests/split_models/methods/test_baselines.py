"""Rows that need no learning of pictures: what they are built from, and what units are calibrated on."""

import numpy as np
import pytest
import torch
import yaml
from touch_world import UNSEEN, tiny_recipe

from split_models.methods.baselines import PerUnit, unit_touches
from split_models.methods.methods import IMAGE_TO_MESH, MESH_TO_IMAGE, TITLES
from split_models.methods.optical_method import surface_of
from split_models.recipe.recipe import load_recipe
from split_models.recipe.recipe_run import RecipeRun
from split_models.tables.evaluate import image_values
from tactiledata.errors import UsageError

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def recipe_run(touch_store, tmp_path_factory):
    folder = tmp_path_factory.mktemp("baselines")
    path = folder / "r.yaml"
    path.write_text(yaml.safe_dump(tiny_recipe(touch_store, "digit_images")))
    return RecipeRun(load_recipe(path), folder / "out", torch.device("cpu"))


def test_every_row_has_a_title_and_is_there():
    """Names of both registries import, and people can read them."""
    for table in (MESH_TO_IMAGE, IMAGE_TO_MESH):
        for name in table:
            assert callable(table[name])
            assert name in TITLES


def test_touches_of_a_unit_are_its_own(recipe_run):
    """One of each of its trajectories, the deepest; a held-out unit's come from the part that it is in."""
    frames = recipe_run.frames("train")
    sensor = frames.sensor_names[0]
    touches = unit_touches(recipe_run, sensor)
    mine = frames.sensors == sensor
    assert len(touches) == len(set(frames.trajectories[mine]))
    depths = [np.linalg.norm(touch.displacement, axis=1).max() for touch in touches]
    first = np.flatnonzero(mine & (frames.trajectories == frames.trajectories[mine][0]))
    assert depths[0] == pytest.approx(np.linalg.norm(frames.displacements(first), axis=2).max())
    assert len(unit_touches(recipe_run, UNSEEN)) == len(set(recipe_run.frames("test_unseen").trajectories))
    with pytest.raises(UsageError, match="no frame of sensor 'D9'"):
        unit_touches(recipe_run, "D9")


def test_published_methods_draw_the_touch(recipe_run):
    """Taxim's picture differs from the background, most of all inside the contact; its row is scored."""
    method = MESH_TO_IMAGE["taxim_published"](recipe_run)
    frames = recipe_run.frames("test")
    sensor = frames.sensors[0]
    found = method.predict(frames.displacements([0]), frames.background(sensor))
    assert found.shape == (1, 40, 30, 3)
    assert np.abs(found[0].astype(float) - frames.background(sensor)).max() > 5
    values = image_values(method, frames, ["l1"])
    assert np.isfinite(values["l1"]).all()


def test_units_are_calibrated_once_each(recipe_run, monkeypatch):
    """Each unit is calibrated once, on its own touches, through its own registered view."""
    calls = []

    class Found:
        view = "view"

    monkeypatch.setattr("split_models.methods.baselines.register", lambda surface, touches, start: Found())

    def calibrate(surface, view, touches):
        calls.append((view, len(touches)))
        return "method"

    method = PerUnit("own", recipe_run, calibrate)
    sensor = recipe_run.frames("train").sensor_names[0]
    assert method.for_sensor(sensor) == method.for_sensor(sensor) == "method"
    assert calls == [("view", len(unit_touches(recipe_run, sensor)))]
    with pytest.raises(UsageError, match="without a unit"):
        method.predict(None, None)
    assert surface_of(recipe_run).places.shape == (recipe_run.topology.n_vertices, 3)

"""Zhu et al. 2022: the rendering is right and differentiable, the network learns, and adapts without truth."""

import numpy as np
import pytest
import torch
import yaml
from small_models import grid_topology, presses
from touch_world import tiny_recipe

from split_models.methods.depth_rendering import DepthRenderer
from split_models.methods.methods import IMAGE_TO_MESH
from split_models.methods.zhu import ZhuMethod, ZhuNetwork, ZhuObjective, imprints_of
from split_models.networks.mesh_graph import build_hierarchy
from split_models.recipe.recipe import load_recipe
from split_models.recipe.recipe_run import RecipeRun
from tactiledata.errors import UsageError
from tactiledata.optics.height_map import Indentation
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View
from tactiledata.sensors.digit import DIGIT

pytestmark = pytest.mark.slow

TOPOLOGY = grid_topology(23, 18, 0.001, dome=2.0)
SURFACE = GelSurface(TOPOLOGY.places, TOPOLOGY.faces)
VIEW = View.nominal(DIGIT, (40, 30))


@pytest.fixture(scope="module")
def renderer():
    return DepthRenderer(SURFACE, VIEW)


def network(**changes):
    torch.manual_seed(0)
    sizes = {"size": (40, 30), "channels": (8, 16, 16), "filters": (8, 8, 8, 16), "order": 3}
    spread = np.full((len(TOPOLOGY.places), 3), 1e-4)
    return ZhuNetwork(build_hierarchy(TOPOLOGY), **{**sizes, "spread": spread, **changes})


def test_it_renders_what_the_rasteriser_draws(renderer):
    """A domed gel whose nodes move sideways by 0.8 mm, too, is drawn within 5 % of the depth, at pixels of 0.5 mm."""
    moved = presses(TOPOLOGY, 3)
    moved[..., 0] += 8e-4
    exact = Indentation(SURFACE, VIEW).of_batch(moved)[:, :, 4:-4]
    ours = renderer(torch.from_numpy(moved))[:, 0, :, 4:-4].numpy()
    assert np.abs(ours - exact).max() < 0.05 * exact.max()
    upright = moved * np.array([0, 0, 1], np.float32)
    assert np.abs(renderer(torch.from_numpy(upright))[:, 0, :, 4:-4].numpy() - exact).max() > 0.2 * exact.max()


def test_gradients_are_those_of_finite_differences(renderer):
    """The gradients of an imprint's sum are those of finite differences in single components of single nodes."""
    moved = torch.from_numpy(presses(TOPOLOGY, 1)).double().requires_grad_()
    twice = DepthRenderer(SURFACE, VIEW)
    gain = torch.tensor(1.5)

    def total(values):
        return twice.imprint(values.float(), gain).double().square().sum()

    total(moved).backward()
    deepest = int(moved.detach()[0, :, 2].argmin())
    for component in range(3):
        step = torch.zeros_like(moved)
        step[0, deepest - 1, component] = 2e-6
        expected = (total(moved.detach() + step) - total(moved.detach() - step)) / 4e-6
        assert float(moved.grad[0, deepest - 1, component]) == pytest.approx(float(expected), rel=0.1, abs=2.0)


def learned(objective, batch, steps, rate=3e-3):
    optimizer = torch.optim.Adam(objective.network.parameters(), rate)
    objective.train()
    for _ in range(steps):
        losses = objective(batch, 100.0)
        optimizer.zero_grad()
        losses["loss"].backward()
        optimizer.step()
    objective.eval()
    with torch.no_grad():
        return {name: float(value) for name, value in objective(batch, 100.0).items()}


def test_it_learns_meshes_from_imprints(renderer):
    """Eight samples are learned: the error falls below a tenth of what an undeformed mesh has."""
    moved = torch.from_numpy(presses(TOPOLOGY, 8))
    objective = ZhuObjective(network(), renderer, 0.0, 1)
    batch = {"mesh": moved, "imprint": renderer.imprint(moved, torch.tensor(1.5))}
    rest = float((moved / 1e-4).square().mean())
    assert learned(objective, batch, 150)["error"] < 0.1 * rest


def test_it_adapts_to_pictures_without_their_meshes(renderer):
    """Re-rendering alone, without a single true mesh of the pictures, brings the meshes nearer to the truth."""
    seen, unseen = (torch.from_numpy(presses(TOPOLOGY, 8, seed=seed)) for seed in (0, 5))
    shown = renderer.imprint(unseen, torch.tensor(1.5))
    errors = []
    for weight in (0.0, 30.0):
        objective = ZhuObjective(network(), renderer, weight, 1)
        learned(objective, {"mesh": seen, "imprint": shown}, 120)
        with torch.no_grad():
            found = renderer(objective.zhu(shown))
        errors.append(float((found - renderer(unseen)).abs().mean()))
    assert errors[1] < 0.8 * errors[0]


def test_it_goes_into_a_checkpoint_and_back():
    """Rebuilt from settings, extras and weights it answers the same."""
    one = network().eval()
    other = ZhuNetwork.rebuilt(one.settings, one.extras(), one.topology)
    other.load_state_dict(one.state_dict())
    pictures = np.random.default_rng(0).integers(0, 255, (3, 80, 60, 3)).astype(np.uint8)
    found = ZhuMethod(one).predict(pictures, pictures[0])
    assert found.shape == (3, len(TOPOLOGY.places), 3)
    np.testing.assert_array_equal(found, ZhuMethod(other).predict(pictures, pictures[0]))


def test_imprints_show_where_a_picture_changed():
    """An imprint is 0 for the background and between 0 and 1 where a picture changed; it has one shape only."""
    background = np.full((80, 60, 3), 100, np.uint8)
    picture = background.copy()
    picture[20:40, 20:40, 0] = 220
    picture[50:60, 10:20, 2] = 10
    imprint = imprints_of(np.stack([background, picture]), background, (40, 30))
    assert float(imprint[0].max()) == 0
    assert 0.7 < float(imprint[1, 0, 15, 15]) <= 1
    assert 0.5 < float(imprint[1, 0, 27, 7]) <= 1
    assert float(imprint[1, 0, 2, 2]) < 1e-3
    with pytest.raises(UsageError, match="one shape"):
        imprints_of(picture[None], background[:40], (40, 30))


def test_it_is_a_row_of_the_mesh_table(touch_store, tmp_path):
    """A recipe trains it once, keeps it, and reads it again."""
    recipe = tiny_recipe(touch_store, "mesh")
    tiny = {"size": [40, 30], "channels": [4, 8], "anneal": 1, "training": {"epochs": 2, "batch_size": 16}}
    recipe["models"] = {**recipe["models"], "zhu": tiny}
    (tmp_path / "r.yaml").write_text(yaml.safe_dump(recipe))
    found = []
    for may_train in (True, False):
        bench = RecipeRun(load_recipe(tmp_path / "r.yaml"), tmp_path / "out", torch.device("cpu"), may_train=may_train)
        frames = bench.frames("test")
        method = IMAGE_TO_MESH["zhu"](bench)
        found.append(method.predict(frames.pictures([0, 1]), frames.background(frames.sensors[0])))
    assert found[0].shape == frames.displacements([0, 1]).shape
    np.testing.assert_array_equal(*found)

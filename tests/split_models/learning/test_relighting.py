"""Training on the arithmetic: pictures under other light, latent vectors that exchange their backgrounds."""

import numpy as np
import pytest
import torch
import yaml
from small_models import image_vae, pictures
from touch_world import UNSEEN, tiny_recipe

from split_models.learning.augment import Augmentation
from split_models.learning.objectives import ImageVaeObjective, gradient_error
from split_models.learning.relighting import ArithmeticVaeObjective, relight
from split_models.methods.methods import mesh_to_image, title_of
from split_models.recipe.image_vae_recipe import image_vae_objective
from split_models.recipe.recipe import load_recipe
from split_models.recipe.recipe_run import RecipeRun
from tactiledata.errors import UnknownName, UsageError


@pytest.fixture
def lights():
    fading = np.linspace(1.0, 0.6, 40)[None, :, None, None]
    colours = np.array([[180, 60, 60], [60, 180, 60], [60, 60, 180]])[:, None, None, :]
    return np.broadcast_to(fading * colours, (3, 40, 30, 3)).astype(np.uint8)


def as_planes(pictures):
    return torch.as_tensor(pictures).permute(0, 3, 1, 2).float()


def test_the_own_light_changes_nothing(lights):
    """Bit for bit; and pictures of sensors without a background stay as they are."""
    shown, own = as_planes(pictures(3)), torch.tensor([0, 1, -1])
    assert torch.equal(relight(shown, as_planes(lights), own, own), shown)


def test_a_ratio_of_light_is_moved_exactly(lights):
    """What a touch makes of one background by a factor, it makes of the other by the same."""
    bases = as_planes(lights)
    factor = torch.linspace(0.5, 1.2, 30)
    touched = (bases[:1] + 1) * factor - 1
    moved = relight(touched, bases, torch.tensor([0]), torch.tensor([2]))
    assert torch.allclose(moved, touched * (bases[2:] + 1) / (bases[:1] + 1))
    assert torch.allclose(moved + factor * 0 + 1, (bases[2:] + 1) * factor, atol=6.0)


def test_backgrounds_become_one_another(lights):
    """A background under another light is that other background, to the one level that keeps it from zero."""
    bases = as_planes(lights)
    moved = relight(bases[:1], bases, torch.tensor([0]), torch.tensor([1]))
    assert (moved - bases[1:2]).abs().max() < 5.0


def objective(lights, relit, exchanged, noise=0.0):
    torch.manual_seed(0)
    return ArithmeticVaeObjective(image_vae(), 0.0, 0, Augmentation(noise=noise), lights, relit, exchanged)


def test_nothing_exchanged_is_the_plain_vae(lights):
    """With a latent vector whose spread is nothing, the loss is that of the plain reconstruction."""
    plain = objective(lights, 0.0, 0.0)
    torch.nn.init.zeros_(plain.vae.to_log_variance.weight)
    torch.nn.init.constant_(plain.vae.to_log_variance.bias, -60.0)
    batch = {"image": torch.as_tensor(pictures(6)), "sensor": torch.tensor([0, 1, 2, 0, 1, -1])}
    learning = plain.train()(batch, 0.0)["error"]
    assert torch.allclose(learning, plain.eval()(batch, 0.0)["error"], rtol=1e-4)


def test_touches_weigh_more():
    """Errors inside the touch count as often as was asked, those outside once."""
    base = np.full((1, 40, 30, 3), 100, np.uint8)
    touched = base.copy()
    touched[:, 10:20, 10:20] += 60
    torch.manual_seed(0)
    weighted = ArithmeticVaeObjective(image_vae(), 0.0, 0, Augmentation(), base, 0.0, 0.0, contact_weight=4.0)
    planes = as_planes(touched)
    emphasis = weighted._emphasis(planes, as_planes(base), torch.tensor([0]))[0, 0]
    assert (emphasis[12:18, 12:18] == 5.0).all()
    assert (emphasis[30:] == 1.0).all()
    assert (weighted._emphasis(planes, as_planes(base), torch.tensor([-1])) == 1.0).all()


def test_errors_of_gradients_by_hand():
    """`gradient_error` returns the value computed by hand for four pixels, without and with factors on errors."""
    difference = torch.zeros(1, 3, 2, 2)
    difference[0, :, 0] = torch.tensor([3.0, 1.0])
    # along: 2 and 0 in each channel; down: 3 and 1
    assert gradient_error(difference).item() == pytest.approx((2 + 0) / 2 + (3 + 1) / 2)
    emphasis = torch.tensor([[[[1.0, 5.0], [1.0, 7.0]]]])
    assert gradient_error(difference, emphasis).item() == pytest.approx((5 * 2 + 0) / 2 + (1 * 3 + 7 * 1) / 2)
    assert gradient_error(torch.full((1, 3, 4, 5), 0.7)).item() == pytest.approx(0.0)


def test_gradients_count_as_often_as_asked(lights):
    """The loss rises by the weight times the error of gradients, in training's validation as well; 0 adds nothing."""
    batch = {"image": torch.as_tensor(lights), "sensor": torch.arange(3)}
    losses = {}
    for weight in (0.0, 0.5, 1.0):
        torch.manual_seed(3)
        learner = ArithmeticVaeObjective(
            image_vae(), 0.0, 0, Augmentation(), lights, 1.0, 1.0, contact_weight=4.0, gradient_weight=weight
        )
        losses[weight] = []
        for mode in (learner.train(), learner.eval()):
            torch.manual_seed(4)
            losses[weight].append(mode(batch, 0.0)["loss"].item())
    for none, half, whole in zip(*losses.values(), strict=True):
        assert half > none
        assert whole - none == pytest.approx(2 * (half - none), rel=1e-4)


@pytest.mark.slow
def test_exchanging_is_learned_from_backgrounds_alone(lights):
    """After some steps, arithmetic between two backgrounds decodes to the other one."""
    learner = objective(lights, 1.0, 1.0)
    batch = {"image": torch.as_tensor(lights), "sensor": torch.arange(3)}
    optimiser = torch.optim.Adam(learner.parameters(), lr=3e-3)
    losses = []
    for _ in range(40):
        loss = learner.train()(batch, 0.0)["loss"]
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        losses.append(loss.item())
    assert np.mean(losses[-5:]) < 0.5 * np.mean(losses[:5])


def recipe_run(folder, store, backgrounds):
    relighting = {"relit": 0.5, "exchanged": 0.5, "contact_weight": 4.0, "backgrounds": backgrounds}
    variants = {"relit": {"image_vae": {"learns_on": True, "relighting": relighting}}}
    document = {**tiny_recipe(store, "digit_images"), "variants": variants}
    path = folder / "recipe.yaml"
    path.write_text(yaml.safe_dump(document))
    return RecipeRun(load_recipe(path), folder / "out", torch.device("cpu"))


@pytest.mark.slow
def test_a_recipe_trains_a_variant(tmp_path, touch_store):
    """Rows of a variant are made with its own image VAE and the mesh VAE of all."""
    plain = recipe_run(tmp_path, touch_store, ["digit-bg-5"])
    row = mesh_to_image(plain, "relit:split")
    assert title_of("relit:split") == "SPLIT, relit"
    other = plain.variant("relit")
    assert row.image_vae is other.image_vae is not plain.image_vae
    assert other.kept.keys["image_vae"] != plain.kept.keys["image_vae"]
    assert plain.mesh_vae is not None
    assert other.kept.folders["mesh_vae"] == plain.kept.folders["mesh_vae"]
    with pytest.raises(UnknownName, match="relit"):
        plain.variant("relight")


@pytest.mark.slow
def test_light_of_a_unit_that_is_tested_on_is_refused(tmp_path, touch_store):
    """The background of the held-out unit, by the name of the bundled picture."""
    learning = recipe_run(tmp_path, touch_store, ["digit-bg-14"]).variant("relit")
    with pytest.raises(UsageError, match=f"{UNSEEN}, which is held out"):
        learning.image_vae  # noqa: B018


@pytest.mark.slow
@pytest.mark.parametrize("name", ["contact_weight", "gradient_weight"])
@pytest.mark.parametrize(("weight", "kind"), [(4.0, ArithmeticVaeObjective), (0.0, ImageVaeObjective)])
def test_a_weight_counts_alone(tmp_path, touch_store, name, weight, kind):
    """A recipe that relights nothing may still weigh touches, or edges."""
    relighting = {"relit": 0.0, "exchanged": 0.0, name: weight, "backgrounds": []}
    path = tmp_path / "recipe.yaml"
    document = tiny_recipe(touch_store, "digit_images")
    path.write_text(yaml.safe_dump({**document, "variants": {"other": {"image_vae": {"relighting": relighting}}}}))
    shop = RecipeRun(load_recipe(path), tmp_path / "out", torch.device("cpu")).variant("other")
    objective = image_vae_objective(shop.recipe.models["image_vae"], shop.frames("train"))
    assert type(objective) is kind
    assert getattr(objective, name, 0.0) == weight

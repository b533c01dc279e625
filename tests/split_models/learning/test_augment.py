"""Changed pictures obey the laws of what changed them."""

import math

import pytest
import torch
from small_models import image_vae, mesh_vae, pictures

from split_models.learning.augment import Augmentation, turned
from split_models.learning.objectives import ImageVaeObjective, MeshVaeObjective
from split_models.networks.image_vae import as_input


@pytest.fixture
def shown():
    return as_input(torch.as_tensor(pictures(6)))


def test_nothing_asked_changes_nothing(shown):
    """What is given and what is wanted are the pictures themselves."""
    given, wanted = Augmentation().changed(shown)
    assert torch.equal(given, shown)
    assert torch.equal(wanted, shown)


def test_half_a_turn_mirrors_both_axes(shown):
    """Half a turn mirrors both axes, no turn is the identity, and a turn and its opposite nearly so in the middle."""
    half = torch.full((6,), math.pi)
    assert torch.allclose(turned(shown, half), shown.flip(2, 3), atol=1e-3)
    assert torch.allclose(turned(shown, half * 0), shown, atol=1e-5)
    small = torch.full((6,), 0.1)
    back = turned(turned(shown, small), -small)
    assert (back - shown)[:, :, 10:30, 8:22].abs().max() < 0.1


def test_a_turn_keeps_distances():
    """A spot stays as far from the middle, in pixels, though the picture is no square."""
    spot = torch.zeros(1, 3, 41, 31)
    spot[:, :, 20, 25] = 1.0
    moved = turned(spot, torch.tensor([math.pi / 2]))[0, 0]
    row, column = divmod(int(moved.argmax()), 31)
    assert {(row, column)} <= {(30, 15), (10, 15)}


def test_noise_is_given_and_not_wanted(shown):
    """Pictures stay in [-1, 1]; the same seed gives the same."""
    way = Augmentation(rotation=0.1, flip=0.5, noise=0.05, contrast=0.2, brightness=0.2)
    torch.manual_seed(3)
    given, wanted = way.changed(shown)
    torch.manual_seed(3)
    assert torch.equal(way.changed(shown)[0], given)
    assert given.abs().max() <= 1.0
    assert 0.02 < (given - wanted).std() < 0.08
    assert not torch.equal(wanted, shown)


def test_flips_are_whole(shown):
    """At chance 1 along both axes every picture is mirrored twice."""
    assert torch.equal(Augmentation(flip=1.0).changed(shown)[1], shown.flip(2, 3))


def test_validation_is_not_random(shown):
    """In evaluation nothing is drawn and the divergence has its final weight; in training it grows from 0."""
    batch = {"image": torch.as_tensor(pictures(6))}
    objective = ImageVaeObjective(image_vae(), 0.5, 10, Augmentation(noise=0.1))
    objective.eval()
    first, second = objective(batch, 0.0), objective(batch, 7.0)
    assert torch.equal(first["loss"], second["loss"])
    assert torch.allclose(first["loss"], first["error"] + 0.5 * first["divergence"])
    objective.train()
    begun = objective(batch, 0.0)
    assert torch.equal(begun["loss"], begun["error"])
    halfway = objective(batch, 5.0)
    assert torch.allclose(halfway["loss"], halfway["error"] + 0.25 * halfway["divergence"])


def test_meshes_are_compared_scaled():
    """The error is that of displacements with mean 0 and spread 1 at every vertex."""
    vae = mesh_vae()
    vae.mean.fill_(0.5)
    vae.spread.fill_(2.0)
    objective = MeshVaeObjective(vae, 0.0).eval()
    moved = torch.randn(3, 204, 3)
    expected = (vae(moved)[0] - (moved - 0.5) / 2.0).square().mean()
    assert torch.allclose(objective({"mesh": moved}, 0.0)["loss"], expected)

"""Objectives of small networks whose losses are worked out by hand."""

import math

import pytest
import torch
from torch import nn

from split_models.learning.augment import Augmentation
from split_models.learning.objectives import ImageVaeObjective, MeshVaeObjective, Regression, vae_losses
from split_models.networks.latent_normal import annealed

WHITE = torch.full((2, 4, 4, 3), 255, dtype=torch.uint8)
"""Two white pictures: 1 everywhere, as the network takes them."""


class Constant(nn.Module):
    """A VAE that gives back half of what it is given, with a mean of 2 and a variance of 1: a divergence of 2 nat."""

    def __init__(self):
        super().__init__()
        self.given = []

    def forward(self, given):
        self.given.append(given)
        latent = torch.full((len(given), 5), 2.0)
        return given / 2, latent, 0 * latent

    def scaled(self, moved):
        return 10 * moved


class Darker:
    """An augmentation that gives the network 0 and wants -1."""

    def changed(self, pictures):
        return 0 * pictures, 0 * pictures - 1


def numbers(losses):
    return {name: value.item() for name, value in losses.items()}


def test_a_beta_vae_by_hand():
    """Squared errors 4 and 16 of mean 10, a divergence of (4 - 1 - ln 4 + 9) / 2 nat, weighed by 0.5."""
    output = (torch.tensor([[1.0], [6.0]]), torch.full((2, 1), 3.0), torch.full((2, 1), math.log(4.0)))
    found = vae_losses(output, torch.tensor([[3.0], [2.0]]), 0.5)
    spread = (4 - 1 - math.log(4) + 9) / 2
    assert numbers(found) == pytest.approx({"loss": 10 + 0.5 * spread, "error": 10.0, "divergence": spread})
    assert not found["error"].requires_grad


def test_emphasis_multiplies_the_squared_errors():
    """Factors of 3 and 0.5 on errors of 4 and 16 give (12 + 8) / 2."""
    output = (torch.tensor([[1.0], [6.0]]), torch.zeros(2, 1), torch.zeros(2, 1))
    found = vae_losses(output, torch.tensor([[3.0], [2.0]]), 7.0, torch.tensor([[3.0], [0.5]]))
    assert numbers(found) == pytest.approx({"loss": 10.0, "error": 10.0, "divergence": 0.0})


def test_gradients_of_the_difference_count_by_their_weight():
    """A ramp of 1, 3 wanted and 2, 7 drawn: squares (1 + 16) / 2, and 5 times the one step of 3 along the row."""
    drawn, wanted = torch.tensor([[[[2.0, 7.0]]]]), torch.tensor([[[[1.0, 3.0]]]])
    nothing = torch.zeros(1, 2)
    two_rows = [torch.cat([row, row], dim=-2) for row in (drawn, wanted)]
    losses = vae_losses((two_rows[0], nothing, nothing), two_rows[1], 0.0, gradient_weight=5.0)
    assert losses["loss"].item() == pytest.approx(8.5 + 5 * 3)


def test_only_the_loss_has_a_gradient():
    """Its parts are for tables: nothing is learned from them."""
    mean = torch.ones(2, 1, requires_grad=True)
    found = vae_losses((mean, mean, mean), torch.zeros(2, 1), 1.0)
    assert [found[name].requires_grad for name in ("loss", "error", "divergence")] == [True, False, False]


def test_pictures_are_augmented_and_the_weight_annealed_in_training_alone():
    """After half of the annealing: changed pictures in training, else the pictures as they are and the whole weight."""
    vae = Constant()
    objective = ImageVaeObjective(vae, 0.3, 4, Darker())
    # 0 / 2 against -1 is an error of 1; the divergence is 2 nat, half of 0.3 its weight
    assert numbers(objective.train()({"image": WHITE}, 2.0)) == pytest.approx(
        {"loss": 1 + 0.15 * 2, "error": 1.0, "divergence": 2.0}
    )
    # 1 / 2 against 1
    assert numbers(objective.eval()({"image": WHITE}, 2.0)) == pytest.approx(
        {"loss": 0.25 + 0.3 * 2, "error": 0.25, "divergence": 2.0}
    )
    assert [given.unique().tolist() for given in vae.given] == [[0.0], [1.0]]


def test_noise_is_given_and_not_wanted():
    """With noise alone, the goal in training is the picture as it was."""
    grey = torch.full((2, 4, 4, 3), 64, dtype=torch.uint8)
    vae = Constant()
    ImageVaeObjective(vae, 0.0, 0, Augmentation(noise=0.1)).train()({"image": grey}, 0.0)
    assert vae.given[0].std() == pytest.approx(0.1, rel=0.3)


@pytest.mark.parametrize("is_training", [True, False])
def test_a_mesh_is_compared_in_the_networks_scale(is_training):
    """Displacements of 2 m are 20 in the scale and come back as 1: an error of 361, with the whole weight."""
    objective = MeshVaeObjective(Constant(), 0.3).train(is_training)
    found = objective({"mesh": torch.full((2, 6, 3), 2.0)}, 0.0)
    assert numbers(found) == pytest.approx({"loss": 361 + 0.6, "error": 361.0, "divergence": 2.0})


@pytest.mark.parametrize(
    ("given", "target", "loss"),
    [
        (None, None, (10 - 4) ** 2),
        (lambda x: x + 1, None, (15 - 4) ** 2),
        (None, lambda x: 3 * x, (10 - 12) ** 2),
        (lambda x: x + 1, lambda x: 3 * x, (15 - 12) ** 2),
    ],
)
def test_a_regression_prepares_what_it_is_told_to(given, target, loss):
    """A network that multiplies by 5, given 2, of which 4 is wanted; each side is prepared on its own."""
    five = nn.Linear(1, 1, bias=False).requires_grad_(False)
    five.weight.fill_(5.0)
    objective = Regression(five, "x", "y", given, target)
    batch = {"x": torch.full((3, 1), 2.0), "y": torch.full((3, 1), 4.0)}
    assert numbers(objective(batch, 0.0)) == pytest.approx({"loss": loss})


@pytest.mark.parametrize("epoch", [0.0, 0.5, 3.0])
@pytest.mark.parametrize("epochs", [0, -1])
def test_without_epochs_of_annealing_the_weight_is_there_at_once(epoch, epochs):
    """No epochs, or fewer: the final weight from the start."""
    assert annealed(0.7, epoch, epochs) == 0.7

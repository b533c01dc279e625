"""The normal distribution of a latent vector in numbers worked out by hand."""

import math

import pytest
import torch
from small_models import grid_topology, mesh_vae, presses

from split_models.learning.objectives import scaled_forces
from split_models.networks.latent_normal import annealed, divergence, draw, drawn_alike


def test_divergence_of_a_wide_normal():
    """Variance 4: (4 - 1 - ln 4) / 2 nat; a mean of 1 adds a half; variance 1/4: (1/4 - 1 + ln 4) / 2."""
    zero, wide = torch.zeros(2, 3), torch.full((2, 3), math.log(4.0))
    assert divergence(zero, wide) == pytest.approx(0.8068528)
    assert divergence(zero + 1.0, wide) == pytest.approx(1.3068528)
    assert divergence(zero, -wide) == pytest.approx(0.3181472)


def test_spread_of_what_is_drawn():
    """Mean 3 and variance 4: of 40,000 samples the mean is 3 and the standard deviation 2."""
    with drawn_alike(0):
        samples = draw(torch.full((40_000, 1), 3.0), torch.full((40_000, 1), math.log(4.0)))
    assert samples.mean() == pytest.approx(3.0, abs=0.05)
    assert samples.std() == pytest.approx(2.0, abs=0.04)


def test_mesh_vae_scales_by_a_mean_that_is_not_zero():
    """Mean 2 and spread 4: 10 is scaled to 2 and back; the network sees and gives back scaled displacements."""
    topology = grid_topology()
    count = len(topology.places)
    with drawn_alike(1):
        plain = mesh_vae(topology).eval()
    moved = mesh_vae(topology, mean=torch.full((count, 3), 2.0), spread=torch.full((count, 3), 4.0)).eval()
    kept = {name: value for name, value in plain.state_dict().items() if name not in ("mean", "spread")}
    moved.load_state_dict(kept, strict=False)
    assert (moved.scaled(torch.full((1, count, 3), 10.0)) == 2.0).all()
    assert (moved.unscaled(torch.full((1, count, 3), 2.0)) == 10.0).all()
    given = torch.from_numpy(1000 * presses(topology, 2))
    torch.testing.assert_close(moved.distribution(4.0 * given + 2.0), plain.distribution(given))
    latent = torch.ones(2, 8)
    torch.testing.assert_close(moved.decode(latent), 4.0 * plain.decode_scaled(latent) + 2.0)


@pytest.mark.parametrize(
    ("epoch", "epochs", "weight"),
    [(0.0, 1, 0.0), (0.25, 1, 0.5), (1.0, 4, 0.5), (4.0, 4, 2.0), (9.0, 4, 2.0), (0.0, 0, 2.0)],
)
def test_the_weight_grows_linearly_and_stays(epoch, epochs, weight):
    """The weight grows from 0 by a quarter of 2 in a quarter of the epochs; over no epochs it is there at once."""
    assert annealed(2.0, epoch, epochs) == weight


def test_forces_are_scaled_to_mean_zero_and_spread_one():
    """By hand: (5 - 2) / 1.5 is 2, (2 - 2) / 1.5 is 0, and (-1 - 3) / 4 is -1."""
    scaled = scaled_forces([2.0, 3.0, 0.0], [1.5, 4.0, 1.0])(torch.tensor([[5.0, -1.0, 7.0], [2.0, 3.0, 0.0]]))
    assert scaled.tolist() == [[2.0, -1.0, 7.0], [0.0, 0.0, 0.0]]

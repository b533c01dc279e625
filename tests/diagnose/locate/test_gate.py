"""The gate opens for structure and for nothing else."""

import numpy as np
import pytest
from planted import modulus_over, planted

from tactiledata.diagnose.locate.gate import NoiseModel, gate
from tactiledata.diagnose.residuals.projection import project
from tactiledata.errors import UsageError


def plain(seed, **options):
    return planted(seed, 20, 10, heavy=False, random_effects=False, **options)


@pytest.mark.slow
def test_noise_alone_passes():
    """5 % alarms where the noise model is right."""
    answers = [gate(project(plain(seed)), NoiseModel(0.5), seed, 99).is_passed for seed in range(60)]
    assert np.mean(answers) >= 0.88


def test_correlation_that_is_not_known_fails():
    """The gate can fail: coloured noise taken for white has structure."""
    answers = [gate(project(plain(seed)), NoiseModel(0.0), seed, 99).is_passed for seed in range(10)]
    assert np.mean(answers) <= 0.3


@pytest.mark.parametrize("share", [0.4, -0.4])
def test_structure_does_not_pass(share):
    """A modulus that changes with depth by 40 %, which a refit absorbs in part."""
    found = gate(project(plain(1, plant=modulus_over("depth", share, 0.2, 1.0))), NoiseModel(0.5))
    assert not found.is_passed
    assert "where up to" in found.words


def test_the_size_of_the_noise_may_be_a_little_wrong():
    """Noise 5 % larger than said is no structure while its size is in doubt; without doubt it is."""
    larger = plain(2).with_values(1.08 * plain(2).values)
    assert gate(project(larger), NoiseModel(0.5, doubt=0.1)).is_passed
    assert gate(project(larger), NoiseModel(0.5, doubt=0.0)).mean_square > 1.08


def test_errors_of_the_simulation_are_no_structure():
    """A difference as between two meshes passes where it is known, and does not where it is not."""
    world = plain(3, correlation=0.0)
    difference = 0.5 * world.slopes[:, :, :1] * 900.0 * (world.covariates["depth"].values ** 2)[:, None, None]
    moved = world.with_values(world.values + difference[:, :, 0])
    projection = project(moved)
    assert not gate(projection, NoiseModel()).is_passed
    assert gate(projection, NoiseModel(discrepancy=difference)).is_passed


def test_scatter_that_is_slow_is_no_structure():
    """Half of each value goes slowly along its trajectory, as a simulation scatters: none where it is known to."""
    world = plain(5, correlation=0.0)
    rng = np.random.default_rng(5)
    slow = rng.normal(size=(20, 6))[:, :, None] * np.cos(np.pi * np.linspace(0.05, 0.95, 10))[None, None, :]
    share = np.full(len(world.values), 0.7)
    slow = slow.transpose(0, 2, 1).reshape(-1, 6)[:, : world.values.shape[1]] * np.sqrt(2.0)
    moved = project(world.with_values(np.sqrt(1 - 0.7**2) * world.values + 0.7 * slow))
    assert not gate(moved, NoiseModel()).is_passed
    assert gate(moved, NoiseModel(scatter=share)).is_passed
    strong = project(world.with_values(world.values + 3.0 * slow))
    assert not gate(strong, NoiseModel(scatter=share)).is_passed


def test_same_seed_same_answer():
    """The same seed gives the same answer bit for bit."""
    projection = project(plain(4))
    assert gate(projection, NoiseModel(0.3), 5, 49) == gate(projection, NoiseModel(0.3), 5, 49)


def test_wrong_shapes_are_said():
    """Residuals with a trajectory in two pieces, or values that are not finite, are refused."""
    world = plain(0)
    with pytest.raises(UsageError, match="together"):
        type(world)(world.values, world.components, np.tile(np.arange(20), 10))
    broken = world.values.copy()
    broken[3, 1] = np.nan
    with pytest.raises(UsageError, match="not finite"):
        world.with_values(broken)

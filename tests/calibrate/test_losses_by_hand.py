"""Both losses in worlds of a few numbers, worked out by hand."""

from dataclasses import dataclass

import numpy as np
import pytest

from tactiledata.calibrate.losses import NormLoss, VectorLoss
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.nuisance.offsets import PRIOR, OffsetSeries

DEVIATIONS = np.array([0.1, 0.2, 0.6, 0.001, 0.002, 0.004])
NOISE = WrenchNoise(np.diag(DEVIATIONS**2), 4.0, "planted")
MANY = np.full(2, 1e18)
"""Readings in free air without number: the zero of each trajectory is known."""
POINT = np.array([3.0, 0.4, 0.2])
"""A modulus of 3, a ratio and a friction by which the level is multiplied: 3 x (0.4 + 10 x 0.2) = 7.2."""
FACTOR = 7.2


@dataclass
class Simulated:
    """A response of five frames of two trajectories, which does not depend on the offset."""

    level: np.ndarray
    starts = np.array([0, 2])
    counts = np.array([2, 3])

    def level_at(self, ratio, friction):
        return self.level * (ratio + 10 * friction)

    def at(self, ratio, friction):
        level = self.level_at(ratio, friction)
        return OffsetSeries(level, 0 * level, 0 * level)


@pytest.fixture
def level():
    return np.random.default_rng(0).uniform(0.1, 1.0, (5, 6)) * [1, 1, 1, 0.01, 0.01, 0.01]


@pytest.fixture
def measured():
    return np.random.default_rng(1).uniform(2.0, 9.0, (5, 6)) * [1, 1, 5, 0.01, 0.01, 0.01]


def by_hand(level, measured):
    """Whitened and weighted differences: over twice the deviations, less where the measured force is large."""
    share = 0.01 * np.sqrt((measured[:, 0] ** 2) + measured[:, 1] ** 2 + measured[:, 2] ** 2) / 0.3
    return (measured - FACTOR * level) / (2 * DEVIATIONS) / np.sqrt(1 + share**2)[:, None]


def test_the_vector_loss_is_the_root_mean_square_of_weighted_differences(level, measured):
    """Without a prior nothing is fitted: six components of five frames, over their deviations and weights."""
    loss = VectorLoss(Simulated(level), measured, NOISE, MANY, prior=0.0)
    rows = by_hand(level, measured)
    np.testing.assert_allclose(loss.residual(POINT), [*rows.ravel(), 0.0, 0.0], rtol=1e-6)
    assert loss.value(POINT) == pytest.approx(np.sqrt(np.square(rows).sum() / 30))


def test_what_a_vector_loss_is_by_default(level, measured):
    """By default one indenter has no factor of its own, and offsets are within an arm's repeatability of 0.04 mm."""
    loss = VectorLoss(Simulated(level), measured, NOISE, MANY)
    assert loss.prior == PRIOR == 4e-5
    assert loss.factors(POINT).tolist() == [1.0]
    assert loss.residual(POINT).shape == (5 * 6 + 2,)
    np.testing.assert_array_equal(loss.owner(), [*[0] * 12, *[1] * 18, 0, 1])


@pytest.mark.parametrize("none", [0.0, -0.02, -1.0])
def test_no_deviation_or_less_leaves_factors_and_offsets_out(level, measured, none):
    """A deviation of 0 or less leaves its row out of the factors, and offsets at 0: nothing is divided by it."""
    loss = VectorLoss(Simulated(level), measured, NOISE, MANY, none, np.array([1, 0]), none)
    np.testing.assert_array_equal(loss.residual(POINT)[30:], [0.0, 0.0])
    np.testing.assert_array_equal(loss.owner()[30:], [0, 1])
    assert loss.factors(POINT).tolist() == [1.0, 1.0]
    np.testing.assert_array_equal(np.signbit(loss.residual(POINT)[30:]), [False, False])


@pytest.mark.parametrize("error", [0.02, 0.9, 1.0, 1.5])
def test_a_factor_belongs_to_the_first_trajectory_of_its_indenter(level, measured, error):
    """Indenter 1 is met first: its factor, the second, belongs to trajectory 0, and indenter 0's to trajectory 1."""
    loss = VectorLoss(Simulated(level), measured, NOISE, MANY, 0.0, np.array([1, 0]), error)
    np.testing.assert_array_equal(loss.owner()[30:], [0, 1, 1, 0])
    np.testing.assert_allclose(loss.residual(POINT)[32:], (loss.factors(POINT) - 1) / error)


def test_each_frame_is_multiplied_by_its_own_indenters_factor(level):
    """Trajectory 0 is measured half as strong again by indenter 1, trajectory 1 a fifth weaker by indenter 0."""
    measured = FACTOR * level * np.repeat([1.5, 0.8], [2, 3])[:, None]
    loss = VectorLoss(Simulated(level), measured, NOISE, MANY, 0.0, np.array([1, 0]), 50.0)
    np.testing.assert_allclose(loss.factors(POINT), [0.8, 1.5], rtol=1e-3)
    np.testing.assert_allclose(loss.residual(POINT)[:30], 0.0, atol=0.02)


def test_other_measured_wrenches_change_nothing_else(level, measured):
    """The loss of twice the wrenches is that of a loss made with them, weights included."""
    loss = VectorLoss(Simulated(level), measured, NOISE, MANY, 0.0)
    again = VectorLoss(Simulated(level), 2 * measured, NOISE, MANY, 0.0)
    np.testing.assert_array_equal(loss.with_measured(2 * measured).residual(POINT), again.residual(POINT))
    np.testing.assert_allclose(again.weights[0], 1 / np.sqrt(1 + (0.02 * np.linalg.norm(measured[0, :3]) / 0.3) ** 2))


def test_the_norm_loss_is_a_mean_of_means_of_force_norms():
    """Forces of norm 5 and 13 N, torques without a say: 5 N against 4 x 7.2 N and so on, trajectory by trajectory."""
    level, measured = np.zeros((5, 6)), np.zeros((5, 6))
    level[:, 2] = [1.0, 2.0, 0.0, 0.5, 1.0]
    measured[:, :3] = [[3, 0, 4], [0, 12, 5], [3, 4, 0], [3, 4, 12], [0, 0, 0]]
    level[:, 3:], measured[:, 3:] = 100.0, -50.0
    means = [((7.2 - 5) + (14.4 - 13)) / 2, (5 + (13 - 3.6) + 7.2) / 3]
    loss = NormLoss(Simulated(level), measured)
    assert loss.value(POINT) == pytest.approx(sum(means) / 2)
    assert loss.offsets(POINT).tolist() == [0.0, 0.0]
    shared = NormLoss(Simulated(level), measured, np.array([3.0, 1.0]))
    assert shared.value(POINT) == pytest.approx((3 * means[0] + means[1]) / 4)

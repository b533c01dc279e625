"""Zeros marginalised where rows differ in noise, and what a simulation scatters."""

import numpy as np

from tactiledata.nuisance.numerical import scatter_covariance
from tactiledata.nuisance.tare import without_tare, zero_power

CHANCE = np.random.default_rng(3)
STARTS, COUNTS = np.array([0, 5]), np.array([5, 7])
VARIANCE = np.array([0.2, 0.05])


def gains(count):
    parts = CHANCE.normal(size=(count, 6, 6))
    return 0.3 * np.eye(6) + 0.1 * parts @ parts.transpose(0, 2, 1)


def test_it_is_the_power_of_the_covariance():
    field, rows = gains(12), CHANCE.normal(size=(12, 6, 2))
    found = zero_power(rows, field, STARTS, VARIANCE, -0.5)
    for start, count, variance in zip(STARTS, COUNTS, VARIANCE, strict=True):
        part = slice(start, start + count)
        tall = field[part].reshape(-1, 6)
        covariance = np.eye(len(tall)) + variance * tall @ tall.T
        for column in range(2):
            flat = rows[part, :, column].ravel()
            expected = flat @ np.linalg.solve(covariance, flat)
            assert np.isclose((found[part, :, column] ** 2).sum(), expected)
    assert np.allclose(zero_power(found, field, STARTS, VARIANCE, 0.5), rows)


def test_rows_of_one_noise_are_as_without_tare():
    weights, rows = CHANCE.uniform(0.2, 1.0, 12), CHANCE.normal(size=(12, 6))
    found = zero_power(rows[:, :, None], weights[:, None, None] * np.eye(6), STARTS, VARIANCE, -0.5)[:, :, 0]
    assert np.allclose(found, without_tare(rows, STARTS, VARIANCE, weights))


def test_a_trajectory_of_which_nothing_is_known_stays_as_it_is():
    field, rows = gains(12), CHANCE.normal(size=(12, 6, 1))
    field[:5] = 0.0
    assert np.array_equal(zero_power(rows, field, STARTS, VARIANCE, -0.5)[:5], rows[:5])


def test_scatter_is_that_of_forces_at_their_places():
    deviations, places = np.array([[0.2, 0.2, 0.05]]), np.array([[0.002, -0.003, -0.001]])
    found = scatter_covariance(deviations, np.array([3e-4]), places)[0]
    drawn = deviations * CHANCE.normal(size=(200_000, 3))
    torques = np.cross(places, drawn) + 3e-4 * CHANCE.normal(size=drawn.shape)
    sample = np.cov(np.hstack([drawn, torques]).T)
    size = np.sqrt(np.diag(found))
    assert np.abs((sample - found) / np.outer(size, size)).max() < 0.02

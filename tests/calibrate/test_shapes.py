"""Factors that the forces of an indenter have in common: found where planted, and 1 where there are none."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from tactiledata.nuisance.numerical import profile_shapes
from tactiledata.nuisance.offsets import OffsetSeries

PRIOR, SHARE = 4e-5, 0.03
SHAPES = np.array([0, 0, 1, 1, 1, 2])
STARTS = np.arange(6) * 12


def series_and_measured(factors, offsets, noise, seed=0):
    chance = np.random.default_rng(seed)
    depth = np.tile(np.linspace(0, 1, 12), 6)
    level = 60 * depth[:, None] ** 1.5 * chance.uniform(0.3, 1, (1, 6))
    slope = 90e3 * depth[:, None] ** 0.5 * chance.uniform(0.3, 1, (1, 6))
    series = OffsetSeries(level, slope, 1e7 * np.ones_like(level))
    rows = np.repeat(np.asarray(offsets, dtype=float), 12)
    measured = series.at(rows) * np.repeat(np.asarray(factors)[SHAPES], 12)[:, None]
    return series, measured + noise * chance.standard_normal(measured.shape)


def test_planted_factors_are_found():
    """Factors and contact offsets that were planted are found within 0.005 and 3 micrometres."""
    factors, offsets = [0.95, 1.0, 1.04], [2e-5, -1e-5, 0, 3e-5, -2e-5, 1e-5]
    series, measured = series_and_measured(factors, offsets, 1e-3)
    found, scales = profile_shapes(measured, series, STARTS, SHAPES, PRIOR, SHARE)
    assert np.abs(scales - factors).max() < 0.005
    assert np.abs(found - offsets).max() < 3e-6


def test_it_is_the_least_sum_of_squares():
    """Factors and offsets are those of a general least-squares solver."""
    series, measured = series_and_measured([0.93, 1.02, 1.0], [4e-5, -3e-5, 0, 1e-5, 0, 2e-5], 1.0)

    def residual(unknown):
        rows = series.at(np.repeat(unknown[:6], 12)) * np.repeat(unknown[6:][SHAPES], 12)[:, None]
        return np.concatenate([(measured - rows).ravel(), unknown[:6] / PRIOR, (unknown[6:] - 1) / SHARE])

    slow = least_squares(residual, [0.0] * 6 + [1.0] * 3, x_scale=[1e-5] * 6 + [0.01] * 3, xtol=1e-14, ftol=1e-14)
    offsets, factors = profile_shapes(measured, series, STARTS, SHAPES, PRIOR, SHARE)
    assert np.concatenate([offsets, factors]) == pytest.approx(slow.x, abs=2e-6)


def test_without_error_nothing_is_scaled():
    """Where the simulation is stated to be exact, all factors are 1 whatever the data say."""
    series, measured = series_and_measured([0.9, 1.0, 1.1], [0.0] * 6, 0.1)
    assert (profile_shapes(measured, series, STARTS, SHAPES, PRIOR, 0.0)[1] == 1.0).all()


def test_noise_alone_gives_factors_near_one():
    """Factors deviate from 1 by less than 0.02 where only noise separates the data from the simulation."""
    series, measured = series_and_measured([1.0, 1.0, 1.0], [0.0] * 6, 1.0)
    assert np.abs(profile_shapes(measured, series, STARTS, SHAPES, PRIOR, SHARE)[1] - 1).max() < 0.02

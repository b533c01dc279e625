"""Sizes of what is off in single touches are those that were planted, under the indenter where they were."""

import dataclasses

import numpy as np
import pytest
from planted_errors import planted_factors
from touch_worlds import START

from tactiledata.diagnose.naming.error_sizes import with_estimated_errors, with_simulated_by
from tactiledata.diagnose.naming.joint_fit import plain_fit
from tactiledata.diagnose.naming.own_error_sizes import (
    LARGEST,
    SMALLEST,
    own_size_penalty,
    with_estimated_own_sizes,
)

NAMES = planted_factors({}).indenter_names
USUAL = planted_factors({}).own.force


def estimated(sizes, seed=0):
    """Sizes by indenter that planted factors give."""
    white = planted_factors(sizes, seed)
    fit = plain_fit(white, START)
    return with_estimated_own_sizes(with_simulated_by(white, fit), fit).own.sizes


def test_noise_alone_asks_for_the_smallest_size():
    """Touches without factors of their own give every indenter the smallest size."""
    assert estimated({}) == pytest.approx(dict.fromkeys(NAMES, SMALLEST), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_factors_are_found_under_their_indenter(seed):
    """Forces that are wrong from touch to touch under one ball make its size large, and leave those of the others.

    Six touches say little of a size, of which the prior and the errors that all touches of a ball share take a part.
    """
    found = estimated({NAMES[1]: 6.0 * USUAL}, seed)
    assert 1.5 < found[NAMES[1]] < 6.0
    assert all(found[name] < 1.1 for name in NAMES if name != NAMES[1])


def test_no_size_is_beyond_the_bounds():
    """Touches that are off by half their force are not explained by a size of their own."""
    found = estimated(dict.fromkeys(NAMES, 0.5))
    assert max(found.values()) <= LARGEST * (1.0 + 1e-9)


def test_other_sizes_than_the_best_cost_likelihood():
    """The same sizes cost nothing, and smaller ones than those of the data cost."""
    white = planted_factors({NAMES[1]: 6.0 * USUAL})
    fit = plain_fit(white, START)
    best = with_estimated_own_sizes(white, fit)
    assert own_size_penalty(white, fit, {}) == 0.0
    fit = dataclasses.replace(fit, residual=best.whiten(white.in_newtons(white.with_own(fit.residual))))
    assert own_size_penalty(best, fit, best.own.sizes) == 0.0
    assert own_size_penalty(best, fit, {}) > 1.0


@pytest.mark.slow
def test_factors_on_forces_do_not_pull_the_modulus_down():
    """Over several draws of factors the mean of E is the truth; with errors in proportion to readings it is too low."""
    ratios, of_readings = [], []
    for seed in range(6):
        white = planted_factors(dict.fromkeys(NAMES, 0.06), seed)
        white = dataclasses.replace(white, own=white.own.with_sizes(dict.fromkeys(NAMES, LARGEST)))
        fit = plain_fit(white, START)
        of_readings.append(fit.model.material.youngs_modulus / START.youngs_modulus)
        fit = plain_fit(with_simulated_by(white, fit), START)
        ratios.append(fit.model.material.youngs_modulus / START.youngs_modulus)
    assert abs(np.mean(ratios) - 1.0) < 0.02
    assert np.mean(of_readings) < np.mean(ratios) - 0.02


@pytest.mark.slow
def test_all_sizes_together_are_those_of_the_data():
    """Factors of single touches under one ball raise its own size, whatever the shared errors take of them."""
    white = planted_factors({NAMES[3]: 6.0 * USUAL}, 2)
    found, fit = with_estimated_errors(white, plain_fit(white, START))
    assert max(found.own.sizes, key=found.own.sizes.get) == NAMES[3]
    assert abs(fit.model.material.youngs_modulus / START.youngs_modulus - 1.0) < 0.05

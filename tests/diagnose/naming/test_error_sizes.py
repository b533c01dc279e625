"""Sizes of the simulation's errors are those that were planted; noise alone asks for none."""

import dataclasses

import numpy as np
import pytest
from planted_errors import planted_errors
from touch_worlds import START

from tactiledata.diagnose.naming.error_sizes import (
    LARGEST,
    SMALLEST,
    size_penalty,
    smallest_ratio,
    with_errors_of,
    with_estimated_sizes,
)
from tactiledata.diagnose.naming.joint_fit import plain_fit
from tactiledata.diagnose.touches.simulation_errors import FAMILIES

PLANTED = 3.0
FACTOR = 2.0
"""Largest factor between an estimated size and the planted one: few draws stand behind each."""


def estimated(sizes, seed=0):
    """Sizes by family that planted errors give."""
    white = planted_errors(sizes, seed)
    found = with_estimated_sizes(white, plain_fit(white, START))
    return {family: found.errors.size(family) for family in FAMILIES}


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", [0, 2])
def test_planted_errors_are_found_in_their_family(family, seed):
    """Errors three times the usual are found within a factor; the other families, which have none, stay small."""
    found = estimated({family: PLANTED}, seed)
    assert PLANTED / FACTOR < found[family] < PLANTED * FACTOR
    assert all(found[other] < 0.8 for other in FAMILIES if other != family)


def test_noise_alone_asks_for_the_smallest_errors():
    """Noise without errors of the simulation gives every family the smallest size."""
    assert estimated({}) == pytest.approx(dict.fromkeys(FAMILIES, SMALLEST), rel=1e-3)


def test_errors_of_the_usual_size_are_no_larger():
    """What the defaults say is neither near the upper bound nor as large as three times it."""
    found = estimated(dict.fromkeys(FAMILIES, 1.0), 3)
    assert all(1.0 / FACTOR < size < FACTOR for size in found.values())


def test_no_size_is_beyond_the_bounds():
    """Errors that no solver of the same gel has are not explained by a size of their own."""
    found = estimated(dict.fromkeys(FAMILIES, 30.0))
    assert max(found.values()) <= LARGEST * (1.0 + 1e-9)


@pytest.fixture(scope="module")
def resized():
    """Touches with planted errors of the normal force, the fit to them, and the touches with estimated sizes."""
    white = planted_errors({FAMILIES[0]: PLANTED})
    fit = plain_fit(white, START)
    return white, fit, with_estimated_sizes(white, fit)


def test_other_sizes_than_the_best_cost_likelihood(resized):
    """The same sizes cost nothing, worse ones cost, and better ones are no gain below nothing."""
    white, fit, best = resized
    assert size_penalty(white, fit, white) == 0.0
    assert size_penalty(white, fit, best) == 0.0
    worse = dataclasses.replace(
        white, errors=white.errors.with_sizes({**dict.fromkeys(FAMILIES, 1.0), FAMILIES[0]: 0.6})
    )
    assert size_penalty(white, fit, worse) > 1.0


def test_errors_are_the_same_wrenches_after_their_sizes_changed(resized):
    """The same wrenches are fewer deviations of a larger size, and more of a smaller one."""
    white, fit, best = resized
    model = with_errors_of(fit.model, white, best)
    before, after = (
        one.simulation_error_wrenches(START) @ errors
        for one, errors in ((white, fit.model.errors), (best, model.errors))
    )
    np.testing.assert_allclose(after, before, atol=1e-12)
    assert not np.allclose(model.errors, fit.model.errors)
    assert model.material == fit.model.material


def test_the_smallest_ratio_is_that_of_the_size_that_fell_most(resized):
    """The ratio is the smallest size if all sizes were 1, and one over the largest the other way round."""
    white, _, best = resized
    sizes = [best.errors.size(family) for family in FAMILIES]
    assert smallest_ratio(white, best) == pytest.approx(min(sizes))
    assert smallest_ratio(best, white) == pytest.approx(1.0 / max(sizes))

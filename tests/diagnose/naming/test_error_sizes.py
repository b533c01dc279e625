"""Sizes of the simulation's errors are those that were planted; noise alone asks for none."""

import dataclasses

import numpy as np
import pytest
from planted_errors import planted_errors
from touch_worlds import START

from tactiledata.diagnose.naming.error_sizes import (
    LARGEST,
    SMALLEST,
    _groups,
    _size_cost,
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
    """Typical size by family, over all indenters, that planted errors give."""
    white = planted_errors(sizes, seed)
    found = with_estimated_sizes(white, plain_fit(white, START))
    of_family = {
        family: [size for group, size in found.errors.sizes.items() if group[0] == family] for family in FAMILIES
    }
    return {family: float(np.exp(np.log(sizes).mean())) for family, sizes in of_family.items()}


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("seed", [0, 2])
def test_planted_errors_are_found_in_their_family(family, seed):
    """Errors three times the usual are found within a factor; the other families, which have none, stay small."""
    found = estimated({family: PLANTED}, seed)
    assert PLANTED / FACTOR < found[family] < PLANTED * FACTOR
    assert all(found[other] < 0.85 for other in FAMILIES if other != family)


def test_noise_alone_asks_for_the_smallest_errors():
    """Noise without errors of the simulation gives every family the smallest size."""
    assert estimated({}) == pytest.approx(dict.fromkeys(FAMILIES, SMALLEST), rel=1e-3)


def test_errors_of_the_usual_size_are_no_larger():
    """What the defaults say is neither near the upper bound nor as large as three times it."""
    found = estimated(dict.fromkeys(FAMILIES, 1.0), 3)
    assert all(1.0 / FACTOR < size < FACTOR for size in found.values())


@pytest.mark.slow
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


@pytest.mark.slow
def test_other_sizes_than_the_best_cost_likelihood(resized):
    """The same sizes cost nothing, worse ones cost, and better ones are no gain below nothing."""
    white, fit, best = resized
    assert size_penalty(white, fit, white) == 0.0
    assert size_penalty(white, fit, best) == 0.0
    smaller = {group: 0.6 if group[0] == FAMILIES[0] else 1.0 for group in best.errors.sizes}
    worse = dataclasses.replace(white, errors=white.errors.with_sizes(smaller))
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
    """The ratio of sizes that all were 1 is the smallest size; the other way round it is one over the largest."""
    white, _, best = resized
    sizes = best.errors.sizes.values()
    assert smallest_ratio(white, best) == pytest.approx(min(1.0, *sizes))
    assert smallest_ratio(best, white) == pytest.approx(min(1.0, 1.0 / max(sizes)))
    touched = dataclasses.replace(white, own=white.own.with_sizes({white.indenter_names[0]: 4.0}))
    assert smallest_ratio(touched, white) == pytest.approx(0.25)


@pytest.mark.slow
def test_errors_of_one_indenter_are_found_under_it_alone():
    """Forces that are wrong under one ball make its size large, and leave those of the other balls near the usual."""
    name = planted_errors({}).indenter_names[1]
    white = planted_errors({FAMILIES[0]: 4.0}, 2, only=name)
    found = with_estimated_sizes(white, plain_fit(white, START)).errors
    others = [found.size(FAMILIES[0], other) for other in white.indenter_names if other != name]
    assert found.size(FAMILIES[0], name) > 2.0 * max(others)


def test_the_gradient_of_the_sizes_is_that_of_differences(resized):
    """The gradient that the search for sizes uses is what small changes of each logarithm give."""
    white, fit, _ = resized
    cost = _size_cost(white, fit)
    at = np.linspace(-0.4, 0.8, len(_groups(white)))
    value, gradient = cost(at)
    for number in range(len(at)):
        step = np.zeros(len(at))
        step[number] = 1e-5
        difference = (cost(at + step)[0] - cost(at - step)[0]) / 2e-5
        assert gradient[number] == pytest.approx(difference, rel=1e-3, abs=1e-3)
    assert np.isfinite(value)


@pytest.mark.parametrize("left", [1e-152, 1e-157, 1e-160, 1e-170])
def test_fits_that_change_next_to_nothing_leave_the_sizes(resized, left):
    """Sizes of errors whose influence on the data is denormal follow from their prior alone; no number overflows."""
    white, fit, _ = resized
    faint = dataclasses.replace(fit, shared=fit.shared * left)
    nothing = dataclasses.replace(faint, shared=np.zeros_like(fit.shared))
    at = np.zeros(len(_groups(white)))
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        value, gradient = _size_cost(white, faint)(at)
    expected, slope = _size_cost(white, nothing)(at)
    assert value == pytest.approx(expected)
    np.testing.assert_allclose(gradient, slope, rtol=1e-9, atol=1e-9)

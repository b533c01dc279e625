"""What a fit puts down to the simulation itself is told: a replay has it, uncorrected."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from touch_worlds import START, World, world_cases

from tactiledata.diagnose.naming.joint_fit import plain_fit
from tactiledata.diagnose.naming.simulator_share import (
    TOLD,
    SimulatorError,
    simulator_share,
    simulator_share_words,
)
from tactiledata.diagnose.touches.simulation_errors import KINDS
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches

FACTOR = 0.15
"""How much larger forces of one indenter are than those of the simulation, as a share."""
ALL_FORCES = KINDS[0].what


def erred_forces(white, fit):
    """Normal forces (N,) of a plain fit, with the errors of the simulation."""
    simulated = white.touch_set.simulate(fit.model.material, [], fit.model.offsets)
    return np.nan_to_num(white.erred(simulated, fit.model.errors))[:, 2]


@cache
def blamed(factor):
    """Fit to a world without physics that the simulation lacks, forces of one of four indenters times a factor.

    Also the name of that indenter, the whitened touches, and by indenter the normal force that the fit attributes to
    errors of the simulation, over the simulated one.
    """
    plain = world_cases(World(mismatch=0.0, jitter=0.0), 3, 24)
    one = plain.touches[0].touch.indenter_name
    cases = [
        dataclasses.replace(case, measured=case.measured * factor) if case.touch.indenter_name == one else case
        for case in plain.touches
    ]
    white = WhitenedTouches.of(TouchSet(cases, plain.base))
    fit = plain_fit(white, START)
    force = np.nan_to_num(white.touch_set.play(fit.model.material, [], fit.model.offsets))[:, 2]
    errors = erred_forces(white, fit) - force
    by_indenter = white.indenter[white.trajectory]
    shares = {
        name: float((errors * force)[by_indenter == number].sum() / (force**2)[by_indenter == number].sum())
        for number, name in enumerate(white.indenter_names)
    }
    return one, white, fit, shares


@pytest.mark.slow
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_planted_factor_is_found_at_its_indenter(sign):
    """Most of it is in the wrench that the fit attributes to errors of that indenter, beside those of the others.

    Several errors of the indenter share it, and its contact offsets take the rest: between half and all is found.
    """
    one, _, _, before = blamed(1.0)
    _, _, _, after = blamed(1.0 + sign * FACTOR)
    gained = {name: (1.0 + after[name]) / (1.0 + before[name]) - 1.0 for name in before}
    others = [share for name, share in gained.items() if name != one]
    found = sign * (gained[one] - np.mean(others))
    assert 0.5 * FACTOR < found < 1.0 * FACTOR
    # the others are alike: a factor on the forces of one is no error of another
    assert np.ptp(others) < 0.05 * FACTOR


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_planted_factor_is_fitted(sign):
    """Simulation and errors together are the planted factor above those of the plain world: within a tenth of it."""
    one, white, plain, _ = blamed(1.0)
    _, planted, more, _ = blamed(1.0 + sign * FACTOR)
    before, after = erred_forces(white, plain), erred_forces(planted, more)
    for number, name in enumerate(white.indenter_names):
        rows = white.indenter[white.trajectory] == number
        gained = float((before * after)[rows].sum() / (before**2)[rows].sum()) - 1.0
        assert gained == pytest.approx(sign * FACTOR if name == one else 0.0, abs=0.1 * FACTOR)


def test_a_planted_factor_is_told_and_no_factor_is_not():
    """A sentence says under which indenter a planted factor acts, and which way; a world without one has none."""
    one, white, plain, _ = blamed(1.0)
    _, _, more, _ = blamed(1.0 + 2.0 * FACTOR)
    said = simulator_share_words(simulator_share(white, more))
    assert said[0].count("too small under " + one) == 1
    assert simulator_share_words(simulator_share(white, plain)) == []


def test_the_list_is_of_the_errors_of_the_fit():
    """The list has share, deviations and words of each error, in the order of the fields."""
    _, white, fit, _ = blamed(1.0 + FACTOR)
    found = simulator_share(white, fit)
    assert [one.what for one in found] == [error.label for error in white.simulation_errors]
    assert [one.deviations for one in found] == fit.model.errors.tolist()
    assert [one.kind for one in found] == [error.what for error in white.simulation_errors]
    assert [one.share for one in found] == pytest.approx(
        [size * error.deviation for size, error in zip(fit.model.errors, white.simulation_errors, strict=True)]
    )


def all_forces(share, indenter):
    """A factor on the forces of one indenter."""
    return SimulatorError(f"{ALL_FORCES} of {indenter}", share / 0.03, share, indenter, ALL_FORCES)


def test_little_is_not_said():
    """A share that is too small gets no sentence, and neither does an error that is no factor on forces."""
    little = all_forces(0.9 * TOLD, "a")
    other = SimulatorError("shear that sticks", 3.0, 3.0 * TOLD, "", "shear that sticks")
    assert simulator_share_words([little, other]) == []
    assert len(simulator_share_words([all_forces(1.1 * TOLD, "a")])) == 1


@pytest.mark.parametrize(("share", "word"), [(0.09, "9 % too small"), (-0.2, "20 % too large")])
def test_the_sign_is_that_of_the_simulation(share, word):
    """Positive: the simulation gives too little."""
    (said,) = simulator_share_words([all_forces(share, "ball")])
    assert f"{word} under ball" in said

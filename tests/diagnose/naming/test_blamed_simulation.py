"""What a fit puts down to the simulation itself is told: a replay has it, uncorrected."""

import dataclasses

import pytest
from touch_worlds import START, World, world_cases

from tactiledata.diagnose.naming.joint_fit import plain_fit
from tactiledata.diagnose.naming.simulator_share import SimulatorError, simulator_share, simulator_share_words
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches

SHARE = 0.06


def blamed(factor):
    """Of a world without physics that the simulation lacks, forces of one of four indenters times a factor."""
    plain = world_cases(World(mismatch=0.0, jitter=0.0), 3, 24)
    one = plain.touches[0].touch.indenter_name
    cases = [
        dataclasses.replace(case, measured=case.measured * factor) if case.touch.indenter_name == one else case
        for case in plain.touches
    ]
    white = WhitenedTouches.of(TouchSet(cases, plain.base))
    found = simulator_share(white, plain_fit(white, START))
    return one, {each.indenter: each for each in found if each.indenter}, found


def test_a_planted_factor_is_found_at_its_indenter():
    """One indenter's forces a sixth off: beside the others it is told by how much, and which way."""
    one, plain, _ = blamed(1.0)
    _, more, found = blamed(1.0 + 2.5 * SHARE)
    gained = more[one].share - plain[one].share
    others = [more[name].share - plain[name].share for name in plain if name != one]
    assert gained - max(others) > 1.5 * SHARE
    assert max(map(abs, others)) < gained
    assert simulator_share_words(found)[0].count("too small under " + one) == 1


def test_little_is_not_said():
    """Below what is worth a sentence there is none, nor of what is no indenter's."""
    assert (
        simulator_share_words(
            [SimulatorError("all forces of a", 1.0, 0.03, "a"), SimulatorError("shear that sticks", 3.0, 0.12)]
        )
        == []
    )


@pytest.mark.parametrize(("share", "word"), [(0.09, "9 % too small"), (-0.2, "20 % too large")])
def test_the_sign_is_that_of_the_simulation(share, word):
    """Positive: the simulation gives too little."""
    (said,) = simulator_share_words([SimulatorError("all forces of ball", share / SHARE, share, "ball")])
    assert f"{word} under ball" in said

"""Sliders on springs: each step's speed of sliding agrees with springs and limit, and a pull is kept within a limit."""

from math import asinh, exp, log1p

import numpy as np
import pytest

from tactiledata.rig.hidden.coulomb_limit import within
from tactiledata.rig.hidden.slider import CRITICAL_SLIP, SLOWEST, Loaded, SlidingLaws, slide

RATE, STIFFNESS, FRICTION, NORMAL = 500.0, 3000.0, 0.6, 2.0
SHARE, SCALE = 0.08, exp(1 / 0.08) / 2e-3
AREAS = np.full(600, 1e-5)
LOADED = Loaded(np.full(600, NORMAL), np.full(600, STIFFNESS))


def rate_law(state):
    return SHARE * asinh(state.speed * SCALE)


def slid(steps, *factors, rate=RATE):
    """Pull (n,), N, along a way whose steps, m, are given."""
    path = np.column_stack([np.cumsum(np.concatenate([[0.0], steps])), np.zeros(len(steps) + 1)])
    return slide(path, LOADED, AREAS, FRICTION, rate, SlidingLaws(factors))[0][:, 0]


def stretched(steps, pull):
    """What springs would pull (n,), N, after each step, m, if nothing slid in it."""
    return np.concatenate([[0.0], pull[:-1] + STIFFNESS * steps])


@pytest.mark.parametrize("speed", [1e-6, 1e-4, 1e-2])
def test_a_steady_slide_is_at_the_limit_of_its_speed(speed):
    """After a way that is longer than that of the springs the pull is friction at the speed of the indenter."""
    pull = slid(np.full(599, 4e-6), rate_law, rate=speed / 4e-6)
    assert pull[-1] == pytest.approx(FRICTION * NORMAL * SHARE * asinh(speed * SCALE), rel=1e-6)


def test_speed_springs_and_limit_agree_in_every_step():
    """Wherever it slides, the springs lose what the step's time at the speed takes whose limit the pull is."""
    steps = np.abs(np.random.default_rng(0).normal(0.0, 2e-6, 599)) * np.geomspace(0.01, 10.0, 599)
    pull = slid(steps, rate_law)
    speeds = np.sinh(pull / (FRICTION * NORMAL * SHARE)) / SCALE
    slides = speeds > 10 * SLOWEST
    assert slides.sum() > 300
    np.testing.assert_allclose((stretched(steps, pull) - STIFFNESS * speeds / RATE)[slides], pull[slides], atol=1e-9)


def test_age_grows_at_rest_and_is_lost_by_sliding():
    """The limit after each step is that of the age which speeds until then have left: d age / dt = 1 - v age / D."""
    steps = np.concatenate([np.zeros(300), np.full(299, 5e-6)])
    pull = slid(steps, lambda state: 1 + 0.2 * log1p(state.age / 0.03))
    speeds = (stretched(steps, pull) - pull) / STIFFNESS * RATE
    age, expected = 0.0, np.zeros(600)
    for moment, speed in enumerate(speeds):
        expected[moment] = FRICTION * NORMAL * (1 + 0.2 * np.log1p(age / 0.03))
        age = (age + 1 / RATE) / (1 + max(speed, 0.0) / RATE / CRITICAL_SLIP)
    slides = speeds > 1e-6
    assert slides.sum() > 50
    np.testing.assert_allclose(pull[slides], expected[slides], rtol=1e-9)


def test_a_pull_within_its_limit_is_kept():
    """A pull of 5 N stays below 6 N, becomes 2.5 N of the same direction, and nothing where nothing is allowed."""
    np.testing.assert_allclose(
        within(np.array([[3.0, 4.0], [3.0, 4.0], [3.0, 4.0]]), np.array([6.0, 2.5, 0.0])),
        [[3.0, 4.0], [1.5, 2.0], [0.0, 0.0]],
    )

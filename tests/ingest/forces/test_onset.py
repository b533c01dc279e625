"""Light touches are seen in averaged readings, and nothing else is taken for one."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tactiledata.ingest.forces.onset import LIGHT_TOUCH, light_touch, surely_free, touch_threshold
from tactiledata.ingest.forces.tare import find_zero

RATE = 100
"""Readings a second."""


def pressed(force, air=2.0, rise=1.0, dwell=3.0, noise=0.06, seed=0, memory=0.0):
    """Times (n,), ns, and loads (n, 6), N and N m, of a press along z in the middle of free air, with a zero of 3 N."""
    corners = np.cumsum([0.0, air, rise, dwell, rise, air])
    seconds = np.arange(0.0, corners[-1], 1.0 / RATE)
    white = np.random.default_rng(seed).normal(0.0, noise, (len(seconds), 6))
    for row in range(1, len(white)):
        white[row] += memory * (white[row - 1] - white[row])
    load = 3.0 + white
    load[:, 2] -= np.interp(seconds, corners, [0.0, 0.0, force, force, 0.0, 0.0])
    return np.rint(seconds * 1e9).astype(np.int64), load


@pytest.mark.parametrize("force", [0.3, 0.45, 0.8])
def test_a_light_press_is_noticed_while_it_rises(force):
    """A press under the threshold of single readings is noticed before it is over, and after it has begun."""
    t_ns, load = pressed(force)
    assert 2.0 * RATE - 0.2 * RATE <= light_touch(load, t_ns) <= 3.2 * RATE


@example(seed=95, memory=0.75, noise=0.25)
@given(seed=st.integers(0, 1000), memory=st.floats(0.0, 0.8), noise=st.floats(0.01, 0.3))
def test_noise_with_memory_is_no_light_touch(seed, memory, noise):
    """Noise alone, with or without memory, leaves the whole trajectory in free air."""
    t_ns, load = pressed(0.0, noise=noise, seed=seed, memory=memory)
    assert light_touch(load, t_ns) == len(load)


def test_the_push_of_an_arm_that_starts_is_no_light_touch():
    """A force that is over within three tenths of a second is not taken for a touch; the press after it is."""
    t_ns, load = pressed(0.6)
    load[20:50, 0] += 0.6
    assert light_touch(load, t_ns) >= 1.8 * RATE


def test_a_short_trajectory_has_no_light_touch():
    """A second of readings is too short for averages that last: nothing is said of it."""
    t_ns, load = pressed(0.6, air=0.2, rise=0.2, dwell=0.2)
    assert light_touch(load, t_ns) == len(load)


@pytest.mark.parametrize("rate", [1, 5])
def test_the_samples_before_a_light_press_are_surely_free(rate):
    """Most of what comes before a light press is free air; repeated readings of a faster poll change nothing."""
    t_ns, load = pressed(0.45)
    times = t_ns[0] + np.arange(rate * len(t_ns)) * (10**7 // rate)
    free = surely_free(np.repeat(load - 3.0, rate, axis=0), times)
    assert 1.2 * RATE * rate <= free <= 2.0 * RATE * rate


@pytest.mark.parametrize("force", [0.3, 0.5, 1.0])
def test_a_light_press_does_not_move_the_zero(force):
    """The zero of a trajectory is that of its free air, though no single reading is over the threshold of a touch."""
    t_ns, load = pressed(force, noise=0.05, air=1.0, dwell=6.0)
    assert force < 0.9 or force > touch_threshold(0.05)
    zero = find_zero(t_ns, load, [("one", int(t_ns[0]), int(t_ns[-1]))], [])
    assert zero.bias[0, 2] == pytest.approx(3.0, abs=0.25 * LIGHT_TOUCH)

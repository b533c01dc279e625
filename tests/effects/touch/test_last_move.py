"""How fast a tip moved, and how long it stood, from its poses."""

import numpy as np
import pytest

from tactiledata.effects.touch.last_move import WAYS, last_move, last_ways


def path(rate=125.0):
    """1 s at rest, 1 mm at 2 mm/s, 1.5 s at rest, back at 0.5 mm/s, at rest."""
    corners, ways = [0.0, 1.0, 1.5, 3.0, 5.0, 6.0], [0.0, 0.0, 1e-3, 1e-3, 0.0, 0.0]
    seconds = np.arange(0.0, 6.0, 1.0 / rate)
    return seconds, np.outer(np.interp(seconds, corners, ways), [0.6, 0.8])


@pytest.mark.parametrize("noise", [0.0, 1e-6])
def test_pace_and_rest_are_those_of_the_last_move(noise):
    """On the way the speed itself; at rest that of the last move, and the time since; nothing before the first."""
    seconds, places = path()
    places = places + noise * np.random.default_rng(0).normal(size=places.shape)
    pace, rest = last_move(np.array([0.5, 1.25, 2.0, 2.99, 4.0, 5.8]), seconds, places)
    np.testing.assert_allclose(pace, [0.0, 2e-3, 2e-3, 2e-3, 5e-4, 5e-4], rtol=0.25 if noise else 0.05)
    np.testing.assert_allclose(rest, [0.0, 0.0, 0.5, 1.49, 0.0, 0.8], atol=0.05)


def test_a_tip_that_only_trembles_stands():
    """Noise of the poses alone is no move."""
    seconds = np.arange(0.0, 3.0, 0.008)
    places = 2e-6 * np.random.default_rng(1).normal(size=(len(seconds), 2))
    pace, rest = last_move(np.array([1.0, 2.5]), seconds, places)
    assert (pace == 0).all()
    assert (rest == 0).all()


def test_ways_take_as_long_as_they_are_at_a_steady_speed_and_rest_adds():
    """1 mm/s for a second, then at rest: way / v on the move, that and the rest after it; no more than there was."""
    seconds = np.arange(0.0, 3.0, 1e-3)
    places = np.column_stack([np.minimum(seconds, 1.0) * 1e-3, np.zeros(len(seconds))])
    took = last_ways(np.array([0.0, 0.5, 1.0, 2.5]), seconds, places)
    steady = np.array(WAYS) / 1e-3
    assert took[0] == pytest.approx(0.0)
    assert took[1] == pytest.approx(np.minimum(steady, 0.5), abs=2e-3)
    assert took[2] == pytest.approx(np.minimum(steady, 1.0), abs=2e-3)
    assert took[3] == pytest.approx(np.minimum(steady, 1.0) + 1.5, abs=2e-3)

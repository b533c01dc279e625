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
    """The pace is the speed on the way and that of the last move at rest; nothing is known before the first move."""
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


@pytest.mark.parametrize(("share", "stands"), [(0.97, True), (1.03, False)])
def test_what_counts_as_moving_is_five_times_the_noise_of_the_speed(share, stands):
    """A zigzag of 1 um has bends of 4 um: white noise of 4 / sqrt(6) um, of 5 * sqrt(2) * 4 / sqrt(6) um in 0.04 s."""
    seconds = np.arange(300) / 100.0
    zigzag = 1e-6 * (-1.0) ** np.arange(300)  # the same four positions before: no speed of its own
    limit = 5.0 * np.sqrt(2.0) * 4e-6 / np.sqrt(6.0) / 0.04
    places = np.column_stack([share * limit * seconds, zigzag])
    pace, rest = last_move(np.array([2.0]), seconds, places)
    assert pace[0] == pytest.approx(0.0 if stands else share * limit, rel=1e-6)
    assert rest[0] == 0.0


@pytest.mark.parametrize(("speed", "stands"), [(4.9e-5, True), (5.1e-5, False)])
def test_without_noise_a_twentieth_of_a_millimetre_a_second_is_the_slowest_move(speed, stands):
    """49 um/s stand, 51 um/s move."""
    seconds = np.arange(300) / 100.0
    places = np.outer(speed * seconds, [0.6, 0.8])
    pace, _ = last_move(np.array([2.0]), seconds, places)
    assert pace[0] == pytest.approx(0.0 if stands else speed, rel=1e-6)


def test_the_pace_of_what_stands_is_the_greatest_speed_of_its_last_move_alone():
    """A move at 4, then 2 mm/s, a rest, a move at 1 mm/s, a rest: 4 mm/s, then 1 mm/s; its own speed on the way."""
    corners = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0]
    ways = np.array([0.0, 0.0, 2.0, 3.0, 3.0, 4.0, 4.0]) * 1e-3
    seconds = np.arange(600) / 100.0
    places = np.column_stack([np.zeros(600), np.interp(seconds, corners, ways)])
    pace, rest = last_move(np.array([0.9, 1.4, 1.9, 2.5, 3.5, 5.5, 9.0]), seconds, places)
    np.testing.assert_allclose(pace, [0.0, 4e-3, 2e-3, 4e-3, 1e-3, 1e-3, 1e-3], rtol=1e-6)
    # over a window of 0.04 s the last speed above the slowest is 0.03 s after the end of a move
    np.testing.assert_allclose(rest, [0.0, 0.0, 0.0, 0.47, 0.0, 1.47, 4.97], atol=1e-6)


def test_too_few_positions_tell_of_no_move():
    """Two positions, far apart, are none; three are enough."""
    seconds, places = np.array([0.0, 0.02, 0.04]), np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    frames = np.array([0.05])
    assert [found.tolist() for found in last_move(frames, seconds[:2], places[:2])] == [[0.0], [0.0]]
    assert last_move(frames, seconds, places)[0][0] > 0


def test_frames_before_the_first_position_know_nothing():
    """No way was seen, no pace, no rest."""
    seconds, places = path()
    early = np.array([-1.0])
    assert last_ways(early, seconds, places).tolist() == [[0.0] * len(WAYS)]
    assert [found.tolist() for found in last_move(early, seconds, places)] == [[0.0], [0.0]]


def test_a_frame_takes_the_speed_of_the_last_position_before_it():
    """At 2 m/s^2 the speed over the last 0.04 s is that of 0.02 s ago; between two positions, of the earlier one."""
    seconds = np.arange(300) / 100.0
    places = np.outer(seconds**2, [1.0, 0.0])
    pace, rest = last_move(np.array([0.5, 1.0, 1.004, 1.0099, 1.01, 9.0]), seconds, places)
    np.testing.assert_allclose(pace, 2.0 * (np.array([0.5, 1.0, 1.0, 1.0, 1.01, 2.99]) - 0.02), rtol=1e-9)
    assert (rest == 0).all()


def test_rest_counts_from_the_last_position_of_a_move():
    """A step between 1.00 and 1.01 s moves until 1.04 s, while it lies within the window; at 1.055 s it rests 15 ms."""
    seconds = np.arange(300) / 100.0
    places = np.column_stack([np.where(seconds > 1.005, 1e-3, 0.0), np.zeros(300)])
    pace, rest = last_move(np.array([1.0, 1.01, 1.03, 1.055, 2.0]), seconds, places)
    np.testing.assert_allclose(pace, [0.0, *[1e-3 / 0.04] * 4], rtol=1e-6)
    np.testing.assert_allclose(rest[[0, 1, 2, 4]], [0.0, 0.0, 0.0, 0.96], atol=1e-9)
    assert rest[3] == pytest.approx(0.015, abs=1e-9)


def test_ways_are_three_and_ten_in_every_decade():
    """The ways go from 3 um to 1 mm, at three and ten in every decade."""
    assert (WAYS[0], WAYS[1], WAYS[-1]) == (3e-6, 1e-5, 1e-3)
    np.testing.assert_allclose(WAYS[2:], 10.0 * np.array(WAYS[:-2]))


def test_a_move_may_begin_with_the_first_positions():
    """A step of 1 mm between the first two of many positions is the last move of all that stands after it."""
    seconds = np.arange(20) / 10.0
    places = np.column_stack([np.where(seconds > 0.05, 1e-3, 0.0), np.zeros(20)])
    pace, rest = last_move(np.array([0.1, 0.25, 1.5]), seconds, places)
    # of a tenth of a second the last 0.04 s count
    np.testing.assert_allclose(pace, 0.4e-3 / 0.04, rtol=1e-9)
    np.testing.assert_allclose(rest, [0.0, 0.15, 1.4], atol=1e-9)

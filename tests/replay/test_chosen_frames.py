"""The frames that stand for a long trajectory hold its corners, and leave no long gap."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.replay.chosen_frames import CORNER, chosen_frames


def slide(rate=60.0):
    """Press 0.5 mm, dwell 2 s, slide 0.8 mm, turn back by 0.3 mm, dwell, leave: times and positions of the tip."""
    times = [0.0, 0.5, 2.5, 3.3, 3.6, 5.6, 6.1]
    corners = np.array([(0, 0, 0), (0, 0, -5e-4), (0, 0, -5e-4), (8e-4, 0, -5e-4), (5e-4, 0, -5e-4), (5e-4, 0, -5e-4),
                        (5e-4, 0, 0)])  # fmt: skip
    seconds = np.arange(0.0, 6.1, 1.0 / rate)
    return seconds, np.column_stack([np.interp(seconds, times, column) for column in corners.T])


def deviation(seconds, places, chosen):
    """Largest distance, m, of a path from straight moves between its chosen frames."""
    straight = np.column_stack([np.interp(seconds, seconds[chosen], column[chosen]) for column in places.T])
    return np.linalg.norm(places - straight, axis=1).max()


def test_no_corner_is_lost():
    """24 of 366 frames give the path to 20 um; at even distances they miss the turn by more than that."""
    seconds, places = slide()
    chosen = chosen_frames(seconds, places, 24)
    assert len(chosen) == 24
    assert deviation(seconds, places, chosen) <= CORNER
    even = np.unique(np.linspace(0, len(seconds) - 1, 24).astype(int))
    assert deviation(seconds, places, even) > CORNER


def test_what_remains_divides_the_longest_gaps():
    """No gap is longer than a fifth of the dwells' time, and none spans more than 0.25 mm of the path."""
    seconds, places = slide()
    chosen = chosen_frames(seconds, places, 24)
    assert np.diff(seconds[chosen]).max() < 0.8
    assert np.linalg.norm(np.diff(places[chosen], axis=0), axis=1).max() < 2.6e-4


@given(
    st.lists(st.tuples(*[st.floats(-1e-3, 1e-3)] * 3), min_size=2, max_size=80),
    st.integers(2, 30),
    st.integers(0, 3),
)
def test_as_many_frames_as_asked_ascending_and_known(points, most, unknown):
    """Whatever the path: the first and the last known frame are among them, and none is unknown or chosen twice."""
    places = np.array(points)
    places[1 : 1 + unknown] = np.nan
    chosen = chosen_frames(np.arange(float(len(places))), places, most)
    known = np.flatnonzero(np.isfinite(places).all(axis=1))
    if len(places) <= most:
        assert chosen.tolist() == list(range(len(places)))
        return
    assert len(chosen) == min(most, len(known))
    assert (np.diff(chosen) > 0).all()
    assert set(chosen) <= set(known.tolist())
    assert {known[0], known[-1]} <= set(chosen.tolist())


def test_a_tip_that_stands_is_divided_by_time():
    """Without any path the frames lie at nearly even distances."""
    seconds = np.arange(100.0)
    chosen = chosen_frames(seconds, np.zeros((100, 3)), 9)
    assert np.diff(chosen) == pytest.approx(99 / 8, abs=2)

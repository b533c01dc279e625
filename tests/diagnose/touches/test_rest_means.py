"""Readings while the indenter stands are averaged, and no other ones."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tactiledata.calibrate.touches import ForceReadings
from tactiledata.diagnose.touches.rest_means import (
    BEFORE_MOVE,
    SETTLED,
    SHARE_OF_REST,
    means_at_rest,
    position_jitter,
    rest_spans,
)

RATE = 125.0
"""Hz of the positions."""


def path(stops, speed=1e-3, step=3e-4, end=1.0, jitter=0.0, seed=0):
    """Times and positions of a tip that moves by ``step`` after each of the times ``stops``, and stands between."""
    seconds = np.arange(0.0, stops[-1] + step / speed + end, 1.0 / RATE)
    depth = sum(np.clip((seconds - stop) * speed, 0.0, step) for stop in stops)
    places = np.column_stack([np.zeros_like(depth), np.zeros_like(depth), -depth])
    return seconds, places + jitter * np.random.default_rng(seed).normal(size=places.shape)


def readings_of(force, seconds, rate=100.0):
    """Readings of a force, a function of time, along z."""
    times = np.arange(seconds[0], seconds[-1], 1.0 / rate)
    wrench = np.zeros((len(times), 6))
    wrench[:, 2] = force(times)
    return ForceReadings(times, wrench)


@given(
    st.lists(st.floats(0.1, 3.0), min_size=1, max_size=5),
    st.lists(st.floats(0.0, 1.0), min_size=1, max_size=12, unique=True),
    st.floats(3e-4, 5e-3),
    st.sampled_from([0.0, 1e-6, 2e-6, 4.5e-6]),
    st.integers(0, 1000),
)
@example([1.9453125, 0.8671875, 0.875, 0.25, 0.125], [0.4375], 0.0003, 2e-6, 0)
def test_spans_lie_within_rests_and_do_not_overlap(pauses, shares, speed, jitter, seed):
    """Whatever the path and the frames: the tip stands within its noise in a span, and no reading serves two frames."""
    stops = np.cumsum([pause + 3e-4 / speed for pause in pauses])
    seconds, places = path(stops, speed, jitter=jitter, seed=seed)
    exact = path(stops, speed)[1]
    frames = np.unique(np.sort(shares) * seconds[-1])
    spans = rest_spans(frames, seconds, places)
    known = np.isfinite(spans).all(axis=1)
    starts, ends = spans[known].T
    assert (starts < ends).all()
    assert (ends[:-1] <= starts[1:] + 1e-12).all()
    for start, end in spans[known]:
        depth = np.interp([start, end], seconds, exact[:, 2])
        assert np.ptp(depth) < 1e-6 + jitter
        # at least SETTLED after the last stop, and before the next move
        ended = stops + 3e-4 / speed
        assert all(start - stop > SETTLED - 2 / RATE for stop in ended[ended <= start])
        assert all(move - end > BEFORE_MOVE - 2 / RATE for move in stops[stops >= end])


def test_a_frame_in_a_move_or_just_after_has_no_span():
    """At 1 mm/s from 1 s to 1.3 s: no means at 1.1 s, nor at 1.32 s where the arm still swings, but at 0.5 and 2 s."""
    seconds, places = path([1.0])
    spans = rest_spans(np.array([0.5, 1.1, 1.32, 2.0]), seconds, places)
    assert np.isfinite(spans).all(axis=1).tolist() == [True, False, False, True]


def test_readings_reach_no_further_than_a_share_of_the_rest():
    """Forces relax in proportion to the logarithm of time: 0.4 s after a stop at 1.3 s a mean is at most 0.2 s wide."""
    seconds, places = path([1.0], end=5.0)
    start, end = rest_spans(np.array([1.7]), seconds, places)[0]
    assert end == pytest.approx(1.7 + SHARE_OF_REST * 0.4, abs=0.01)
    assert (end - start) / 2 == pytest.approx(SHARE_OF_REST * ((start + end) / 2 - 1.3), abs=0.01)


def test_nothing_is_averaged_where_positions_are_too_noisy_to_see_a_stop():
    """Positions with 20 um of noise do not say when a tip stands."""
    seconds, places = path([1.0], jitter=2e-5)
    assert not np.isfinite(rest_spans(np.array([0.5, 2.0]), seconds, places)).any()


def test_jitter_is_the_deviation_of_the_noise():
    """Half of the path moves: second differences of a straight move are 0."""
    places = path([1.0, 2.0, 3.0], speed=5e-4, step=3e-4, jitter=2e-6)[1]
    assert position_jitter(places) == pytest.approx(2e-6, rel=0.15)
    assert position_jitter(path([1.0])[1]) < 1e-12


@given(st.floats(-5.0, 5.0), st.floats(-2.0, 2.0))
def test_a_force_in_proportion_to_time_is_read_exactly(level, slope):
    """The time of a mean is that of its readings: a force that changes evenly is not distorted."""
    seconds, places = path([1.0, 2.0])
    readings = readings_of(lambda times: level + slope * times, seconds)
    frames = np.array([0.3, 0.9, 1.1, 1.8, 2.9])
    wrench = np.column_stack([np.interp(frames, readings.seconds, column) for column in readings.wrench.T])
    found = means_at_rest(frames, wrench, rest_spans(frames, seconds, places), readings)
    assert (found.readings > 0).tolist() == [True, True, False, True, True]
    assert (np.diff(found.seconds) > 0).all()
    np.testing.assert_allclose(found.wrench[:, 2], level + slope * found.seconds, atol=1e-9)


def test_relaxation_is_distorted_by_less_than_a_hundredth_of_itself():
    """A force that falls by 1 N with time constants from 0.05 to 2 s after a stop; frames from 0.1 s on."""
    seconds, places = path([1.0], end=5.0)
    frames = 1.3 + np.array([0.12, 0.2, 0.4, 0.8, 1.6, 3.2])
    for constant in (0.05, 0.2, 0.5, 2.0):

        def force(times, constant=constant):
            return np.exp(-np.maximum(times - 1.3, 0.0) / constant)

        readings = readings_of(force, seconds, rate=500.0)
        wrench = np.zeros((len(frames), 6))
        found = means_at_rest(frames, wrench, rest_spans(frames, seconds, places), readings)
        assert (found.readings > 0).all()
        np.testing.assert_allclose(found.wrench[:, 2], force(found.seconds), atol=0.01)


def test_a_frame_with_an_unknown_reading_stays_interpolated():
    """A gap in the readings, and a wrench that is unknown, are left as they are."""
    seconds, places = path([1.0])
    readings = readings_of(np.ones_like, seconds)
    readings.wrench[np.abs(readings.seconds - 0.5) < 0.02] = np.nan
    frames, wrench = np.array([0.5, 1.9, 2.2]), np.full((3, 6), 7.0)
    wrench[2] = np.nan
    found = means_at_rest(frames, wrench, rest_spans(frames, seconds, places), readings)
    assert found.readings[0] == found.readings[2] == 0 < found.readings[1]
    assert found.seconds[0] == 0.5
    assert found.wrench[0, 2] == 7.0
    assert found.wrench[1, 2] == 1.0
    assert np.isnan(found.wrench[2]).all()

"""A wrench that is read late is that of the place where the tip was, not of a mean over a rest and a move."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.effects.closed_form.ball_on_layer import BallOnLayer
from tactiledata.effects.sensor.lag import Lag
from tactiledata.effects.time.clock_skew import ClockSkew
from tactiledata.effects.touch.earlier_places import DELAYS, delayed_along, earlier_places
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.time_operators import delayed

STIFFNESS = 8e3
"""N/m of a contact whose force is in proportion to its depth."""
STREAM = np.arange(0.0, 4.0, 0.004)
FRAMES = np.array([0.3, 0.9, 1.12, 1.2, 1.9, 2.15, 2.9])
"""Frames at rest, in the move down from 1.0 to 1.3 s, at rest, and in the move up from 2.0 to 2.3 s."""


def depth(seconds):
    """Depth, m: 0.3 mm down at 1 mm/s from 1.0 s on, and up again from 2.0 s on."""
    return 1e-3 * (np.clip(seconds - 1.0, 0.0, 0.3) - np.clip(seconds - 2.0, 0.0, 0.3))


def places(seconds):
    """Positions of the tip (m, 3)."""
    return np.column_stack([np.zeros_like(seconds), np.zeros_like(seconds), -depth(seconds)])


def wrench(seconds):
    """Wrench (n, 6) of the contact."""
    found = np.zeros((len(seconds), 6))
    found[:, 2] = STIFFNESS * depth(seconds)
    return found


EARLIER = earlier_places(FRAMES, STREAM, places(STREAM))


@given(st.floats(-0.15, 0.15))
def test_a_late_force_is_that_of_the_earlier_place(delay):
    """For every delay of up to 150 ms, early or late, where both neighbours of the moment are frames of one move."""
    found = delayed_along(FRAMES, wrench(FRAMES), places(FRAMES), EARLIER, delay)
    # places are linear between the delays at which they are known: exact where the tip does not stop in between
    away = np.abs(found[:, 2] - STIFFNESS * depth(FRAMES - delay))
    assert away.max() <= 0.45
    if abs(delay) <= 0.02:
        assert away.max() < 0.05


def test_at_20_ms_the_path_is_right_and_the_time_is_not():
    """In the first move 0.16 N are missing; linear in time between a frame at rest and one in the move, a third."""
    expected = STIFFNESS * depth(FRAMES - 0.02)
    by_path = delayed_along(FRAMES, wrench(FRAMES), places(FRAMES), EARLIER, 0.02)[:, 2]
    by_time = delayed(FRAMES, wrench(FRAMES), 0.02)[:, 2]
    np.testing.assert_allclose(by_path, expected, atol=1e-9)
    assert abs(by_time[2] - expected[2]) > 0.05


def test_without_places_and_beyond_them_time_decides():
    """No places, or a delay longer than they reach: as `delayed`."""
    for earlier, delay in ((None, 0.02), (EARLIER, 0.5)):
        found = delayed_along(FRAMES, wrench(FRAMES), places(FRAMES), earlier, delay)
        np.testing.assert_array_equal(found, delayed(FRAMES, wrench(FRAMES), delay))


def test_unknown_wrenches_stay_unknown():
    """A frame without a wrench has none later either, and serves no other frame."""
    felt = wrench(FRAMES)
    felt[3] = np.nan
    found = delayed_along(FRAMES, felt, places(FRAMES), EARLIER, 0.02)
    assert np.isnan(found[3]).all()
    assert np.isfinite(np.delete(found, 3, axis=0)).all()


@pytest.fixture
def state(touch):
    poses = np.tile(np.eye(4), (len(FRAMES), 1, 1))
    poses[:, :3, 3] = places(FRAMES)
    path = dataclasses.replace(
        touch, seconds=FRAMES, poses=poses, earlier_places=EARLIER, gravity=None, joints=None, powered=None,
        earlier_depth=None, earlier_contacts=None, tare=None, pace=None, rest=None, last_ways=None,
        felt_accelerations=None, gel_from_sensor=None, sensor_weight=None,
    )  # fmt: skip
    return TouchState.start(path, BallOnLayer(path)).with_reading(wrench(FRAMES))


def test_a_low_pass_of_a_ramp_is_a_delay(state):
    """A first-order filter of 10 ms lags a ramp by 10 ms, once the ramp has lasted ten times as long."""
    found = Lag().change(state, {"delay": 0.0, "filter": 0.01}).wrench[:, 2]
    expected = STIFFNESS * depth(FRAMES - 0.01)
    np.testing.assert_allclose(found[[2, 3, 5]], expected[[2, 3, 5]], atol=0.01)


def test_a_clock_that_runs_fast_delays_more_and_more(state):
    """5 ms a second: 6 ms at 1.2 s."""
    found = ClockSkew().change(state, {"rate": 5e-3, "jump": 0.0, "jump_at": 0.0}).wrench[:, 2]
    np.testing.assert_allclose(found, STIFFNESS * depth(FRAMES * (1 - 5e-3)), atol=1e-9)


def test_places_are_those_of_the_stream():
    """Each row holds the place at the frame's time less each delay."""
    expected = np.stack([places(FRAMES - delay) for delay in DELAYS], axis=1)
    np.testing.assert_allclose(EARLIER, expected, atol=2e-6)

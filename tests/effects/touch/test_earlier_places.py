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
from tactiledata.effects.touch.time_operators import delayed, fading_memory

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


@pytest.mark.parametrize("delay", [-0.02, 0.02])
def test_a_delay_without_a_filter_follows_the_path(state, delay):
    """Every reading is that of the earlier place; without places it is linear in time, and then filtered in time."""
    found = Lag().change(state, {"delay": delay, "filter": 0.0}).wrench[:, 2]
    np.testing.assert_allclose(found, STIFFNESS * depth(FRAMES - delay), atol=1e-9)
    bare = TouchState.start(
        dataclasses.replace(state.touch, earlier_places=None), BallOnLayer(state.touch)
    ).with_reading(wrench(FRAMES))
    by_time = delayed(FRAMES, wrench(FRAMES), delay)
    for time, expected in ((0.0, by_time), (0.05, by_time - fading_memory(FRAMES, by_time, 0.05))):
        found = Lag().change(bare, {"delay": delay, "filter": time}).wrench
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_filter_of_a_second_is_the_mean_over_five_delays(state):
    """Gauss and Laguerre's five nodes, the largest of them 12.64 time constants: beyond the places, linear in time."""
    nodes, weights = np.polynomial.laguerre.laggauss(5)
    for time in (0.01, 1.0):
        parts = [
            weight * delayed_along(FRAMES, wrench(FRAMES), places(FRAMES), EARLIER, time * node)
            for node, weight in zip(nodes, weights, strict=True)
        ]
        found = Lag().change(state, {"delay": 0.0, "filter": time}).wrench
        np.testing.assert_allclose(found, np.sum(parts, axis=0), atol=1e-9)


def test_a_clock_that_runs_fast_delays_more_and_more(state):
    """5 ms a second: 6 ms at 1.2 s."""
    found = ClockSkew().change(state, {"rate": 5e-3, "jump": 0.0, "jump_at": 0.0}).wrench[:, 2]
    np.testing.assert_allclose(found, STIFFNESS * depth(FRAMES * (1 - 5e-3)), atol=1e-9)


def test_places_are_those_of_the_stream():
    """Each row holds the place at the frame's time less each delay."""
    expected = np.stack([places(FRAMES - delay) for delay in DELAYS], axis=1)
    np.testing.assert_allclose(EARLIER, expected, atol=2e-6)


def test_delays_double_from_10_ms_on_and_mirror_each_other():
    """10, 20, ... 320 ms, before a frame and after it, and the frame itself, in ascending order."""
    late = [0.01 * 2**power for power in range(6)]
    assert list(DELAYS) == pytest.approx([-delay for delay in reversed(late)] + [0.0] + late)
    assert earlier_places(FRAMES, STREAM[:0], places(STREAM[:0])).shape == (len(FRAMES), len(DELAYS), 3)


def late_by_hand(delay, frames, stream, depths):
    """Forces, N, read late by hand: 1 N at a frame where the tip is deepest, in proportion to its depth there."""
    stream = np.array(stream)
    tips = np.column_stack([np.zeros((len(stream), 2)), depths])
    frames = np.array(frames)
    at_frames = earlier_places(frames, stream, tips)[:, DELAYS.index(0.0)]
    felt = np.zeros((len(frames), 6))
    felt[:, 2] = at_frames[:, 2] / np.max(depths)
    return delayed_along(frames, felt, at_frames, earlier_places(frames, stream, tips), delay)[:, 2]


@pytest.mark.parametrize("delay", [-0.32, -0.25, -0.17])
def test_a_wrench_that_comes_early_by_a_quarter_of_a_second_follows_the_path(delay):
    """1 mm between 0.9 and 1.1 s: at 0.7 s it reads what the tip reaches 160 and 320 ms later, and between these.

    A wrench that comes late reads the same of a tip that comes the other way.
    """
    share = (-delay - 0.16) / 0.16
    early = late_by_hand(delay, [0.0, 0.7, 2.0], [0.0, 0.9, 1.1, 3.0], [0.0, 0.0, 1e-3, 1e-3])
    assert early[1] == pytest.approx(share * 0.6)
    late = late_by_hand(-delay, [0.0, 1.3, 2.0], [0.0, 0.9, 1.1, 3.0], [1e-3, 1e-3, 0.0, 0.0])
    assert late[1] == pytest.approx(share * 0.6)


def test_a_tip_that_went_further_than_both_frames_reads_the_nearer_frame():
    """Between 1.0 and 2.0 s the tip goes down to 2 mm and comes back to 1 mm: at most the reading of 1 mm is known."""
    found = late_by_hand(0.16, [1.0, 2.0], [0.0, 1.0, 1.8, 1.9, 2.0], [0.0, 0.0, 2e-3, 2e-3, 1e-3])
    at_1_mm = 0.5  # 1 N is the reading at 2 mm
    assert found[1] == pytest.approx(at_1_mm)


@pytest.mark.parametrize(
    ("delay", "expected"), [(0.16, [0.0, 0.84]), (-0.16, [0.16, 1.0])], ids=["before the first", "after the last"]
)
def test_moments_without_frames_around_them_hold_the_nearest(delay, expected):
    """Deep at 0.84 s, before the first frame, and shallow at 2.16 s, after the last: neither was a frame's."""
    stream = [0.0, 0.85, 0.86, 1.0, 2.0, 2.1, 2.11, 3.0]
    found = late_by_hand(delay, [1.0, 2.0], stream, [1e-3, 1e-3, 0.0, 0.0, 1e-3, 1e-3, 0.0, 0.0])
    assert found == pytest.approx(expected)


@pytest.mark.parametrize(("way", "expected"), [(2.9e-6, 0.84), (3.1e-6, 1.0)])
def test_a_tip_that_moves_less_than_3_micrometres_stands(way, expected):
    """A jump of the pose between two frames: below 3 um the wrench follows the time, above it the path."""
    found = late_by_hand(0.16, [1.0, 2.0], [0.0, 1.5, 1.501, 3.0], [0.0, 0.0, way, way])
    assert found[1] == pytest.approx(expected)

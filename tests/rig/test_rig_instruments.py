"""Instruments of the rig: messages, noise, clocks, pictures."""

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactiledata.rig.contact.footprint import GelGrid
from tactiledata.rig.logs import imperfections, ros2_messages
from tactiledata.rig.logs.reflectance import Camera, Optics
from tactiledata.rig.scenario.scenario import ClockSetup, Gel, Imperfections
from tactiledata.sensors.backgrounds import load_background

GRID = GelGrid.of(Gel())
BACKGROUND = load_background("digit-bg-2")


@pytest.mark.parametrize("stream", list(ros2_messages.TOPICS))
def test_fast_messages_equal_those_of_rosbags(stream):
    """Patched bytes are what rosbags serialises, message by message."""
    rng = np.random.default_rng(0)
    columns = {"tcp": 7}.get(stream, 6)
    values = rng.normal(size=(5, columns))
    stamps = 1_700_000_000_000_000_000 + np.cumsum(rng.integers(1, 10**10, 5))
    message = ros2_messages.serialise(stream, stamps, values)
    rows = ros2_messages.wire_values(stream, stamps, values)
    for index in range(5):
        assert message(index) == ros2_messages.serialise_slowly(stream, int(stamps[index]), rows[index])


def test_joints_travel_by_name_not_by_place():
    """The driver's order is not that of the arm; names say which is which, and velocities follow."""
    stamps = np.arange(3) * 10**9
    values = np.arange(18.0).reshape(3, 6)
    message = ros2_messages.serialise("joints", stamps, values)
    decoded = ros2_messages.typestore().deserialize_cdr(message(1), "sensor_msgs/msg/JointState")
    by_name = dict(zip(decoded.name, decoded.position, strict=True))
    assert [by_name[name] for name in ros2_messages.JOINT_NAMES] == values[1].tolist()
    assert decoded.name[0] != "shoulder_pan_joint"
    np.testing.assert_allclose(decoded.velocity, 6.0)


@given(st.floats(20, 500), st.floats(0, 1e-3), st.integers(0, 2**40))
def test_sampling_times_increase_and_keep_their_rate(rate, jitter, seed):
    """Jitter never turns time back, to the nanosecond and far from 1970."""
    start = 1_700_000_000_000_000_000
    times = imperfections.sampling_times(start, start + 2 * 10**9, rate, jitter, np.random.default_rng(seed))
    assert times.dtype == np.int64
    assert (np.diff(times) > 0).all()
    assert abs(len(times) - 2 * rate) <= 1
    without = imperfections.sampling_times(start, start + 2 * 10**9, 100.0, 0.0, np.random.default_rng(0))
    assert set(np.diff(without)) == {10_000_000}


def test_a_slow_sensor_repeats_its_values():
    """A 62.5 Hz sensor sampled at 100 Hz has 62.5 new values a second, in runs of one or two."""
    seconds = np.arange(400) / 100.0
    values = imperfections.held(np.arange(400.0)[:, None], seconds, 62.5)[:, 0]
    assert len(np.unique(values)) == pytest.approx(250, abs=1)
    assert np.unique(np.unique(values, return_counts=True)[1]).tolist() == [1, 2]


def test_messages_arrive_late_and_in_order():
    """The recorder's clock never runs back, and no message arrives before it was taken."""
    host = np.arange(1000) * 2_000_000
    arrivals = imperfections.arrival_times(host, ClockSetup(latency=3e-3), np.random.default_rng(0))
    assert (np.diff(arrivals) >= 0).all()
    assert (arrivals >= host).all()


def test_noise_has_the_stated_size_and_memory():
    """Standard deviation and correlation of the force noise are those of the scenario."""
    setup = Imperfections(coloured_share=1.0, correlation_time=0.5)
    noise = imperfections.coloured_noise(200_000, np.array([0.1]), 100.0, setup, np.random.default_rng(0))[:, 0]
    assert noise.std() == pytest.approx(0.1 * np.sqrt(2), rel=0.02)
    lagged = np.corrcoef(noise[:-20], noise[20:])[0, 1]
    assert lagged == pytest.approx(0.5 * np.exp(-0.2 / 0.5), abs=0.03)


def bump(amplitude=4e-4, width=1.5e-3):
    x, y = np.meshgrid(GRID.x, GRID.y)
    return (-amplitude * np.exp(-(x**2 + y**2) / width**2)).astype(np.float32)


def quiet_camera(**stated):
    plain = {"noise": 0.0, "centre": [0.0, 0.0], "turn": 0.0, "distortion": 0.0}
    return Camera(Optics.of_unit("D1", 0, {**plain, **stated}), BACKGROUND, GRID)


def test_a_gel_at_rest_looks_like_its_background():
    """Without contact and noise the picture is the real background, bit for bit; with noise, up to that noise."""
    camera = quiet_camera()
    np.testing.assert_array_equal(camera.picture(camera.at_rest, np.random.default_rng(0)), BACKGROUND)
    noisy = quiet_camera(noise=2.0)
    difference = noisy.picture(noisy.at_rest, np.random.default_rng(0)).astype(float) - BACKGROUND
    assert difference.std() == pytest.approx(2.0, rel=0.05)


def test_lights_come_from_their_sides():
    """Red stands left, green right, blue below: the flank of a dent that faces a light turns to its colour."""
    change = quiet_camera().picture(bump(), np.random.default_rng(0)).astype(float) - BACKGROUND
    left, right, below = change[160, 100], change[160, 140], change[185, 120]
    assert left[0] > max(left[1], left[2], 5)
    assert right[1] > max(right[0], right[2], 5)
    assert below[2] > max(below[0], below[1], 5)


def test_far_from_the_contact_nothing_changes():
    """Negative control: the corners keep the background."""
    picture = quiet_camera().picture(bump(), np.random.default_rng(0))
    np.testing.assert_array_equal(picture[:40, :40], BACKGROUND[:40, :40])


def test_an_unmirrored_driver_turns_the_view_over():
    """The shift of a dent to +x is a shift to the right as the camera sees it, to the left where the driver flips."""
    shifted = np.roll(bump(), 30, axis=1)
    columns = []
    for mirrored in (True, False):
        change = quiet_camera(mirrored=mirrored).picture(shifted, np.random.default_rng(0)).astype(float) - BACKGROUND
        weight = np.abs(change).sum(axis=(0, 2))
        columns.append((weight * np.arange(240)).sum() / weight.sum())
    assert columns[0] > 140 > 100 > columns[1]


def test_units_differ_and_the_same_unit_does_not():
    """Optics are drawn from seed and serial; what is stated is kept."""
    assert Optics.of_unit("D1", 0, {}) == Optics.of_unit("D1", 0, {})
    assert Optics.of_unit("D1", 0, {}) != Optics.of_unit("D2", 0, {})
    assert Optics.of_unit("D1", 0, {"gamma": 1.5}).gamma == 1.5


@pytest.mark.slow
def test_pictures_are_quick():
    """One core draws at least 40 pictures in a second of processor time."""
    camera, rng, height = Camera(Optics.of_unit("D1", 0, {}), BACKGROUND, GRID), np.random.default_rng(0), bump()
    camera.picture(height, rng)
    began = time.process_time()
    for _ in range(20):
        camera.picture(height, rng)
    assert (time.process_time() - began) / 20 < 1 / 40

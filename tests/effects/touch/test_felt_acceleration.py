"""What a tool on a swinging arm feels of a move."""

import dataclasses

import numpy as np
import pytest

from tactiledata.effects.touch.felt_acceleration import DAMPING, FREQUENCIES, RATE, _mode, felt_accelerations, felt_at
from tactiledata.errors import UsageError

FRAMES = np.arange(1.02, 2.0, 0.013)


@pytest.fixture(autouse=True)
def _fresh_filters():
    """Each test designs the filters that it uses."""
    _mode.cache_clear()


def stream(seconds, way):
    return seconds, np.outer(way, [0.6, 0.0, -0.8])


def ringing(t, frequency):
    """Acceleration of a mode whose base is set to a unit of speed at t = 0: w^2 / w_d e^(-d w t) sin(w_d t)."""
    w = 2 * np.pi * frequency
    damped = w * np.sqrt(1 - DAMPING**2)
    return w * w / damped * np.exp(-DAMPING * w * t) * np.sin(damped * t)


@pytest.mark.parametrize("rate", [125.0, 500.0])
def test_a_start_and_a_stop_ring_as_the_closed_form_says(rate):
    """3 mm/s from 0 to 1 s; where the clock begins is the same to it."""
    seconds = np.arange(0.0, 2.5, 1.0 / rate)
    way = 3e-3 * np.minimum(seconds, 1.0)
    felt = felt_accelerations(FRAMES, *stream(seconds, way))
    np.testing.assert_allclose(felt_accelerations(FRAMES + 1.0, *stream(seconds + 1.0, way)), felt, atol=1e-9)
    for column, frequency in enumerate(FREQUENCIES[:20]):
        expected = 3e-3 * (ringing(FRAMES, frequency) - ringing(FRAMES - 1.0, frequency))
        largest = 3e-3 * 2 * np.pi * frequency
        np.testing.assert_allclose(felt[:, column], np.outer(expected, [0.6, 0.0, -0.8]), atol=0.06 * largest)


def test_a_steady_acceleration_is_felt_as_it_is_and_steady_speed_not_at_all():
    """A steady acceleration is felt as it is when the start has rung out, in every mode, and a steady speed is not."""
    seconds = np.arange(0.0, 6.0, 0.002)
    late = np.array([4.0, 5.0, 5.5])
    pushed = felt_accelerations(late, *stream(seconds, 0.5 * 0.2 * seconds**2))
    np.testing.assert_allclose(pushed, np.broadcast_to(0.2 * np.array([0.6, 0.0, -0.8]), pushed.shape), rtol=0.03)
    np.testing.assert_allclose(felt_accelerations(late, *stream(seconds, 2e-3 * seconds)), 0.0, atol=1e-6)


def test_noise_of_the_places_grows_with_the_square_of_the_frequency_at_most():
    """Noise of the positions reaches the accelerations with at most the square of the frequency."""
    seconds = np.arange(0.0, 4.0, 0.002)
    noise = 1e-6 * np.random.default_rng(0).normal(size=(len(seconds), 3))
    felt = felt_accelerations(np.arange(1.0, 4.0, 0.01), seconds, noise)
    assert (felt.std(axis=(0, 2)) < 2e-6 * (2 * np.pi * np.array(FREQUENCIES)) ** 2).all()


def test_between_neighbouring_frequencies_little_is_lost():
    """Each column lies within a third of the mean of its neighbours, so that half as far away little is lost."""
    seconds = np.arange(0.0, 2.5, 1.0 / RATE)
    felt = felt_accelerations(FRAMES, *stream(seconds, 3e-3 * np.minimum(seconds, 1.0)))
    between = 0.5 * (felt[:, :-2] + felt[:, 2:])
    assert (np.abs(between - felt[:, 1:-1]).max(axis=(0, 2)) < 0.35 * np.abs(felt[:, 1:-1]).max(axis=(0, 2))).all()
    for column, frequency in enumerate(FREQUENCIES):
        np.testing.assert_allclose(felt_at(felt, frequency), felt[:, column], atol=1e-12)
    middle = np.sqrt(FREQUENCIES[6] * FREQUENCIES[7])
    np.testing.assert_allclose(felt_at(felt, middle), 0.5 * (felt[:, 6] + felt[:, 7]), atol=1e-12)


def test_a_clock_that_jumps_is_a_new_start_and_costs_nothing():
    """A day without positions, and frames a day after the last: at rest; beside the gap all is as without it."""
    seconds = np.arange(0.0, 2.5, 1.0 / RATE)
    way = 3e-3 * np.minimum(seconds, 1.0)
    felt = felt_accelerations(FRAMES, *stream(seconds, way))
    twice = np.concatenate([seconds, 86400.0 + seconds]), np.concatenate([way, way])
    found = felt_accelerations(np.concatenate([FRAMES, [3600.0], 86400.0 + FRAMES, [2e5]]), *stream(*twice))
    np.testing.assert_allclose(found[: len(FRAMES)], felt)
    np.testing.assert_allclose(found[len(FRAMES) + 1 : -1], felt, atol=1e-6)
    assert not found[[len(FRAMES), -1]].any()


def test_a_stream_of_no_positions_tells_of_no_acceleration():
    """Without positions all accelerations are 0."""
    assert not felt_accelerations(FRAMES, np.zeros(0), np.zeros((0, 3))).any()


def test_inertia_is_what_is_felt_times_mass(touch, play):
    """Inertia is mass times what is felt from the stream, not from the frames; a field of another shape is refused."""
    felt = np.random.default_rng(1).normal(size=(len(touch), len(FREQUENCIES), 3))
    told = dataclasses.replace(touch, felt_accelerations=felt)
    change = play("inertia", on=told, mass=0.5, frequency=FREQUENCIES[5]).wrench - play(on=told).wrench
    np.testing.assert_allclose(change[:, :3], -0.5 * felt[:, 5], atol=1e-12)
    assert (change[:, 3:] == 0).all()
    with pytest.raises(UsageError, match="felt_accelerations"):
        dataclasses.replace(touch, felt_accelerations=felt[:, :3])


def test_the_filter_of_a_mode_is_designed_once():
    """Recordings have thousands of touches, each with all modes."""
    assert _mode(7.5) is _mode(7.5)


def test_positions_at_the_rate_of_integration_are_answered_exactly():
    """Straight pieces of 2 ms give the closed form to rounding, in every mode with a tenth of critical damping."""
    seconds = np.arange(1251) / 500.0
    frames = seconds[[5, 100, 500, 501, 750, 1000, 1250]]
    felt = felt_accelerations(frames, *stream(seconds, 3e-3 * np.minimum(seconds, 1.0)))
    for column, frequency in enumerate(FREQUENCIES):
        w = 2 * np.pi * frequency
        damped = w * np.sqrt(0.99)
        starts = [np.where(t > 0, np.exp(-0.1 * w * t) * np.sin(damped * t), 0.0) for t in (frames, frames - 1.0)]
        expected = 3e-3 * w * w / damped * (starts[0] - starts[1])
        np.testing.assert_allclose(felt[:, column], np.outer(expected, [0.6, 0.0, -0.8]), atol=1e-8)


@pytest.mark.parametrize(("gap", "goes_on"), [(1.9, True), (2.1, False)])
def test_after_two_seconds_without_a_position_a_mode_starts_anew(gap, goes_on):
    """A tip that moved on meanwhile is felt to have moved only where the gap is shorter."""
    before = np.arange(501) / 500.0
    seconds = np.concatenate([before, before + 1.0 + gap])
    way = np.concatenate([np.zeros(501), np.full(501, 5e-3)])
    felt = felt_accelerations(1.0 + gap + np.array([0.01, 0.05]), *stream(seconds, way))
    assert felt.any() == goes_on


def test_frames_up_to_two_seconds_after_the_last_position_still_ring():
    """Later ones are at rest, and so are those before the first."""
    seconds = np.arange(501) / 500.0
    frames = np.array([-0.1, 1.5, 2.9, 3.1])
    felt = felt_accelerations(frames, *stream(seconds, 3e-3 * seconds))
    assert [bool(row.any()) for row in felt] == [False, True, True, False]


def test_the_modes_are_a_twentieth_apart():
    """The modes go from 6 to 40 Hz, each 5 % above the one before, to the rounding of two decimals."""
    assert (FREQUENCIES[0], FREQUENCIES[-1]) == (6.0, 40.0)
    np.testing.assert_allclose(np.divide(FREQUENCIES[1:], FREQUENCIES[:-1]), 1.0512, atol=2e-3)


@pytest.mark.parametrize(("asked", "column"), [(6.0, 0), (5.0, 0), (40.0, 38), (50.0, 38)])
def test_beyond_the_modes_the_outermost_is_felt(asked, column):
    """Below 6 Hz the mode of 6 Hz is felt, and above 40 Hz that of 40 Hz."""
    felt = np.random.default_rng(2).normal(size=(3, 39, 3))
    np.testing.assert_allclose(felt_at(felt, asked), felt[:, column], atol=1e-12)

"""The noise of a mean of readings is what draws of that noise have."""

import numpy as np
import pytest

from tactiledata.nuisance.noise import SMALLEST_FACTOR, noise_at_rest, specified_noise
from tactiledata.sensors.robotiq_ft300s import ROBOTIQ_FT300S


def readings(memory, count, rows, seed):
    """``count`` stretches of ``rows`` readings whose noise falls to the share ``memory`` from one to the next."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(size=(count, rows + 200, 6))
    for row in range(1, rows + 200):
        noise[:, row] = memory * noise[:, row - 1] + np.sqrt(1 - memory**2) * noise[:, row]
    return 0.1 * noise[:, 200:]


@pytest.mark.parametrize("memory", [0.0, 0.6, 0.9])
def test_means_scatter_as_predicted(memory):
    """Means of 4, 10 and 30 readings, of noise without and with memory, against 400 other stretches."""
    noise = noise_at_rest(list(readings(memory, 60, 120, 0)), 10, [0.5])
    others = readings(memory, 400, 40, 1)
    at_frames = others[:, :2].mean(axis=1).std()
    counts = np.array([4, 10, 30])
    found = [others[:, :count].mean(axis=1).std() / at_frames for count in counts]
    np.testing.assert_allclose(noise.mean_factors(counts), np.maximum(found, SMALLEST_FACTOR), rtol=0.12)


def test_a_wrench_that_is_interpolated_has_the_noise_of_a_frame():
    """No readings mean no change, and no mean is noisier than a single frame."""
    noise = noise_at_rest(list(readings(0.9, 20, 120, 0)), 10, [0.5])
    assert noise.mean_factors(np.array([0])).tolist() == [1.0]
    assert (noise.mean_factors(np.arange(1, 50)) <= 1.0).all()


def test_noise_that_never_averages_out_leaves_a_floor():
    """Of the data sheet's noise, whose memory nobody states, a mean of 1000 readings keeps a fifth."""
    noise = specified_noise(ROBOTIQ_FT300S.force)
    assert noise.mean_factors(np.array([4, 1000])).tolist() == [0.5, SMALLEST_FACTOR]

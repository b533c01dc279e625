"""How much the mean of readings that remember each other scatters."""

import numpy as np
import pytest

from tactiledata.nuisance.noise import noise_at_rest

READINGS, STRETCHES = 400, 40


def stretches(correlation, seed=0):
    """Stretches of readings of an AR(1) process of variance 1."""
    chance = np.random.default_rng(seed)
    found = []
    for _ in range(STRETCHES):
        values = chance.normal(size=(READINGS, 6))
        for row in range(1, READINGS):
            values[row] = correlation * values[row - 1] + np.sqrt(1 - correlation**2) * values[row]
        found.append(values)
    return found


@pytest.mark.parametrize("correlation", [0.3, 0.6, 0.8])
def test_the_memory_is_that_of_the_process(correlation):
    """An AR(1) process has (1 + r) / (1 - r) times the variance of a mean of independent readings."""
    memory = noise_at_rest(stretches(correlation)).memory
    assert memory == pytest.approx((1 + correlation) / (1 - correlation), rel=0.15)


def test_independent_readings_have_none():
    """White noise is given no memory."""
    assert noise_at_rest(stretches(0.0)).memory == pytest.approx(1.0, abs=0.05)


def test_stretches_of_any_length_count():
    """A stretch that is far shorter than the others adds its few products, and changes the memory little."""
    long = stretches(0.6)
    alone, beside = (noise_at_rest(parts).memory for parts in (long, [*long, long[0][:5], long[1][:40]]))
    assert beside == pytest.approx(alone, rel=0.02)

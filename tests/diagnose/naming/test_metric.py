"""Cosines in the metric of a fit: closed forms, and fields that a refit imitates."""

import numpy as np
import pytest

from tactiledata.diagnose.naming.metric import RandomEffects, cosines


@pytest.fixture
def metric():
    """Two trajectories without offsets; one free parameter changes the first component of every frame alike."""
    shared = np.zeros((4, 6, 1))
    shared[:, 0, 0] = 1.0
    return RandomEffects(np.zeros((4, 6)), shared, np.zeros(1), np.array([0, 2]))


def field(component, values):
    changed = np.zeros((4, 6))
    changed[:, component] = values
    return changed


def test_cosines_are_those_of_what_a_refit_leaves(metric):
    """Less their means, (3, 1, 1, 1) and (1, 0, 0, 0) are parallel; another component is at right angles."""
    found = cosines(metric, [field(0, [3, 1, 1, 1]), field(0, [1, 0, 0, 0]), field(2, [1, 2, 3, 4])])
    np.testing.assert_allclose(found, [[1, 1, 0], [1, 1, 0], [0, 0, 1]], atol=1e-12)


def test_what_a_refit_imitates_resembles_nothing(metric):
    """Fields in the span of a free parameter leave rounding errors, which point nowhere; so does a field of zeros."""
    noise = np.random.default_rng(0).normal(size=(4, 6))
    found = cosines(metric, [noise, field(0, 2.0), field(0, -1e3), field(3, 0.0)])
    expected = np.zeros((4, 4))
    expected[0, 0] = 1.0
    np.testing.assert_allclose(found, expected, atol=1e-12)

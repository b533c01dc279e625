"""Shear remembers the way: shifts that change relieve it, shifts that stay do not."""

import numpy as np
import pytest

from tactiledata.diagnose.shear_memory import friction_change, shear_change, shear_stiffness

FRAMES = 21
PATH = np.column_stack([np.linspace(0.0, 1e-4, FRAMES), np.zeros(FRAMES)])
STIFFNESS = np.full(FRAMES, 3e-3)
FAR = np.full(FRAMES, 1.0)


def test_a_spring_in_series_shares_the_way():
    """Where nothing slides, yielding by c F leaves k / (1 + c k) of the stiffness."""
    yielding = 0.5 / STIFFNESS[0]
    force = -STIFFNESS[0] * PATH / (1 + yielding * STIFFNESS[0])
    changed = shear_change(PATH, yielding * force, STIFFNESS, FAR)
    assert np.allclose(-STIFFNESS[0] * PATH + changed, force)


def test_what_slides_stays_at_its_limit():
    """At the end of a slide that is ten times as long as it sticks, a shift that has come to rest is forgotten."""
    limit = np.full(FRAMES, 0.1 * STIFFNESS[0] * PATH[-1, 0])
    shift = np.zeros_like(PATH)
    shift[5:, 0] = -1e-5
    changed = shear_change(PATH, shift, STIFFNESS, limit)
    assert changed[5, 0] > 0
    assert np.allclose(changed[-1], 0.0)


def test_a_shift_that_stays_changes_nothing_and_air_forgets():
    assert not shear_change(PATH, np.full_like(PATH, 3e-4), STIFFNESS, FAR).any()
    limit = FAR.copy()
    limit[10] = 0.0
    shift = np.zeros_like(PATH)
    shift[5:, 1] = 2e-5
    changed = shear_change(PATH, shift, STIFFNESS, limit)
    assert changed[9, 1] < 0
    assert not changed[11:].any()


def test_stiffness_has_both_limits():
    small, wide, thickness, ratio = np.array([1e-8]), np.array([1e-2]), 4e-3, 0.48
    modulus = 0.5 / (1 + ratio)
    assert shear_stiffness(small, ratio, thickness)[0] == pytest.approx(
        8 * modulus * np.sqrt(small[0] / np.pi) / (2 - ratio), rel=0.05
    )
    assert shear_stiffness(wide, ratio, thickness)[0] == pytest.approx(modulus * wide[0] / thickness, rel=0.15)


def test_what_slid_further_is_missing_afterwards():
    """A dip of the limit in one frame relieves the shear that sticks from then on, by what it slid; none before."""
    limit = FAR.copy()
    limit[10] = 0.5 * STIFFNESS[0] * PATH[10, 0]
    changed = friction_change(PATH, STIFFNESS, FAR, limit)
    slid = STIFFNESS[0] * PATH[10, 0] - limit[10]
    assert not changed[:10].any()
    assert np.allclose(changed[10:, 0], slid)


def test_a_limit_that_is_not_reached_changes_nothing():
    """And a slide to the end has the limit of its end, whatever was before."""
    assert not friction_change(PATH, STIFFNESS, FAR, 2.0 * FAR).any()
    low, high = np.full(FRAMES, 1e-8), np.linspace(1e-8, 2e-8, FRAMES)
    assert np.allclose(friction_change(PATH, STIFFNESS, low, high)[:, 0], low - high, atol=1e-12)

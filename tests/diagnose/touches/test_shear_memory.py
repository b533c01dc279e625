"""Shear remembers the way: shifts that change relieve it, shifts that stay do not."""

import numpy as np

from tactiledata.diagnose.touches.friction_history import Sliders, shear_change

FRAMES = 21
PATH = np.column_stack([np.linspace(0.0, 1e-4, FRAMES), np.zeros(FRAMES)])
STIFFNESS = np.full(FRAMES, 3e-3)
FAR = np.full(FRAMES, 1.0)


def test_a_spring_in_series_shares_the_way():
    """Where nothing slides, yielding by c F leaves k / (1 + c k) of the stiffness."""
    yielding = 0.5 / STIFFNESS[0]
    force = -STIFFNESS[0] * PATH / (1 + yielding * STIFFNESS[0])
    changed = shear_change(PATH, yielding * force, STIFFNESS, FAR, Sliders())
    assert np.allclose(-STIFFNESS[0] * PATH + changed, force)


def test_what_slides_stays_at_its_limit():
    """At the end of a slide that is ten times as long as it sticks, a shift that has come to rest is forgotten."""
    limit = np.full(FRAMES, 0.1 * STIFFNESS[0] * PATH[-1, 0])
    shift = np.zeros_like(PATH)
    shift[5:, 0] = -1e-5
    changed = shear_change(PATH, shift, STIFFNESS, limit, Sliders())
    assert changed[5, 0] > 0
    assert np.allclose(changed[-1], 0.0)


def test_a_shift_that_stays_changes_nothing_and_air_forgets():
    """A constant shift changes no shear, and after a frame without friction limit an earlier shift has no influence."""
    assert not shear_change(PATH, np.full_like(PATH, 3e-4), STIFFNESS, FAR, Sliders(1.1, 0.4)).any()
    limit = FAR.copy()
    limit[10] = 0.0
    shift = np.zeros_like(PATH)
    shift[5:, 1] = 2e-5
    changed = shear_change(PATH, shift, STIFFNESS, limit, Sliders())
    assert changed[9, 1] < 0
    assert not changed[11:].any()

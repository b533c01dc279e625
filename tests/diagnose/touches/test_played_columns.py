"""The compiled readers of columns say what slow ones say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.interpolate import PchipInterpolator

from tactiledata.diagnose.touches.played_columns import AREA, LEAST_FORCE, cubics_at, pressed, wrench_at_height
from tactiledata.effects.touch.state import wrench_at

COUNT = 5
NUMBERS = st.floats(-3.0, 3.0, allow_subnormal=False)


def some(*shape):
    return arrays(np.float64, shape, elements=NUMBERS)


@given(some(COUNT, 7), some(COUNT), some(COUNT, 3), some(COUNT, 2))
def test_a_contact_is_where_its_torques_say_and_nowhere_else(columns, depth, tips, shift):
    """Its lever times the force, at the height of the tip, is the torque along the gel; nothing without contact."""
    wrench, centre, area, load = pressed(columns, depth, tips, shift)
    for frame in range(COUNT):
        fx, fy, fz, tx, ty = columns[frame, :5]
        if fz > LEAST_FORCE and depth[frame] > 0:
            x, y = centre[frame]
            assert np.array_equal(wrench[frame], columns[frame, :6])
            assert y * fz - tips[frame, 2] * fy == pytest.approx(tx, abs=1e-9)
            assert tips[frame, 2] * fx - x * fz == pytest.approx(ty, abs=1e-9)
            assert (area[frame], load[frame]) == (max(columns[frame, AREA], 0.0), fz)
        else:
            assert not wrench[frame].any()
            assert np.array_equal(centre[frame], tips[frame, :2] + shift[frame])
            assert (area[frame], load[frame]) == (0.0, 0.0)


@given(some(COUNT, 2), some(COUNT, 2), some(COUNT))
def test_forces_along_the_gel_have_the_torques_of_their_height(shear, centre, heights):
    """Compiled torques of forces along the gel are those of the general formula."""
    force, at = np.column_stack([shear, np.zeros(COUNT)]), np.column_stack([centre, heights])
    np.testing.assert_allclose(wrench_at_height(shear, centre, heights), wrench_at(force, at), atol=1e-12)


def test_what_is_unknown_is_none():
    """A place that nobody knows: its torques are left out, its force is not."""
    found = wrench_at_height(np.ones((1, 2)), np.array([[np.nan, 0.0]]), np.zeros(1))
    assert found.tolist() == [[1.0, 1.0, 0.0, 0.0, 0.0, 0.0]]


@given(some(4, COUNT, 3), arrays(np.float64, COUNT, elements=st.floats(0.2, 1.2)))
def test_cubics_are_those_of_the_library(values, places):
    """Cubics agree with scipy between nodes and are constant beyond them, also for part of the frames and columns."""
    nodes = np.array([0.4, 0.5, 0.7, 0.85])
    cubics = PchipInterpolator(nodes, values)
    expected = np.stack([cubics(np.clip(place, 0.4, 0.85))[frame] for frame, place in enumerate(places)])
    np.testing.assert_allclose(cubics_at(nodes, cubics.c, places), expected, atol=1e-12)
    part = cubics_at(nodes, cubics.c[:, :, :-1, :2], places[:-1])
    np.testing.assert_allclose(part, expected[:-1, :2], atol=1e-12)

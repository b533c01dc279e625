"""Aligned values in numbers worked out by hand."""

import numpy as np
import pytest

from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.clocks.align import LINEAR, POSE_COLUMNS, SLERP, align, broken_rotations, fractions_between

START = 1_700_000_000_000_000_000


def signal(times, values, columns=("a",)):
    t_ns = START + np.array(times)
    return StoredSignal(t_ns, np.array(values, float), columns, ("1",) * len(columns), "base", Stamps(t_ns))


def pose(length):
    return [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, length]


@pytest.mark.parametrize(
    ("length", "is_broken"),
    [(0.0, True), (0.899, True), (0.901, False), (1.0, False), (1.099, False), (1.101, True), (np.nan, True)],
)
def test_a_rotation_is_a_quaternion_of_length_one_within_a_tenth(length, is_broken):
    """A tenth is 0.1 on either side; a length that is not known is broken."""
    assert broken_rotations(np.array([pose(length)])).tolist() == [is_broken]
    assert broken_rotations(np.array([[9, 9, 9, 0.6, 0, 0, 0.8]])).tolist() == [False]


def test_how_a_value_came_about_is_said():
    """Numbers are interpolated on a line, poses on the sphere; columns, units and frame are the signal's."""
    line = align(signal([0, 10], [[1.0], [2.0]]), START + np.array([5]))
    assert (line.method, line.columns, line.units, line.frame) == (LINEAR, ("a",), ("1",), "base")
    assert align(signal([0], [pose(1)], POSE_COLUMNS), START + np.array([0])).method == SLERP


def test_a_frame_whose_time_is_off_gets_no_value():
    """Be it at a sample or between two; all other frames have theirs."""
    frames = START + np.array([0, 4, 10, 15, 20, 30])
    found = align(signal([0, 10, 20], [[0.0], [1.0], [2.0]]), frames, np.array([1, 0, 0, 1, 0, 0], bool))
    np.testing.assert_array_equal(found.values[:, 0], [np.nan, 0.4, 1.0, np.nan, 2.0, np.nan])
    assert found.gap_ns.tolist() == [-1, 10, 0, -1, 0, -1]


def test_of_samples_with_one_time_the_first_is_taken():
    """The first of samples with one time is taken, and a sample that is not finite in one column is left out in all."""
    found = align(
        signal([0, 10, 10, 20, 30], [[0, 0], [1, 5], [9, 9], [2, np.nan], [3, 7]], ("a", "b")),
        START + np.array([10, 20]),
    )
    assert found.values.tolist() == [[1, 5], [2, 6]]
    assert found.gap_ns.tolist() == [0, 20]


def test_a_single_sample_is_met_at_its_own_moment_only():
    """One sample has a value there, and none beside it; a pose, too."""
    for values, columns in (([[5.0]], ("a",)), ([pose(1)], POSE_COLUMNS)):
        found = align(signal([10], values, columns), START + np.array([9, 10, 11]))
        assert found.gap_ns.tolist() == [-1, 0, -1]
        assert found.values[1].tolist() == values[0]
        assert np.isnan(found.values[[0, 2]]).all()
        assert np.isnan(align(signal([10], values, columns), START + np.array([9])).values).all()


def test_fractions_at_the_ends_and_between():
    """0 at samples, first and last included; frames outside are left out; repeated samples count once."""
    found = fractions_between(START + np.array([0, 10, 10, 30]), START + np.array([-1, 0, 4, 10, 25, 30, 31]))
    np.testing.assert_allclose(found, [0, 0.4, 0, 0.75, 0], atol=0)
    assert fractions_between(START + np.array([5]), START + np.array([5])).tolist() == [0.0]
    assert fractions_between(START + np.array([5]), START + np.array([6])).tolist() == []

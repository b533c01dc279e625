"""Aligned values lie between their neighbours, and nothing is extrapolated."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tactiledata.contract.records import Stamps
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.clocks.align import POSE_COLUMNS, align, fractions_between

START = 1_700_000_000_000_000_000


def signal(t_ns, values, columns=("a",)):
    return StoredSignal(t_ns, values, columns, ("1",) * len(columns), "", Stamps(t_ns))


def test_a_straight_line_is_met_to_the_nanosecond():
    """Epoch nanoseconds do not lose precision: a linear signal is reproduced exactly."""
    t_ns = START + np.arange(0, 1000, 10)
    aligned = align(signal(t_ns, (t_ns - START)[:, None].astype(float)), START + np.array([5, 7, 990, 123]))
    np.testing.assert_allclose(aligned.values[:, 0], [5, 7, 990, 123], atol=1e-9)
    assert aligned.gap_ns.tolist() == [10, 10, 0, 10]


def test_outside_the_signal_is_nan():
    """Frames before the first and after the last sample get NaN and a gap of -1."""
    aligned = align(signal(START + np.array([10, 20]), np.ones((2, 1))), START + np.array([9, 21]))
    assert np.isnan(aligned.values).all()
    assert aligned.gap_ns.tolist() == [-1, -1]


def test_poses_turn_on_the_sphere():
    """Half way between two turns about z is half the angle, and the quaternion stays a unit one."""
    quaternions = Rotation.from_rotvec([[0, 0, 0], [0, 0, 1.0]]).as_quat()
    poses = np.concatenate([np.array([[0, 0, 0], [1, 2, 3.0]]), quaternions], axis=1)
    aligned = align(signal(START + np.array([0, 100]), poses, POSE_COLUMNS), START + np.array([50]))
    np.testing.assert_allclose(aligned.values[0, :3], [0.5, 1, 1.5])
    np.testing.assert_allclose(Rotation.from_quat(aligned.values[0, 3:]).as_rotvec(), [0, 0, 0.5], atol=1e-12)


def test_a_quaternion_of_zeros_is_left_out():
    """A pose whose quaternion is no rotation is interpolated over, not turned into an error or a number."""
    quaternions = np.array([[0, 0, 0, 1.0], [0, 0, 0, 0], [0, 0, 0, 1]])
    poses = np.concatenate([np.array([[0, 0, 0], [9, 9, 9], [2, 2, 2.0]]), quaternions], axis=1)
    aligned = align(signal(START + np.array([0, 50, 100]), poses, POSE_COLUMNS), START + np.array([50]))
    np.testing.assert_allclose(aligned.values[0, :3], 1.0)
    assert aligned.gap_ns[0] == 100


def test_an_empty_signal_gives_nan():
    """A signal without samples gives NaN, and no crash."""
    aligned = align(signal(np.zeros(0, np.int64), np.zeros((0, 1))), START + np.arange(3))
    assert np.isnan(aligned.values).all()


@given(st.lists(st.tuples(st.integers(0, 30), st.floats(-5, 5) | st.just(np.nan)), min_size=1, max_size=30))
def test_values_stay_between_their_neighbours(samples):
    """Whatever is missing or repeated: a value is NaN, or lies within the range of the finite samples."""
    rows = sorted(samples, key=lambda sample: sample[0])
    t_ns = START + np.array([row[0] for row in rows])
    values = np.array([[row[1]] for row in rows])
    aligned = align(signal(t_ns, values), START + np.arange(31))
    known = np.isfinite(aligned.values[:, 0])
    assert (known == (aligned.gap_ns >= 0)).all()
    if known.any():
        finite = values[np.isfinite(values)]
        assert aligned.values[known].min() >= finite.min() - 1e-9
        assert aligned.values[known].max() <= finite.max() + 1e-9


@given(
    st.lists(st.integers(1, 40), min_size=1, max_size=20),
    st.lists(st.integers(-10, 400), min_size=1, max_size=20),
)
def test_fractions_are_those_that_align_interpolates_with(steps, frames):
    """Of a signal that counts its samples, an aligned value is its sample's number and the fraction."""
    t_ns = START + np.concatenate([[0], np.cumsum(steps)])
    frame_t_ns = START + np.sort(np.array(frames))
    aligned = align(signal(t_ns, np.arange(len(t_ns), dtype=float)[:, None]), frame_t_ns)
    known = aligned.gap_ns >= 0
    expected = aligned.values[known, 0] % 1.0
    np.testing.assert_allclose(fractions_between(t_ns, frame_t_ns), expected, atol=1e-9)


def test_nothing_lies_between_the_samples_of_an_empty_signal():
    """A signal without samples gives no fractions."""
    assert len(fractions_between(np.zeros(0, np.int64), START + np.arange(3))) == 0

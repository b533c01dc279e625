"""Rigid transforms form a group, wrenches keep their power when they move, and poses are found between poses."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tactiledata.errors import SchemaError, UsageError
from tactiledata.transforms import Transform, interpolate_poses, matrix_poses, move_wrench, pose_matrices

LENGTHS = st.floats(-2, 2)
VECTORS = st.tuples(LENGTHS, LENGTHS, LENGTHS)
QUATERNIONS = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
SIX = st.tuples(*[st.floats(-50, 50)] * 6)


def transforms(to, source):
    return st.builds(lambda xyz, xyzw: Transform.from_parts(to, source, xyz, xyzw), VECTORS, QUATERNIONS)


def close(one, other, tolerance=1e-9):
    np.testing.assert_allclose(one, other, rtol=0, atol=tolerance)


@given(transforms("a", "b"))
def test_an_inverse_undoes(a_from_b):
    """Forth and back is identity, on either side, and the inverse of the inverse is the transform."""
    close((a_from_b @ a_from_b.inverse()).matrix, np.eye(4))
    close((a_from_b.inverse() @ a_from_b).matrix, np.eye(4))
    close(a_from_b.inverse().inverse().matrix, a_from_b.matrix)
    assert (a_from_b.inverse().to, a_from_b.inverse().source) == ("b", "a")


@given(transforms("a", "b"), transforms("b", "c"), transforms("c", "d"))
def test_chains_are_associative(one, two, three):
    """Where the brackets stand does not matter, and the inverse of a chain is the chain of inverses, reversed."""
    left, right = (one @ two) @ three, one @ (two @ three)
    close(left.matrix, right.matrix)
    assert (left.to, left.source) == ("a", "d")
    close((one @ two).inverse().matrix, (two.inverse() @ one.inverse()).matrix)


@given(transforms("a", "b"), st.lists(VECTORS, min_size=1, max_size=5))
def test_points_move_rigidly(a_from_b, points):
    """Points agree with the matrix, come back by the inverse, and keep their distances."""
    moved = a_from_b.points(points)
    close(moved, (a_from_b.matrix @ np.column_stack([points, np.ones(len(points))]).T).T[:, :3])
    close(a_from_b.inverse().points(moved), points)
    close(np.linalg.norm(moved - moved[0], axis=1), np.linalg.norm(np.subtract(points, points[0]), axis=1))


def test_frames_that_do_not_meet_are_refused():
    """base_from_tcp after tcp_from_gel makes no sense, and is said."""
    with pytest.raises(UsageError, match="tcp_from_gel cannot be followed by base_from_tcp"):
        Transform.identity("tcp", "gel") @ Transform.identity("base", "tcp")


@given(transforms("a", "b"))
def test_documents_bring_a_transform_back(a_from_b):
    """A transform comes back as it was from translation and quaternion and from a matrix; w is never negative."""
    assert a_from_b.xyzw[3] >= 0
    close(Transform.from_document("a", "b", a_from_b.document()).matrix, a_from_b.matrix)
    close(Transform.from_document("a", "b", a_from_b.matrix.tolist()).matrix, a_from_b.matrix)


@pytest.mark.parametrize(
    "change",
    [
        lambda m: m @ np.diag([1, 1, -1, 1]),
        lambda m: m @ np.diag([1.001, 1, 1, 1]),
        lambda m: m + np.array([[0, 1e-3, 0, 0], [0] * 4, [0] * 4, [0] * 4]),
        lambda m: m + np.array([[0] * 4, [0] * 4, [0] * 4, [0, 0, 0.5, 0]]),
        lambda m: m * 1000,
    ],
    ids=["mirror", "scale", "shear", "last row", "millimetres"],
)
def test_what_is_not_rigid_is_refused(change):
    """A mirror, a scale, a shear or a projective row is no pose."""
    matrix = Transform.from_parts("a", "b", [0.1, 0.2, 0.3], [0.1, 0.2, 0.3, 0.9]).matrix
    with pytest.raises(SchemaError, match="a_from_b is not a rigid transform"):
        Transform.from_document("a", "b", change(matrix).tolist())


@pytest.mark.parametrize("xyzw", [[0, 0, 0, 0], [0, 0, 0, float("nan")], [float("inf"), 0, 0, 1]])
def test_a_quaternion_without_direction_is_refused(xyzw):
    """Zero, NaN and infinity are no rotation."""
    with pytest.raises(UsageError, match="unit quaternion"):
        Transform.from_parts("a", "b", [0, 0, 0], xyzw)


@given(transforms("a", "b"), SIX)
def test_a_wrench_comes_back(a_from_b, wrench):
    """Moved forth and back a wrench is what it was; the force keeps its length."""
    there = move_wrench(wrench, a_from_b.matrix)
    close(move_wrench(there, a_from_b.inverse().matrix)[0], wrench, 1e-9)
    close(np.linalg.norm(there[0, :3]), np.linalg.norm(wrench[:3]))


@given(transforms("a", "b"), transforms("b", "c"), SIX)
def test_moving_a_wrench_twice_is_moving_it_once(a_from_b, b_from_c, wrench):
    """Step by step or by the chained transform, the wrench arrives the same."""
    steps = move_wrench(move_wrench(wrench, b_from_c.matrix), a_from_b.matrix)
    close(steps, move_wrench(wrench, (a_from_b @ b_from_c).matrix), 1e-8)


@given(transforms("a", "b"), SIX, SIX)
def test_power_does_not_depend_on_the_frame(a_from_b, wrench, twist):
    """Force dot velocity plus torque dot turning rate is one number, whoever measures it."""
    rotation, lever = a_from_b.rotation, a_from_b.xyz
    turning = rotation @ twist[3:]
    # the velocity of the body's point at a's origin, from that at b's
    velocity = rotation @ twist[:3] - np.cross(turning, lever)
    power = np.dot(move_wrench(wrench, a_from_b.matrix)[0], np.concatenate([velocity, turning]))
    close(power, np.dot(wrench, twist), 1e-6)


@given(st.lists(st.tuples(transforms("a", "b"), SIX), min_size=1, max_size=4))
def test_each_wrench_has_its_own_pose(pairs):
    """A stack of transforms moves each wrench by its own, as one by one."""
    stack = move_wrench([wrench for _, wrench in pairs], np.stack([transform.matrix for transform, _ in pairs]))
    close(stack, np.concatenate([move_wrench(wrench, transform.matrix) for transform, wrench in pairs]))


@given(st.lists(st.tuples(VECTORS, QUATERNIONS), min_size=1, max_size=5))
def test_poses_and_matrices_are_the_same(parts):
    """Poses come back from their matrices, up to the sign of the quaternion."""
    poses = np.array([[*xyz, *(np.array(xyzw) / np.linalg.norm(xyzw))] for xyz, xyzw in parts])
    back = matrix_poses(pose_matrices(poses))
    close(back[:, :3], poses[:, :3])
    close(np.abs((back[:, 3:] * poses[:, 3:]).sum(axis=1)), 1, 1e-9)
    assert (back[:, 6] >= 0).all()


@given(transforms("a", "b"), transforms("a", "b"), st.floats(0, 1))
def test_between_two_poses_everything_goes_on_evenly(start, end, share):
    """Position runs straight, rotation turns by the same share of the angle, about one axis, the short way."""
    turn = (Rotation.from_matrix(start.rotation).inv() * Rotation.from_matrix(end.rotation)).magnitude()
    assume(turn < 3.1)  # half a turn has no short way
    poses = matrix_poses(np.stack([start.matrix, end.matrix]))
    poses[1, 3:] *= -1  # the other sign is the same rotation
    (pose,) = interpolate_poses([0.0, 1.0], poses, [share])
    close(pose[:3], (1 - share) * start.xyz + share * end.xyz)
    done = Rotation.from_matrix(start.rotation).inv() * Rotation.from_quat(pose[3:])
    close(done.magnitude(), share * turn, 1e-6)
    left = Rotation.from_quat(pose[3:]).inv() * Rotation.from_matrix(end.rotation)
    close(left.magnitude(), (1 - share) * turn, 1e-6)


def test_the_ends_hold_and_the_knots_are_met():
    """At the samples the samples come back; before the first and after the last nothing is extrapolated."""
    turns = [Rotation.from_rotvec([0, 0, angle]).as_quat() for angle in range(3)]
    poses = np.column_stack([np.arange(9.0).reshape(3, 3), turns])
    close(interpolate_poses([0, 10, 20], poses, [0, 10, 20]), poses)
    close(interpolate_poses([0, 10, 20], poses, [-5, 25]), poses[[0, 2]])
    close(interpolate_poses([7], poses[:1], [0, 7, 9]), np.repeat(poses[:1], 3, axis=0))


@given(QUATERNIONS)
def test_a_quaternion_turns_as_scipys_does(xyzw):
    """A stated quaternion, of any length, gives the rotation of scipy to the last bit."""
    assert (Transform.from_parts("a", "b", [0, 0, 0], xyzw).rotation == Rotation.from_quat(xyzw).as_matrix()).all()

"""Kinematics of the arm."""

import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.rig.motion.ur5e import HOME, forward, inverse


def test_forward_of_the_stretched_arm_is_the_sum_of_its_links():
    """At zero angles the arm lies along -x: a2 + a3, -(d4 + d6), d1 - d5, as the data sheet draws it."""
    np.testing.assert_allclose(forward(np.zeros(6))[0, :3, 3], [-0.8172, -0.2329, 0.0628], atol=1e-12)


def test_inverse_reaches_the_pose_and_finds_the_angles():
    """FK(IK(pose)) = pose, and IK near a configuration returns it."""
    rng = np.random.default_rng(1)
    for joints in np.array(HOME) + rng.uniform(-0.4, 0.4, (40, 6)):
        pose = forward(joints)
        found = inverse(pose, near=joints)
        np.testing.assert_allclose(forward(found), pose, atol=1e-10)
        np.testing.assert_allclose(found[0], joints, atol=1e-8)


def test_joints_do_not_jump_along_a_path():
    """One configuration serves a whole path: small moves of the tool are small moves of the joints."""
    start = np.array(HOME)
    path = forward(start + np.linspace(0, 1, 200)[:, None] * np.array([0.3, -0.2, 0.25, 0.1, -0.2, 2.0]))
    assert np.abs(np.diff(inverse(path), axis=0)).max() < 0.02


@pytest.mark.parametrize("place", [[1.5, 0.0, 0.3], [0.0, 0.0, 0.4]])
def test_out_of_reach_is_an_error(place):
    """A place too far away, or on the base's axis, gives a clear error and no NaN."""
    pose = forward(HOME)[0]
    pose[:3, 3] = place
    with pytest.raises(UsageError, match="out of the UR5e's reach"):
        inverse(pose)

"""Kinematics of the UR5e: forward from joint angles, inverse in closed form, nearest to a home configuration.

Source of the numbers: Universal Robots, "DH Parameters for calculations of kinematics and dynamics" (UR5e).
The closed form follows K. P. Hawkins, "Analytic Inverse Kinematics for the Universal Robots" (2013).
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import ArrayLike

from tactiledata.arrays import RealArray
from tactiledata.errors import UsageError

# Denavit-Hartenberg parameters of the six joints: lengths in metres, twists in radians
DH_A = (0.0, -0.425, -0.3922, 0.0, 0.0, 0.0)
DH_D = (0.1625, 0.0, 0.0, 0.1333, 0.0997, 0.0996)
DH_ALPHA = (np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0)
HOME = (-1.2, -1.6, -1.9, -1.2, 1.57, 0.3)
"""Joint angles, rad, near which solutions are sought: elbow up, tool down, in front of the arm."""
JOINT_NAMES = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)


def _link(joint: int, angle: RealArray) -> RealArray:
    """Return the poses (n, 4, 4) of frame ``joint + 1`` in frame ``joint``, by the Denavit-Hartenberg rule."""
    cos, sin = np.cos(angle), np.sin(angle)
    cos_twist, sin_twist = np.cos(DH_ALPHA[joint]), np.sin(DH_ALPHA[joint])
    link = np.zeros((len(angle), 4, 4))
    link[:, 0] = np.stack([cos, -sin * cos_twist, sin * sin_twist, DH_A[joint] * cos], axis=1)
    link[:, 1] = np.stack([sin, cos * cos_twist, -cos * sin_twist, DH_A[joint] * sin], axis=1)
    link[:, 2] = (0.0, sin_twist, cos_twist, DH_D[joint])
    link[:, 3, 3] = 1.0
    return link


def forward(joints: ArrayLike) -> RealArray:
    """Return the poses ``base_from_flange`` (n, 4, 4), metres, of joint angles (n, 6), rad."""
    angles = np.asarray(joints, dtype=float).reshape(-1, 6)
    pose = _link(0, angles[:, 0])
    for joint in range(1, 6):
        pose = pose @ _link(joint, angles[:, joint])
    return pose


def jacobian(joints: ArrayLike, points: ArrayLike) -> RealArray:
    """Return the geometric Jacobians (n, 6, 6) of points (n, 3), m, that move with the flange.

    Rows are velocity, m/s, then angular velocity, rad/s, in the base frame; columns are joint rates, rad/s.
    """
    angles = np.asarray(joints, dtype=float).reshape(-1, 6)
    at = np.asarray(points, dtype=float).reshape(-1, 3)
    frame = np.tile(np.eye(4), (len(angles), 1, 1))
    columns = []
    for joint in range(6):
        axis = frame[:, :3, 2]
        columns.append(np.concatenate([np.cross(axis, at - frame[:, :3, 3]), axis], axis=1))
        frame = frame @ _link(joint, angles[:, joint])
    return np.stack(columns, axis=2)


def inverse(base_from_flange: ArrayLike, near: ArrayLike = HOME) -> RealArray:
    """Return the joint angles (n, 6), rad, that reach the poses (n, 4, 4), of the solution nearest to ``near``.

    One configuration (shoulder, wrist, elbow) serves the whole path, so that joints do not jump between solutions.

    Raises
    ------
    UsageError
        A pose is out of the arm's reach.
    """
    poses = np.asarray(base_from_flange, dtype=float).reshape(-1, 4, 4)
    home = np.asarray(near, dtype=float)
    # the first pose decides the configuration
    configurations = list(itertools.product((1.0, -1.0), repeat=3))
    starts = np.concatenate([_solution(poses[:1], *signs) for signs in configurations])
    distances = np.abs(_nearest_turn(starts, home) - home).sum(axis=1)
    joints = _solution(poses, *configurations[int(np.argmin(np.where(np.isfinite(distances), distances, np.inf)))])
    if not np.isfinite(joints).all():
        place = poses[int(np.argmin(np.isfinite(joints).all(axis=1))), :3, 3]
        raise UsageError(
            f"a flange pose at {np.round(place, 3).tolist()} m is out of the UR5e's reach",
            "poses within 0.85 m of the base, away from its axis",
            "Move base_from_indenter in the scenario.",
            xyz=place.tolist(),
        )
    return np.unwrap(_nearest_turn(joints, home), axis=0)


def _nearest_turn(joints: RealArray, home: RealArray) -> RealArray:
    """Return the angles (n, 6), rad, moved by full turns to within half a turn of ``home``."""
    return home + np.mod(joints - home + np.pi, 2 * np.pi) - np.pi


def _rigid_inverse(poses: RealArray) -> RealArray:
    """Return the inverses (n, 4, 4) of rigid transforms (n, 4, 4)."""
    inverse = np.zeros_like(poses)
    inverse[:, :3, :3] = np.swapaxes(poses[:, :3, :3], 1, 2)
    inverse[:, :3, 3] = -np.einsum("nij,nj->ni", inverse[:, :3, :3], poses[:, :3, 3])
    inverse[:, 3, 3] = 1.0
    return inverse


def _solution(poses: RealArray, shoulder: float, wrist: float, elbow: float) -> RealArray:
    """Return one of the eight closed-form solutions (n, 6), rad; NaN where a pose is out of reach."""
    with np.errstate(invalid="ignore"):
        return _angles(poses, shoulder, wrist, elbow)


def _angles(poses: RealArray, shoulder: float, wrist: float, elbow: float) -> RealArray:
    """Return the joint angles (n, 6), rad, of poses (n, 4, 4) with given signs of shoulder, wrist and elbow."""
    rotation, position = poses[:, :3, :3], poses[:, :3, 3]
    # joint 1 from the wrist centre, which lies d4 beside the plane of the arm
    centre = position - DH_D[5] * rotation[:, :, 2]
    first = np.arctan2(centre[:, 1], centre[:, 0]) + shoulder * np.arccos(DH_D[3] / np.hypot(*centre[:, :2].T))
    first = first + np.pi / 2
    sin, cos = np.sin(first), np.cos(first)
    # joints 5 and 6 from the tool's direction
    fifth = wrist * np.arccos((position[:, 0] * sin - position[:, 1] * cos - DH_D[3]) / DH_D[5])
    side = np.sign(np.sin(fifth))
    sixth = np.arctan2(
        side * (-rotation[:, 0, 1] * sin + rotation[:, 1, 1] * cos),
        side * (rotation[:, 0, 0] * sin - rotation[:, 1, 0] * cos),
    )
    # joints 2, 3, 4 in the plane of the arm
    inner = _rigid_inverse(_link(0, first)) @ poses @ _rigid_inverse(_link(4, fifth) @ _link(5, sixth))
    reach = inner[:, :3, 3] + DH_D[3] * inner[:, :3, 1]
    square = (reach[:, :2] ** 2).sum(axis=1)
    third = elbow * np.arccos((square - DH_A[1] ** 2 - DH_A[2] ** 2) / (2 * DH_A[1] * DH_A[2]))
    second = np.arctan2(-reach[:, 1], -reach[:, 0]) - np.arcsin(-DH_A[2] * np.sin(third) / np.sqrt(square))
    fourth_link = _rigid_inverse(_link(1, second) @ _link(2, third)) @ inner
    fourth = np.arctan2(fourth_link[:, 1, 0], fourth_link[:, 0, 0])
    return np.stack([first, second, third, fourth, fifth, sixth], axis=1)

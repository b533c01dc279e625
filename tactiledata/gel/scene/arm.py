"""Kinematics of the UR5e: the flange at given joint angles, and the rigid tool between flange and recorded poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from tactiledata.arrays import Array

UR5E_LINKS = (
    (0.0, 0.1625, np.pi / 2),
    (-0.425, 0.0, 0.0),
    (-0.3922, 0.0, 0.0),
    (0.0, 0.1333, np.pi / 2),
    (0.0, 0.0997, -np.pi / 2),
    (0.0, 0.0996, 0.0),
)
"""Denavit-Hartenberg parameters a (m), d (m) and alpha (rad) of each joint.

Source: Universal Robots, "DH Parameters for calculations of kinematics and dynamics". The base frame is the
controller's, which ROS calls ``base``, not ``base_link``."""


def base_from_flange(joints: ArrayLike) -> Array:
    """Poses (n, 4, 4), m, of a UR5e's flange at joint angles (n, 6), rad."""
    angles = np.asarray(joints, dtype=float).reshape(-1, 6)
    poses = np.tile(np.eye(4), (len(angles), 1, 1))
    for joint, (a, d, alpha) in enumerate(UR5E_LINKS):
        turn = np.tile(np.eye(4), (len(angles), 1, 1))
        turn[:, :3, :3] = Rotation.from_euler("z", angles[:, joint : joint + 1]).as_matrix()
        poses = poses @ turn @ _tail(a, d, alpha)
    return poses


def _tail(a: float, d: float, alpha: float) -> Array:
    """Constant part (4, 4) of a joint's transform, after the rotation about its axis."""
    tail = np.eye(4)
    tail[:3, :3] = Rotation.from_euler("x", alpha).as_matrix()
    tail[:3, 3] = (a, 0.0, d)
    return tail


@dataclass(frozen=True)
class ToolCheck:
    """Rigid tool fitted to joints and poses recorded together, and the error that it leaves.

    Parameters
    ----------
    flange_from_tcp : (4, 4)
        The tool that fits all samples best, metres.
    samples : int
        Number of samples with finite joints and poses.
    position_off, rotation_off : m, rad
        Root mean square errors. A tool is rigid, so that they come from noise, a delay, or a wrong frame.
    """

    flange_from_tcp: Array
    samples: int
    position_off: float
    rotation_off: float


def fit_tool(joints: Array, base_from_tcp: Array) -> ToolCheck | None:
    """Fit the rigid tool between the flange at joints (n, 6), rad, and poses (n, 4, 4); ``None`` if none is finite."""
    is_known = np.isfinite(joints).all(axis=1) & np.isfinite(base_from_tcp).all(axis=(1, 2))
    if not is_known.any():
        return None
    tools = np.linalg.inv(base_from_flange(joints[is_known])) @ base_from_tcp[is_known]
    mean = Rotation.from_matrix(tools[:, :3, :3]).mean()
    angles = (mean.inv() * Rotation.from_matrix(tools[:, :3, :3])).magnitude()
    tool = np.eye(4)
    tool[:3, :3] = mean.as_matrix()
    tool[:3, 3] = tools[:, :3, 3].mean(axis=0)
    distances = np.linalg.norm(tools[:, :3, 3] - tool[:3, 3], axis=1)
    return ToolCheck(
        tool, int(is_known.sum()), float(np.sqrt((distances**2).mean())), float(np.sqrt((angles**2).mean()))
    )

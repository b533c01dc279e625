"""What the tool's own weight adds to the force sensor's reading, from its mass, its centre of gravity and the pose."""

from __future__ import annotations

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Times, Values
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.align import align, broken_rotations
from tactiledata.transforms import pose_matrices

STANDARD_GRAVITY = 9.80665
"""m/s², along -z of the robot's base frame (BIPM, The International System of Units, 9th edition)."""


def tool_weight(description: LogDescription, tcp: StoredSignal | None, t_ns: Times) -> Values | None:
    """The tool's weight as a load on the force sensor (n, 6), N and N m, in the ft frame about its origin.

    ``None`` where the recording does not say the tool's mass, or holds no pose of the tool centre point.

    Parameters
    ----------
    description : LogDescription
        ``robot.tool`` (kg; centre of gravity in m, tcp frame) and ``robot.tcp_from_ft``.
    tcp : StoredSignal or None
        Poses base_from_tcp, x y z and quaternion x y z w.
    t_ns : (n,) int64
        Host clock. Before the first and after the last pose, that pose is held: the arm rests there.
    """
    tool = description.robot.get("tool")
    tcp_from_ft = description.transform("tcp_from_ft")
    if tool is None or tcp_from_ft is None or tcp is None or not len(tcp.t_ns):
        return None
    sound = tcp.t_ns[np.isfinite(tcp.values).all(axis=1) & ~broken_rotations(tcp.values)]
    if not len(sound):
        return None
    held = np.clip(t_ns, sound[0], sound[-1])
    base_from_tcp = pose_matrices(align(tcp, held).values)
    ft_from_tcp = tcp_from_ft.inverse()
    weight_in_base = np.array([0.0, 0.0, -tool["mass"] * STANDARD_GRAVITY])
    weight_in_tcp = np.einsum("nji,j->ni", base_from_tcp[:, :3, :3], weight_in_base)
    force = weight_in_tcp @ ft_from_tcp.rotation.T
    lever = ft_from_tcp.points([tool.get("centre_of_gravity", [0.0, 0.0, 0.0])])[0]
    return np.concatenate([force, np.cross(lever, force)], axis=1)

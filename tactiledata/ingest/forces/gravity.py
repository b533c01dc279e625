"""What the tool's own weight adds to the force sensor's reading, from its mass, its centre of gravity and the pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.description import LogDescription
from tactiledata.contract.records import Times, Values
from tactiledata.contract.take import StoredSignal
from tactiledata.ingest.clocks.align import align, broken_rotations
from tactiledata.ingest.clocks.witnesses import usual_distance
from tactiledata.transforms import pose_matrices

STANDARD_GRAVITY = 9.80665
"""m/s², along -z of the robot's base frame (BIPM, The International System of Units, 9th edition)."""


LONGEST_GAP, LONGEST_HOLD = 500_000_000, 100_000_000
"""ns. Between poses that are farther apart than the first, the arm may have been anywhere; before the first and after
the last pose, where nothing bounds its turn, that pose is held for the second."""

STANDS, STANDS_TURNED = 1e-4, 2e-3
"""m and rad: an arm whose pose differs by less stood still. The weight of 1 kg turns by 0.02 N at such an angle."""

POSE_PERIODS = 3
"""Times the usual distance of poses; the larger of it and the limits above counts."""


def what_weight_needs(description: LogDescription, tcp: StoredSignal | None) -> list[str]:
    """Return what a recording lacks for the weight of its tool; nothing where it is known.

    Parameters
    ----------
    description : LogDescription
        ``robot.tool`` and ``robot.tcp_from_ft``.
    tcp : StoredSignal or None
        Poses base_from_tcp.
    """
    lacks = {
        "robot.tool with its mass": description.robot.get("tool") is None,
        "robot.tcp_from_ft": description.transform("tcp_from_ft") is None,
        "a tcp stream with sound poses": tcp is None or not _is_sound(tcp).any(),
    }
    return [what for what, is_missing in lacks.items() if is_missing]


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
        Host clock. Before the first and after the last pose, that pose is held; `without_pose` tells where too long.
    """
    if what_weight_needs(description, tcp):
        return None
    tool, tcp_from_ft = description.robot["tool"], description.transform("tcp_from_ft")
    assert tcp is not None
    assert tcp_from_ft is not None
    sound = tcp.t_ns[_is_sound(tcp)]
    held = np.clip(t_ns, sound[0], sound[-1])
    base_from_tcp = pose_matrices(align(tcp, held).values)
    ft_from_tcp = tcp_from_ft.inverse()
    weight_in_base = np.array([0.0, 0.0, -tool["mass"] * STANDARD_GRAVITY])
    weight_in_tcp = np.einsum("nji,j->ni", base_from_tcp[:, :3, :3], weight_in_base)
    force = weight_in_tcp @ ft_from_tcp.rotation.T
    lever = ft_from_tcp.points(tool.get("centre_of_gravity", [0.0, 0.0, 0.0]))
    return np.concatenate([force, np.cross(lever, force)], axis=1)


def without_pose(tcp: StoredSignal, t_ns: Times) -> NDArray[np.bool_]:
    """Return a mask (n,) of moments that have no pose near enough to compute the tool's weight from.

    They lie in a gap between two poses that is longer than `LONGEST_GAP`, or more than `LONGEST_HOLD` before the
    first or after the last. A gap with one pose at both ends is none: the arm stood, and nothing was written.

    Parameters
    ----------
    tcp : StoredSignal
        Poses base_from_tcp; those that are broken do not count.
    t_ns : (n,) int64
        Host clock.
    """
    is_sound = _is_sound(tcp)
    sound, poses = tcp.t_ns[is_sound], tcp.values[is_sound]
    if not len(sound):
        return np.ones(len(t_ns), dtype=bool)
    periods = POSE_PERIODS * usual_distance(sound)
    beyond = np.maximum(sound[0] - t_ns, t_ns - sound[-1])
    after = np.searchsorted(sound, t_ns, side="left")
    later = np.minimum(after, len(sound) - 1)
    gap = sound[later] - sound[after - 1]
    is_moved = _is_moved(poses[after - 1], poses[later])
    is_lost = (gap > max(LONGEST_GAP, periods)) & is_moved & (beyond < 0) & ~np.isin(t_ns, sound)
    return is_lost | (beyond > max(LONGEST_HOLD, periods))


def _is_sound(tcp: StoredSignal) -> NDArray[np.bool_]:
    """Return a mask (n,) of poses that are known and turn by a rotation."""
    return np.asarray(np.isfinite(tcp.values).all(axis=1) & ~broken_rotations(tcp.values))


def _is_moved(before: Values, after: Values) -> NDArray[np.bool_]:
    """Whether the arm stands elsewhere (n,) at two poses (n, 7), by more than its repeatability."""
    along = np.linalg.norm(after[:, :3] - before[:, :3], axis=1)
    # q and -q are one rotation; the angle between two is twice that of the quaternions
    cosines = np.abs((before[:, 3:] * after[:, 3:]).sum(axis=1))
    cosines /= np.linalg.norm(before[:, 3:], axis=1) * np.linalg.norm(after[:, 3:], axis=1)
    turn = 2.0 * np.arccos(np.minimum(cosines, 1.0))
    return np.asarray((along > STANDS) | (turn > STANDS_TURNED))

"""Which frames of a trajectory can be solved, and the load steps (intermediate poses) that lead to each."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.arrays import Array
from tactiledata.gel.contact.contact_path import LARGEST_STEP, interpolated_poses
from tactiledata.gel.contact.gap import APART, height_above
from tactiledata.gel.contact.history import FrameStatus
from tactiledata.gel.contact.relief import IndenterRelief

DEEPEST = 0.5
"""Deepest overlap that is solved, as a share of the pad's thickness: beyond it cells would be crushed."""
LEVER = 4e-3
"""Lever, m, that turns a rotation of the indenter into the motion of the touching surface."""
HALVINGS = 10
"""Bisections of a motion to find the pose of first contact."""


def pose_status(pose: Array, rest: Array, relief: IndenterRelief, thickness: float) -> FrameStatus:
    """Return why a frame cannot be solved, or ``SOLVED`` where it can be tried, contact or none.

    ``POSE_MISSING``: a number of the pose is not finite. ``TOO_DEEP``: the indenter overlaps the undeformed gel by more
    than ``DEEPEST`` times the thickness. ``BESIDE_THE_PAD``: it overlaps nothing, and its tip, the origin of its frame,
    lies more than half the thickness below z = 0. ``NO_CONTACT`` and ``NOT_CONVERGED`` are never returned.

    Parameters
    ----------
    pose : (4, 4)
        gel_from_indenter, metres; NaN where unknown.
    rest : (s, 3) m
        Undeformed surface nodes, gel frame.
    relief : IndenterRelief
        Underside of the indenter.
    thickness : m
        Thickness of the pad.
    """
    if not np.isfinite(pose).all():
        return FrameStatus.POSE_MISSING
    above = height_above(rest, relief, pose)
    overlap = -float(above.min())
    tip_height = float(pose[2, 3])
    if overlap > DEEPEST * thickness:
        return FrameStatus.TOO_DEEP
    if overlap <= 0 and tip_height < -thickness / 2:
        return FrameStatus.BESIDE_THE_PAD
    return FrameStatus.SOLVED


def load_steps(
    start: Array, end: Array, rest: Array, relief: IndenterRelief, is_touching: bool
) -> tuple[Array, list[Array]]:
    """Return the pose (4, 4) from which steps of at most ``LARGEST_STEP`` lead to a frame, and the poses that end them.

    The last one is the frame's own. Where nothing touched at the start, the part of the motion through the air is left
    out.

    Parameters
    ----------
    start, end : (4, 4)
        gel_from_indenter at the last solved pose (NaN where there is none) and at the frame, metres.
    rest : (s, 3) m
        Undeformed surface nodes, gel frame.
    relief : IndenterRelief
        Underside of the indenter.
    is_touching : bool
        Whether the indenter presses the gel at ``start``.
    """
    if not is_touching:
        start = _first_touch(start, end, rest, relief)
    turn = Rotation.from_matrix(start[:3, :3].T @ end[:3, :3]).magnitude()
    distance = float(np.linalg.norm(end[:3, 3] - start[:3, 3])) + LEVER * float(turn)
    return start, interpolated_poses(start, end, max(1, int(np.ceil(distance / LARGEST_STEP - 1e-6))))


def _first_touch(start: Array, end: Array, rest: Array, relief: IndenterRelief) -> Array:
    """Return the pose between start and end at which the indenter first touches the undeformed surface, or ``end``."""
    if height_above(rest, relief, end).min() >= 0:
        return end
    if not np.isfinite(start).all() or height_above(rest, relief, start).min() < 0:
        # the motion to this pose is unknown: assume a straight one along the indenter's own axis
        retracted = end.copy()
        retracted[:3, 3] += end[:3, 2] * -float(np.clip(height_above(rest, relief, end).min(), -APART, 0.0))
        return retracted
    free, touching = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (free + touching) / 2
        pose = _between(start, end, middle)
        if height_above(rest, relief, pose).min() < 0:
            touching = middle
        else:
            free = middle
    return _between(start, end, free)


def _between(start: Array, end: Array, share: float) -> Array:
    """Pose (4, 4) at a share of the way from start to end, with the rotation of the end."""
    if share <= 0:
        return start
    pose = end.copy()
    pose[:3, 3] = (1 - share) * start[:3, 3] + share * end[:3, 3]
    return pose

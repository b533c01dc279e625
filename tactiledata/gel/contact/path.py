"""From a touch's frames to load steps: which frames can be solved, and through which poses they are reached."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.arrays import Array
from tactiledata.gel.contact.contact_path import LARGEST_STEP, way_points
from tactiledata.gel.contact.gap import APART, height_above
from tactiledata.gel.contact.history import FrameStatus
from tactiledata.gel.contact.relief import IndenterRelief

DEEPEST = 0.5
"""Share of the pad's thickness beyond which nothing is solved: cells would be crushed."""
LEVER = 4e-3
"""m: a turn moves what touches by its angle times this."""
HALVINGS = 10
"""Of the way, to find where an indenter first touches."""


def judge_pose(pose: Array, rest: Array, relief: IndenterRelief, thickness: float) -> FrameStatus:
    """What can be said of a frame before it is solved; ``SOLVED`` where it can be.

    Parameters
    ----------
    pose : (4, 4), gel_from_indenter
    rest : (s, 3) m, undeformed surface nodes
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
    start: Array, end: Array, rest: Array, relief: IndenterRelief, is_touching: bool, finer: int
) -> list[Array]:
    """Poses (4, 4) on the way to a frame, the frame's own last, none of them far from the one before.

    Where nothing touched before, the way through the air is left out.

    Parameters
    ----------
    start, end : (4, 4), gel_from_indenter
    finer : factor on the number of steps
    """
    if not is_touching:
        start = _first_touch(start, end, rest, relief)
    turn = Rotation.from_matrix(start[:3, :3].T @ end[:3, :3]).magnitude()
    way = float(np.linalg.norm(end[:3, 3] - start[:3, 3])) + LEVER * float(turn)
    return way_points(start, end, finer * max(1, int(np.ceil(way / LARGEST_STEP - 1e-6))))


def _first_touch(start: Array, end: Array, rest: Array, relief: IndenterRelief) -> Array:
    """The pose on the way at which the indenter comes to touch the undeformed surface, or ``end``."""
    if height_above(rest, relief, end).min() >= 0:
        return end
    if not np.isfinite(start).all() or height_above(rest, relief, start).min() < 0:
        # nothing is known of how it came there: straight along its own axis
        back = end.copy()
        back[:3, 3] += end[:3, 2] * -float(np.clip(height_above(rest, relief, end).min(), -APART, 0.0))
        return back
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
    if share <= 0:
        return start
    pose = end.copy()
    pose[:3, 3] = (1 - share) * start[:3, 3] + share * end[:3, 3]
    return pose

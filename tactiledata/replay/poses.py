"""Poses of the indenter in the gel frame, from the arm's poses and the stated transforms."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.transforms import pose_matrices


def gel_from_indenter(base_from_tcp: Array, tcp_from_gel: Array, base_from_indenter: Array, offset: float) -> Array:
    """Poses (n, 4, 4), metres, of the indenter in the gel frame; NaN where the arm's pose is unknown.

    Parameters
    ----------
    base_from_tcp : (n, 7)
        x y z, m, and quaternion x y z w; NaN where unknown.
    tcp_from_gel, base_from_indenter : (4, 4)
        Places of the gel on the arm and of the indenter, metres.
    offset : m
        By how much the indenter is deeper than recorded, along the gel frame's -z.
    """
    poses = np.full((len(base_from_tcp), 4, 4), np.nan)
    is_known = np.isfinite(base_from_tcp).all(axis=1)
    if is_known.any():
        base_from_gel = pose_matrices(base_from_tcp[is_known]) @ tcp_from_gel
        gel_from_base_rotation = base_from_gel[:, :3, :3].transpose(0, 2, 1)
        gel_from_base = np.tile(np.eye(4), (len(gel_from_base_rotation), 1, 1))
        gel_from_base[:, :3, :3] = gel_from_base_rotation
        gel_from_base[:, :3, 3] = -np.einsum("nij,nj->ni", gel_from_base_rotation, base_from_gel[:, :3, 3])
        known_poses = gel_from_base @ base_from_indenter
        known_poses[:, 2, 3] -= offset
        poses[is_known] = known_poses
    return poses

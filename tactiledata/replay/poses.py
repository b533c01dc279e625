"""Where the indenter was, seen from the gel, at every frame of a trajectory."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.transforms import pose_matrices


def gel_from_indenter(base_from_tcp: Array, tcp_from_gel: Array, base_from_indenter: Array, offset: float) -> Array:
    """Poses (n, 4, 4) of the indenter in the gel frame; NaN where the arm's pose is not known.

    Parameters
    ----------
    base_from_tcp : (n, 7)
        x y z, m, and quaternion x y z w; NaN where unknown.
    tcp_from_gel, base_from_indenter : (4, 4)
    offset : m
        By how much the indenter is deeper than recorded, along the gel frame's -z.
    """
    poses = np.full((len(base_from_tcp), 4, 4), np.nan)
    known = np.isfinite(base_from_tcp).all(axis=1)
    if known.any():
        base_from_gel = pose_matrices(base_from_tcp[known]) @ tcp_from_gel
        turned = base_from_gel[:, :3, :3].transpose(0, 2, 1)
        gel_from_base = np.tile(np.eye(4), (len(turned), 1, 1))
        gel_from_base[:, :3, :3] = turned
        gel_from_base[:, :3, 3] = -np.einsum("nij,nj->ni", turned, base_from_gel[:, :3, 3])
        found = gel_from_base @ base_from_indenter
        found[:, 2, 3] -= offset
        poses[known] = found
    return poses

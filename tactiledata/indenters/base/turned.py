"""How far a turned solid reaches below its tip."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import Indenter


def reach_below_tip(indenter: Indenter, poses: Array) -> Array:
    """Return by how much the lowest point of a solid lies below its tip (n,), m; 0 where a pose is not known.

    A flat solid that is turned by a wedge touches with an edge before its tip does.

    Parameters
    ----------
    indenter : Indenter
        The solid; its tip is the origin of its frame.
    poses : (n, 4, 4) m
        gel_from_indenter.
    """
    vertices = np.asarray(indenter.mesh().vertices, dtype=np.float64)
    heights = np.nan_to_num(poses[:, 2, :3]) @ vertices.T
    reach: Array = np.maximum(-heights.min(axis=1), 0.0)
    return reach

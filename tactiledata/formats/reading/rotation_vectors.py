"""Poses whose rotation is written as a vector, as UR controllers give it."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array


def poses_from_rotation_vectors(values: Array) -> Array:
    """Poses (n, 7), quaternion x y z w, of UR's (n, 6): position in metres and rotation vector in radians.

    Examples
    --------
    >>> poses_from_rotation_vectors(np.array([[1, 2, 3, np.pi, 0, 0]])).round(6).tolist()
    [[1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0]]
    """
    from scipy.spatial.transform import Rotation

    return np.concatenate([values[:, :3], Rotation.from_rotvec(values[:, 3:]).as_quat()], axis=1)

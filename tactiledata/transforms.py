"""Poses between named frames: ``a_from_b`` maps coordinates of b into a, and chains read right to left."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tactiledata.arrays import Array
from tactiledata.errors import SchemaError, UsageError

ORTHONORMAL_TOLERANCE = 1e-6
"""Largest deviation of R Rᵀ from identity that a stated rotation may have (printed decimals, not shear)."""


@dataclass(frozen=True)
class Transform:
    """A rigid transform ``to_from_source``: ``p_to = matrix @ [p_source, 1]``, lengths in metres.

    Examples
    --------
    >>> base_from_tcp = Transform.from_parts("base", "tcp", [0.1, 0, 0], [0, 0, 0, 1])
    >>> tcp_from_gel = Transform.from_parts("tcp", "gel", [0, 0.2, 0], [0, 0, 0, 1])
    >>> (base_from_tcp @ tcp_from_gel).xyz.tolist()
    [0.1, 0.2, 0.0]
    """

    to: str
    source: str
    matrix: Array

    @classmethod
    def from_parts(cls, to: str, source: str, xyz: ArrayLike, xyzw: ArrayLike) -> Transform:
        """Return the transform of a translation (3,), metres, and a quaternion (4,), x y z w.

        Parameters
        ----------
        to, source : str
            Names of the frames: coordinates of ``source`` are mapped into ``to``.
        xyz : (3,), metres
            Origin of ``source`` in frame ``to``.
        xyzw : (4,)
            Rotation; normalised here.

        Raises
        ------
        SchemaError
            A value that is no number.
        UsageError
            A quaternion of length zero, or a value that is not finite.
        """
        try:
            quaternion, position = np.asarray(xyzw, dtype=float), np.asarray(xyz, dtype=float)
        except (OverflowError, TypeError, ValueError) as error:
            raise SchemaError(
                f"{to}_from_{source} holds what is no number a machine can keep ({error})",
                "xyz in metres and a unit quaternion xyzw",
                path=f"{to}_from_{source}",
            ) from error
        is_sound = np.isfinite(quaternion).all() and np.isfinite(position).all() and np.abs(quaternion).max() < 1e6
        if not is_sound or np.linalg.norm(quaternion) < 1e-9:
            raise UsageError(f"rotation of {to}_from_{source} is {quaternion.tolist()}", "a unit quaternion x y z w")
        matrix = np.eye(4)
        matrix[:3, :3] = _turned(*quaternion.tolist())
        matrix[:3, 3] = position
        return cls(to, source, matrix)

    @classmethod
    def identity(cls, to: str, source: str) -> Transform:
        """Return the transform between two frames that coincide."""
        return cls(to, source, np.eye(4))

    @classmethod
    def from_document(cls, to: str, source: str, value: object) -> Transform:
        """Return the transform that a document states as ``{xyz, xyzw}`` or as a 4x4 matrix in row-major order.

        Parameters
        ----------
        to, source : str
            Names of the frames: coordinates of ``source`` are mapped into ``to``.
        value : dict or nested list
            ``xyz`` in metres (zero where it is missing) and ``xyzw`` (no rotation where it is missing), or 16 numbers.

        Raises
        ------
        SchemaError
            The matrix is not a rigid transform: a shear, a scale or a mirror.
        """
        if isinstance(value, dict):
            return cls.from_parts(to, source, value.get("xyz", [0, 0, 0]), value.get("xyzw", [0, 0, 0, 1]))
        matrix = np.asarray(value, dtype=float).reshape(4, 4)
        rotation = matrix[:3, :3]
        deviation = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
        if deviation > ORTHONORMAL_TOLERANCE or np.linalg.det(rotation) < 0 or (matrix[3] != [0, 0, 0, 1]).any():
            raise SchemaError(
                f"{to}_from_{source} is not a rigid transform (R Rᵀ is off identity by {deviation:.2g}, "
                f"determinant {np.linalg.det(rotation):.3f})",
                "a rotation and a translation in metres, last row 0 0 0 1",
                "Check the order of the numbers (row-major) and the length unit.",
                path=f"{to}_from_{source}",
            )
        return cls(to, source, matrix)

    @property
    def xyz(self) -> Array:
        """Translation (3,), metres, in frame ``to``."""
        return self.matrix[:3, 3]

    @property
    def rotation(self) -> Array:
        """Rotation matrix (3, 3)."""
        return self.matrix[:3, :3]

    @property
    def xyzw(self) -> Array:
        """Rotation as a quaternion (4,), x y z w, with w >= 0."""
        from scipy.spatial.transform import Rotation

        quaternion = Rotation.from_matrix(self.rotation).as_quat()
        return quaternion if quaternion[3] >= 0 else -quaternion

    def __matmul__(self, other: Transform) -> Transform:
        """Return the chain of two transforms: ``a_from_b @ b_from_c`` is ``a_from_c``; refuse frames that differ."""
        if self.source != other.to:
            raise UsageError(
                f"{self.to}_from_{self.source} cannot be followed by {other.to}_from_{other.source}",
                f"a transform into frame {self.source!r}",
            )
        return Transform(self.to, other.source, self.matrix @ other.matrix)

    def inverse(self) -> Transform:
        """Return the inverse transform, ``source_from_to``."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation.T
        matrix[:3, 3] = -self.rotation.T @ self.xyz
        return Transform(self.source, self.to, matrix)

    def points(self, points: ArrayLike) -> Array:
        """Return points (n, 3), metres, of frame ``source`` in frame ``to``."""
        return np.asarray(points, dtype=float) @ self.rotation.T + self.xyz

    def document(self) -> dict[str, list[float]]:
        """Return the transform as a document states it: ``{xyz, xyzw}``."""
        return {"xyz": self.xyz.tolist(), "xyzw": self.xyzw.tolist()}


def _turned(x: float, y: float, z: float, w: float) -> Array:
    """Return the rotation matrix (3, 3) of a quaternion, normalised here.

    Every command reads descriptions, and importing scipy's rotations for that would make each start later.
    """
    length = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / length, y / length, z / length, w / length
    return np.array(
        [
            [x * x - y * y - z * z + w * w, 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), -(x * x) + y * y - z * z + w * w, 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), -(x * x) - y * y + z * z + w * w],
        ]
    )


def pose_matrices(poses: ArrayLike) -> Array:
    """Return the matrices (n, 4, 4) of poses (n, 7): x y z in metres and a quaternion x y z w."""
    from scipy.spatial.transform import Rotation

    rows = np.asarray(poses, dtype=float).reshape(-1, 7)
    matrices = np.tile(np.eye(4), (len(rows), 1, 1))
    matrices[:, :3, :3] = Rotation.from_quat(rows[:, 3:]).as_matrix()
    matrices[:, :3, 3] = rows[:, :3]
    return matrices


def matrix_poses(matrices: ArrayLike) -> Array:
    """Return the poses (n, 7), x y z and quaternion x y z w with w >= 0, of matrices (n, 4, 4)."""
    from scipy.spatial.transform import Rotation

    stack = np.asarray(matrices, dtype=float).reshape(-1, 4, 4)
    quaternions = Rotation.from_matrix(stack[:, :3, :3]).as_quat().reshape(-1, 4)
    quaternions[quaternions[:, 3] < 0] *= -1
    return np.concatenate([stack[:, :3, 3], quaternions], axis=1)


def interpolate_poses(times: ArrayLike, poses: ArrayLike, at: ArrayLike) -> Array:
    """Return poses (m, 7) at times ``at`` (m,), linear in position and slerp in rotation, held at both ends.

    Parameters
    ----------
    times : (n,), seconds or nanoseconds, strictly increasing
        When the given poses hold.
    poses : (n, 7), x y z metres, quaternion x y z w
    at : (m,), same unit as ``times``
        When poses are needed; before the first and after the last of ``times`` the pose there is held.
    """
    from scipy.spatial.transform import Rotation, Slerp

    knots = np.asarray(times, dtype=np.float64)
    rows = np.asarray(poses, dtype=float).reshape(-1, 7)
    within = np.clip(np.asarray(at, dtype=np.float64), knots[0], knots[-1])
    position = np.stack([np.interp(within, knots, rows[:, axis]) for axis in range(3)], axis=1)
    if len(knots) == 1:
        return np.concatenate([position, np.repeat(rows[:, 3:], len(within), axis=0)], axis=1)
    quaternion = Slerp(knots, Rotation.from_quat(rows[:, 3:]))(within).as_quat()
    return np.concatenate([position, quaternion], axis=1)


def move_wrench(wrench: ArrayLike, to_from_source: Array) -> Array:
    """Return wrenches (n, 6), N and N m, re-expressed in another frame, torque about that frame's origin.

    Parameters
    ----------
    wrench : (n, 6), force N and torque N m about the source frame's origin, in source axes
    to_from_source : (4, 4) or (n, 4, 4), metres
    """
    rows = np.asarray(wrench, dtype=float).reshape(-1, 6)
    matrices = np.broadcast_to(np.asarray(to_from_source, dtype=float), (len(rows), 4, 4))
    force = np.einsum("nij,nj->ni", matrices[:, :3, :3], rows[:, :3])
    torque = np.einsum("nij,nj->ni", matrices[:, :3, :3], rows[:, 3:])
    return np.concatenate([force, torque + np.cross(matrices[:, :3, 3], force)], axis=1)

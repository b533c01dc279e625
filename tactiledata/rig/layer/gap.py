"""The points at which the gel's surface can be touched, and their distances from the indenter."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tactiledata.arrays import RealArray
from tactiledata.indenters.base import Indenter
from tactiledata.rig.layer.grid import LayerGrid

PER_SIDE = 2
"""Number of touch points along each side of a cell: the rim of a punch lies between the points of the grid."""
BACK = 4e-6
"""Distance off the surface, m, at which normals are taken."""
PROBE = 1e-6
"""Length, m, of the finite differences that give a normal."""


@dataclass(frozen=True)
class TouchPoints:
    """The points of the undeformed surface at which contact is looked for, several to a cell.

    Parameters
    ----------
    places : (n, 3), metres, gel frame
        Places of the points on the undeformed surface.
    share : sparse (n, rows * columns)
        Weights that interpolate the grid's values to the points; transposed, they distribute forces to the grid.
    areas : (n,), m²
        Area of the gel that each point stands for.
    """

    places: RealArray
    share: sparse.csr_array
    areas: RealArray

    @classmethod
    def of(cls, grid: LayerGrid) -> TouchPoints:
        """Return all touch points of a flat pad."""
        rows, columns = grid.shape
        inside = (np.arange(PER_SIDE) + 0.5) / PER_SIDE
        i, j, s, t = (
            part.ravel() for part in np.meshgrid(np.arange(rows), np.arange(columns), inside, inside, indexing="ij")
        )
        filling = grid.filling[i, j]
        keep = filling > 0
        i, j, s, t, filling = i[keep], j[keep], s[keep], t[keep], filling[keep]
        corners = [(0, 0, (1 - s) * (1 - t)), (1, 0, s * (1 - t)), (0, 1, (1 - s) * t), (1, 1, s * t)]
        index = np.stack([(i + a) % rows * columns + (j + b) % columns for a, b, _ in corners], axis=1)
        weight = np.stack([value for _, _, value in corners], axis=1)
        starts = 4 * np.arange(len(i) + 1)
        share = sparse.csr_array((weight.ravel(), index.ravel(), starts), shape=(len(i), rows * columns))
        places = np.stack([grid.x[j] + t * grid.pitch, grid.y[i] + s * grid.pitch, np.zeros(len(i))], axis=1)
        return cls(places, share, filling * (grid.pitch / PER_SIDE) ** 2)

    def lowered(self, fall: RealArray) -> TouchPoints:
        """Return the points of a surface that lies lower by (n,), m."""
        return replace(self, places=self.places - fall[:, None] * np.array([0.0, 0.0, 1.0]))

    def chosen(self, index: NDArray[np.intp]) -> TouchPoints:
        """Return the points of given indices."""
        return TouchPoints(self.places[index], self.share[index], self.areas[index])


def gaps(indenter: Indenter, pose: RealArray, points: RealArray) -> RealArray:
    """Return the signed distances (n,), m, of points from the surface of an indenter; negative inside it.

    A distance is the Euclidean one to the nearest point of the surface, in any direction, not along the gel's normal;
    edges and corners count as surface. It is as exact as the indenter's own `Indenter.signed_distance`: where parts of
    a body overlap, as in ``dots`` and some meshes, the distance inside is a bound.

    Parameters
    ----------
    indenter : Indenter
        The body.
    pose : (4, 4)
        Pose of the indenter, gel_from_indenter: a proper rotation, and a translation in metres.
    points : (n, 3), metres, gel frame
        Points to measure from; without points the result is empty.
    """
    return np.asarray(indenter.signed_distance((points - pose[:3, 3]) @ pose[:3, :3]))


def gaps_and_normals(indenter: Indenter, pose: RealArray, points: RealArray) -> tuple[RealArray, RealArray]:
    """Return the signed distances (n,), m, of points, and the unit normals (n, 3) out of the indenter, gel frame.

    A distance is negative inside. Every point is first moved down along the gel's z axis, a point inside the body out
    of it, and the distance is extrapolated from there as a plane: a deep first guess beside an edge belongs to the face
    above it, not to the wall beside it. So it differs from that of `gaps` where the body is curved or has an edge near.

    Parameters
    ----------
    indenter : Indenter
        The body.
    pose : (4, 4)
        Pose of the indenter, gel_from_indenter: a proper rotation, and a translation in metres.
    points : (n, 3), metres, gel frame
        Points to measure from.
    """
    local = (points - pose[:3, 3]) @ pose[:3, :3]
    up = pose[2, :3]
    depth = np.maximum(-np.asarray(indenter.signed_distance(local)), 0.0)
    lowered = local - (depth + BACK)[:, None] * up
    # an oblique body is left less quickly than its distance says: once more
    again = np.maximum(BACK / 2 - np.asarray(indenter.signed_distance(lowered)), 0.0)
    lowered -= again[:, None] * up
    # normals by finite differences over the corners of a small tetrahedron
    tetrahedron = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    probes = lowered[:, None, :] + PROBE * tetrahedron
    values = np.asarray(indenter.signed_distance(probes.reshape(-1, 3))).reshape(-1, 4)
    slope = values @ tetrahedron
    normal = slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-30)
    gap = values.mean(axis=1) + np.einsum("ij,ij->i", normal, local - lowered)
    return gap, normal @ pose[:3, :3].T

"""Where the gel's surface can be touched, and how far the indenter is from it there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from tactiledata.arrays import RealArray
from tactiledata.indenters.base import Indenter
from tactiledata.rig.layer.grid import LayerGrid

PER_SIDE = 2
"""Touch points along each side of a cell: the rim of a punch lies between the points of the grid."""
BACK = 4e-6
"""m off the surface at which normals are taken."""
PROBE = 1e-6
"""m of the differences that give a normal."""


@dataclass(frozen=True)
class TouchPoints:
    """Points of the undeformed surface at which contact is looked for, several to a cell.

    Parameters
    ----------
    places : (n, 3), metres, gel frame
    share : sparse (n, rows * columns)
        Interpolates the grid's values to the points; transposed, hands forces to the grid.
    areas : (n,), m²
    """

    places: RealArray
    share: sparse.csr_array
    areas: RealArray

    @classmethod
    def of(cls, grid: LayerGrid) -> TouchPoints:
        """All touch points of a pad that is flat."""
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
        """The points of a surface that lies lower by (n,), m."""
        return replace(self, places=self.places - fall[:, None] * np.array([0.0, 0.0, 1.0]))

    def chosen(self, index: NDArray[np.intp]) -> TouchPoints:
        """Some of the points."""
        return TouchPoints(self.places[index], self.share[index], self.areas[index])


def gaps(indenter: Indenter, pose: RealArray, points: RealArray) -> RealArray:
    """Signed distances (n,), m, of points (n, 3) in the gel frame from an indenter at ``pose`` (4, 4)."""
    return np.asarray(indenter.signed_distance((points - pose[:3, 3]) @ pose[:3, :3]))


def gaps_and_normals(indenter: Indenter, pose: RealArray, points: RealArray) -> tuple[RealArray, RealArray]:
    """Signed distances (n,), m, and unit normals (n, 3) out of the indenter, gel frame.

    A point inside the body is first taken back down, out of it, and the distance led on from there as a plane: a deep
    first guess beside an edge belongs to the face above it, not to the wall beside it.
    """
    local = (points - pose[:3, 3]) @ pose[:3, :3]
    up = pose[2, :3]
    depth = np.maximum(-np.asarray(indenter.signed_distance(local)), 0.0)
    lowered = local - (depth + BACK)[:, None] * up
    # an oblique body is left less quickly than its distance says: once more
    again = np.maximum(BACK / 2 - np.asarray(indenter.signed_distance(lowered)), 0.0)
    lowered -= again[:, None] * up
    tetrahedron = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    probes = lowered[:, None, :] + PROBE * tetrahedron
    values = np.asarray(indenter.signed_distance(probes.reshape(-1, 3))).reshape(-1, 4)
    slope = values @ tetrahedron
    normal = slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-30)
    gap = values.mean(axis=1) + np.einsum("ij,ij->i", normal, local - lowered)
    return gap, normal @ pose[:3, :3].T

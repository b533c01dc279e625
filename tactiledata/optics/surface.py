"""Outer surface of the gel: nodes and triangles, without the volume below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.store.read.meshes import PadArrays


@dataclass(frozen=True)
class GelSurface:
    """Undeformed outer surface of a gel; its nodes are the rows of a displacement.

    Parameters
    ----------
    places : (k, 3)
        Resting places of the nodes that displacements belong to, m, gel frame.
    triangles : (t, 3)
        Corners of each triangle, as rows of ``places``.
    """

    places: NDArray[np.float64]
    triangles: NDArray[np.int64]

    @classmethod
    def of_pad(cls, pad: PadArrays, number: int = 0) -> GelSurface:
        """Return the surface of one of a stored mesh's pads, over the nodes that the store keeps.

        Raises
        ------
        UsageError
            The mesh has no pad of this number, or the store does not keep all nodes of the surface.
        """
        if not 0 <= number < len(pad.vertices):
            raise UsageError(f"pad {number}", f"0 to {len(pad.vertices) - 1}", "")
        row_of = np.full(pad.vertices.shape[1], -1, np.int64)
        row_of[pad.kept] = np.arange(len(pad.kept))
        triangles = row_of[pad.triangles]
        if (triangles < 0).any():
            raise UsageError(
                f"{(triangles < 0).any(axis=1).sum()} triangles of the surface have nodes that the mesh does not keep",
                "all nodes of the outer surface",
                "Replay with --keep all or --keep surface.",
            )
        return cls(np.asarray(pad.vertices[number][pad.kept], np.float64), triangles)

    def deformed(self, displacement: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return the places (k, 3), m, of the nodes after a displacement (k, 3), m.

        Raises
        ------
        UsageError
            The displacement has another number of nodes, or holds NaN.
        """
        values = np.asarray(displacement, np.float64)
        if values.shape != self.places.shape:
            raise UsageError(
                f"a displacement of shape {values.shape}",
                f"{self.places.shape}, as this surface has nodes",
                "Was the model made for another mesh?",
            )
        if not np.isfinite(values).all():
            raise UsageError("a displacement with NaN: this frame has no mesh", "finite numbers", "Leave it out.")
        return self.places + values

"""The gel's outer surface as optics needs it: nodes and triangles, without the volume below."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.store.read.meshes import PadArrays


@dataclass(frozen=True)
class GelSurface:
    """The undeformed surface; ``triangles`` number the rows of a batch of displacements.

    Parameters
    ----------
    places : (k, 3)
        Resting places of the nodes that displacements belong to, m, gel frame.
    triangles : (t, 3)
        The outer surface, rows of ``places``.
    """

    places: NDArray[np.float64]
    triangles: NDArray[np.int64]

    @classmethod
    def of_pad(cls, pad: PadArrays, number: int = 0) -> GelSurface:
        """The surface of one of a stored mesh's pads, over the nodes that the store keeps.

        Raises
        ------
        UsageError
            No such pad, or nodes of the surface were not kept.
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
        """Places (k, 3) of the nodes after a displacement (k, 3), m.

        Raises
        ------
        UsageError
            Another number of nodes, or NaN.
        """
        moved = np.asarray(displacement, np.float64)
        if moved.shape != self.places.shape:
            raise UsageError(
                f"a displacement of shape {moved.shape}",
                f"{self.places.shape}, as this surface has nodes",
                "Was the model made for another mesh?",
            )
        if not np.isfinite(moved).all():
            raise UsageError("a displacement with NaN: this frame has no mesh", "finite numbers", "Leave it out.")
        return self.places + moved

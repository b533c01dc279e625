"""The frames of one trajectory as they are solved."""

from __future__ import annotations

from typing import Literal

import numpy as np

from tactiledata.arrays import Array
from tactiledata.gel.contact.contact_path import ContactPath
from tactiledata.gel.contact.history import FrameStatus, GelHistory
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.surface import ContactSurface

Keep = Literal["all", "surface", "none"]


class FrameRecorder:
    """Rows of a ``GelHistory``, NaN until a frame is solved.

    Parameters
    ----------
    count : frames
    mesh, surface : what the arrays' rows belong to
    youngs_modulus : Pa
    keep : which nodes' displacements are kept
    """

    def __init__(self, count: int, mesh: PadMesh, surface: ContactSurface, youngs_modulus: float, keep: Keep) -> None:
        kept = {"all": len(mesh.vertices), "surface": len(surface.nodes), "none": 0}[keep]
        self._rows = None if keep == "all" else surface.nodes[:kept]
        self._surface = surface
        self._modulus = youngs_modulus
        self.wrench = np.full((count, 6), np.nan)
        self.displacement = np.full((count, kept, 3), np.nan, dtype=np.float32)
        self.node_forces = np.full((count, len(surface.nodes), 3), np.nan, dtype=np.float32)
        self.gaps = np.full((count, len(surface.corners)), np.nan, dtype=np.float32)
        self.pressed = np.zeros((count, len(surface.corners)), dtype=bool)
        self.status = np.full(count, FrameStatus.NOT_CONVERGED, dtype=np.int8)
        self.residual = np.full(count, np.nan)
        self.iterations = np.zeros(count, dtype=np.int64)

    def keep(self, frame: int, walk: ContactPath, residual: float) -> None:
        """The contact of a frame is solved; ``put_displacement`` follows."""
        self.wrench[frame] = walk.wrench() * self._modulus
        self.node_forces[frame] = self._surface.averaging.T @ walk.state.forces * self._modulus
        self.gaps[frame] = walk.state.gaps
        self.pressed[frame] = walk.state.forces.any(axis=1)
        is_touching = bool(self.pressed[frame].any())
        self.status[frame] = FrameStatus.SOLVED if is_touching else FrameStatus.NO_CONTACT
        self.residual[frame] = residual

    @property
    def keeps_displacement(self) -> bool:
        """Whether any node's displacement is kept."""
        return self.displacement.shape[1] > 0

    def put_displacement(self, frame: int, displacement: Array) -> None:
        """All nodes' displacements (v, 3), m, of a frame; those that are kept are."""
        self.displacement[frame] = displacement if self._rows is None else displacement[self._rows]

    def put_rest(self, frame: int) -> None:
        """Nothing moved at a frame."""
        self.displacement[frame] = 0.0

    def give_up(self, frame: int, status: FrameStatus) -> None:
        """A frame that has no solution, and why."""
        self.status[frame] = status

    def history(self) -> GelHistory:
        """What was recorded."""
        return GelHistory(
            self.wrench,
            self.displacement,
            self.node_forces,
            self.gaps,
            self.status,
            self.residual,
            self.iterations,
            self.pressed,
        )

"""Arrays of one trajectory's answer, filled frame by frame."""

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
    """Arrays of a ``GelHistory``; the row of a frame is NaN until it is solved.

    Parameters
    ----------
    count : int
        Number of frames.
    mesh : PadMesh
        Gives the number of nodes.
    surface : ContactSurface
        Gives the surface nodes and the patches.
    youngs_modulus : Pa
        Factor on wrenches and forces, which are solved for a modulus of 1.
    keep : "all", "surface" or "none"
        Nodes whose displacements are kept.
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
        self.resumed = np.zeros(count, dtype=bool)

    def keep(self, frame: int, path: ContactPath, residual: float, is_resumed: bool = False) -> None:
        """Record the solved contact of a frame; ``put_displacement`` must follow.

        Parameters
        ----------
        frame : int
        path : ContactPath
            Its state is the equilibrium.
        residual : float
            Largest unbalanced nodal force over the largest contact force.
        is_resumed : bool
            Whether the gel was pressed anew after a failure, so that friction does not know all of the path.
        """
        self.resumed[frame] = is_resumed
        self.wrench[frame] = path.wrench() * self._modulus
        self.node_forces[frame] = self._surface.averaging.T @ path.state.forces * self._modulus
        self.gaps[frame] = path.state.gaps
        self.pressed[frame] = path.state.forces.any(axis=1)
        is_touching = bool(self.pressed[frame].any())
        self.status[frame] = FrameStatus.SOLVED if is_touching else FrameStatus.NO_CONTACT
        self.residual[frame] = residual

    @property
    def keeps_displacement(self) -> bool:
        """Whether any node's displacement is kept."""
        return self.displacement.shape[1] > 0

    def put_displacement(self, frame: int, displacement: Array) -> None:
        """Record the displacements of a frame, from those of all nodes (v, 3), m."""
        self.displacement[frame] = displacement if self._rows is None else displacement[self._rows]

    def put_rest(self, frame: int) -> None:
        """Record zero displacement at a frame."""
        self.displacement[frame] = 0.0

    def give_up(self, frame: int, status: FrameStatus) -> None:
        """Record why a frame has no solution."""
        self.status[frame] = status

    def history(self) -> GelHistory:
        """Return the arrays as the answer of the engine."""
        return GelHistory(
            wrench=self.wrench,
            displacement=self.displacement,
            node_forces=self.node_forces,
            gaps=self.gaps,
            status=self.status,
            residual=self.residual,
            iterations=self.iterations,
            pressed=self.pressed,
            resumed=self.resumed,
        )

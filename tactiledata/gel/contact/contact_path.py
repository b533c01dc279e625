"""One trajectory on its way through the gel: where it stands, and one iteration of its contact."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from tactiledata.arrays import Array, Indices
from tactiledata.gel.contact.friction import solve_contact
from tactiledata.gel.contact.gap import APART, height_above, patch_gaps
from tactiledata.gel.contact.relief import IndenterRelief
from tactiledata.gel.mesh.surface import ContactSurface

LOOK_AROUND = 4e-4
"""m: faces this near the indenter are searched for contact during a step."""
MAY_TOUCH = 2e-4
"""m: patches this near take part in the contact's iterations."""
LOOKS = 6
"""Iterations of a step after which it stands which points lie under the indenter: an edge that passes over a point
changes the equations, and with it the point, to and fro for ever."""
LARGEST_STEP = 1.5e-4
"""m: an indenter that moves further between two frames is followed in parts."""


@dataclass
class ContactState:
    """The contact at one moment of a trajectory.

    Parameters
    ----------
    pose : (4, 4), gel_from_indenter
    forces : (m, 3) m^2
        Patch forces on the gel over Young's modulus.
    displacement : (r, 3) m
        Of all nodes, or of the surface alone: see ``ContactPath.rows``.
    gaps : (m,) m
    """

    pose: Array
    forces: Array
    displacement: Array
    gaps: Array

    @property
    def is_touching(self) -> bool:
        """Whether any patch is pressed."""
        return bool(self.forces.any())


@dataclass
class ContactPath:
    """The contact of one indenter with the gel along its path.

    Parameters
    ----------
    surface : ContactSurface
    compliance : (m, m, 3, 3)
    rest : (s, 3) m
        Surface nodes, undeformed.
    rows : (s,)
        Of the surface nodes in the state's displacement.
    relief : IndenterRelief
    friction : float
    state : ContactState
        At the last pose that was solved.
    """

    surface: ContactSurface
    compliance: NDArray[np.float32]
    rest: Array
    rows: Indices
    relief: IndenterRelief
    friction: float
    state: ContactState
    _faces: Indices = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    _pose: Array = field(default_factory=lambda: np.eye(4))
    _carried: Array = field(default_factory=lambda: np.empty((0, 3)))
    _openings: Array = field(default_factory=lambda: np.empty(0))
    _under: NDArray[np.int8] = field(default_factory=lambda: np.empty((0, 0), dtype=np.int8))
    _looks: int = 0

    def move_to(self, pose: Array) -> bool:
        """Set out for the next pose (4, 4); whether anything may touch there."""
        here = self.rest + self.state.displacement[self.rows]
        # nothing is known of the pose before a touch's first
        step = float(np.nan_to_num(np.linalg.norm(pose[:3, 3] - self.state.pose[:3, 3])))
        near = height_above(here, self.relief, pose) < LOOK_AROUND + step
        self._faces = np.flatnonzero(near[self.surface.faces].any(axis=1))
        self._pose = pose
        self._looks = 0
        patches = self.surface.averaging @ here
        moved = pose @ np.linalg.inv(self.state.pose) if np.isfinite(self.state.pose).all() else np.eye(4)
        self._carried = patches @ moved[:3, :3].T + moved[:3, 3]
        is_touching = self.state.forces.any(axis=1)
        self._openings = np.where(is_touching, 0.0, np.clip(self.state.gaps, 1e-9, APART))
        return len(self._faces) > 0 or self.state.is_touching

    def press(self, displacement: Array, forces: Array, sweeps: int, tolerance: float) -> tuple[Array, Array]:
        """Better patch forces (m, 3) at a displacement (r, 3) that the given forces hold, and the gaps (m,) there."""
        positions = self.rest + displacement[self.rows]
        self._looks += 1
        if self._looks <= LOOKS:
            self._under = np.full((len(self._faces), len(self.surface.shapes)), -1, dtype=np.int8)
        gaps, normals, covers = patch_gaps(self.surface, self._faces, positions, self.relief, self._pose, self._under)
        patches = np.flatnonzero((gaps < MAY_TOUCH) | forces.any(axis=1))
        improved = forces[patches]
        slips = (self.surface.averaging @ positions)[patches] - self._carried[patches]
        solve_contact(
            self.compliance,
            patches,
            improved,
            normals[patches],
            gaps[patches],
            slips,
            self._openings[patches],
            np.clip(covers[patches], 0.05, 1.0),
            self.friction,
            sweeps,
            tolerance,
        )
        pressed = np.zeros_like(forces)
        pressed[patches] = improved
        return pressed, gaps

    def accept_step(self, displacement: Array, forces: Array, gaps: Array) -> None:
        """The pose headed for is solved."""
        self.state = ContactState(self._pose, forces, displacement, gaps)

    def release(self) -> None:
        """Nothing touches at the pose headed for: the gel is at rest."""
        self.state = ContactState(
            self._pose,
            np.zeros_like(self.state.forces),
            np.zeros_like(self.state.displacement),
            np.full(len(self.state.gaps), APART),
        )

    def wrench(self) -> Array:
        """What the gel exerts on the indenter (6,), over Young's modulus, about the gel's origin."""
        places = self.surface.averaging @ (self.rest + self.state.displacement[self.rows])
        return -np.concatenate([self.state.forces.sum(axis=0), np.cross(places, self.state.forces).sum(axis=0)])


def way_points(start: Array, end: Array, parts: int) -> list[Array]:
    """Poses (4, 4) that lead from one to another in equal parts, the last one included."""
    turns = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], end[:3, :3]]))
    poses = []
    for share in np.arange(1, parts + 1) / parts:
        pose = np.eye(4)
        pose[:3, :3] = turns(share).as_matrix()
        pose[:3, 3] = (1 - share) * start[:3, 3] + share * end[:3, 3]
        poses.append(pose)
    poses[-1] = end
    return poses

"""Contact of one indenter along its path: the state at the last solved pose, and one contact iteration at the next."""

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
"""Largest distance, m, from the indenter at which faces are searched for contact during a step."""
MAY_TOUCH = 2e-4
"""Largest gap, m, of the patches that take part in a contact iteration."""
COVER_UPDATES = 6
"""Iterations of a step after which the set of points under the indenter is frozen.

Otherwise a point at an edge of the indenter can be covered and uncovered in turns for ever."""
LARGEST_STEP = 1.5e-4
"""Largest motion of the indenter, m, in one load step; a larger one between two frames is divided."""


@dataclass
class ContactState:
    """Equilibrium of the contact at one pose of a trajectory.

    Parameters
    ----------
    pose : (4, 4)
        gel_from_indenter, metres.
    forces : (m, 3) m^2
        Patch forces on the gel over Young's modulus.
    displacement : (r, 3) m
        Displacements of all nodes, or of the surface alone: see ``ContactPath.rows``.
    gaps : (m,) m
        Mean distance of each patch from the indenter.
    """

    pose: Array
    forces: Array
    displacement: Array
    gaps: Array

    @property
    def is_touching(self) -> bool:
        """Whether any patch is pressed."""
        return bool(self.forces.any())


@dataclass(frozen=True)
class Ahead:
    """What a Newton step will do to the patches without a change of their forces, and how it answers to a change.

    Parameters
    ----------
    shift : (m, 3) m
        Mean displacement of each patch by the step, at the present forces.
    members : (k,)
        Patches that may be pressed.
    compliance : (k, k, 3, 3) 1/m
        Mean displacement of a member by a unit force on a member, for a Young's modulus of 1.
    """

    shift: Array
    members: Indices
    compliance: NDArray[np.float32]


@dataclass
class ContactPath:
    """Contact of one indenter with the gel along its path.

    Parameters
    ----------
    surface : ContactSurface
        Surface of the pad, with its m patches.
    compliance : (m, m, 3, 3) 1/m
        Mean displacement of a patch by a unit force on a patch, for a Young's modulus of 1.
    rest : (s, 3) m
        Undeformed surface nodes, gel frame.
    rows : (s,)
        Rows of the surface nodes in the state's displacement.
    relief : IndenterRelief
        Underside of the indenter.
    friction : float
        Coefficient of Coulomb friction.
    state : ContactState
        Equilibrium at the last pose that was solved.
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
        """Start the next pose (4, 4), gel_from_indenter; return whether anything may touch there."""
        positions = self.rest + self.state.displacement[self.rows]
        # find the faces near the indenter; the pose before a trajectory's first is unknown (NaN)
        step = float(np.nan_to_num(np.linalg.norm(pose[:3, 3] - self.state.pose[:3, 3])))
        near = height_above(positions, self.relief, pose) < LOOK_AROUND + step
        self._faces = np.flatnonzero(near[self.surface.faces].any(axis=1))
        self._pose = pose
        self._looks = 0
        # places to which patches would move if they stuck to the indenter: slip is measured from these
        patches = self.surface.averaging @ positions
        motion = pose @ np.linalg.inv(self.state.pose) if np.isfinite(self.state.pose).all() else np.eye(4)
        self._carried = patches @ motion[:3, :3].T + motion[:3, 3]
        is_touching = self.state.forces.any(axis=1)
        self._openings = np.where(is_touching, 0.0, np.clip(self.state.gaps, 1e-9, APART))
        return len(self._faces) > 0 or self.state.is_touching

    def nodes_in_reach(self) -> Indices:
        """Return the surface nodes (k,) on whose displacement the contact at the pose of ``move_to`` depends.

        These are the nodes of all patches that a searched face belongs to, and of those that carry a force.
        """
        in_reach = np.asarray(self.state.forces.any(axis=1))
        in_reach[self.surface.face_corners[self._faces].ravel()] = True
        is_node = np.zeros(len(self.rest), dtype=bool)
        is_node[self.surface.faces[self._faces].ravel()] = True
        return np.flatnonzero(is_node | (self.surface.averaging.T @ in_reach > 0))

    def press(
        self, displacement: Array, forces: Array, sweeps: int, tolerance: float, ahead: Ahead | None = None
    ) -> tuple[Array, Array]:
        """Improve the patch forces at a displacement of the gel; return them (m, 3), m^2, and the gaps (m,), m.

        Parameters
        ----------
        displacement : (r, 3) m
            Displacement of the present iterate.
        forces : (m, 3) m^2
            Patch forces that belong to it, over Young's modulus.
        sweeps : int
            Most Gauss-Seidel sweeps over the patches.
        tolerance : float
            Relative change of the forces at which sweeps end.
        ahead : Ahead, optional
            Linearised step for which the forces are sought; by default they are sought at the displacement itself, with
            the compliance of the pad at rest.
        """
        positions = self.rest + displacement[self.rows]
        self._looks += 1
        if self._looks <= COVER_UPDATES:
            self._under = self._undecided()
        gaps, normals, covers = patch_gaps(self.surface, self._faces, positions, self.relief, self._pose, self._under)
        places = self.surface.averaging @ positions
        if ahead is None:
            patches = np.flatnonzero((gaps < MAY_TOUCH) | forces.any(axis=1))
            compliance, rows, distances = self.compliance, patches, gaps
        else:
            distances = gaps + np.where(gaps < APART, (normals * ahead.shift).sum(axis=1), 0.0)
            places = places + ahead.shift
            rows = np.flatnonzero((distances < MAY_TOUCH)[ahead.members] | forces[ahead.members].any(axis=1))
            compliance, patches = ahead.compliance, ahead.members[rows]
        # solve the contact of the patches that may touch
        improved = forces[patches]
        slips = places[patches] - self._carried[patches]
        solve_contact(
            compliance,
            rows,
            improved,
            normals[patches],
            distances[patches],
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

    def gaps(self, displacement: Array) -> Array:
        """Return the gaps (m,), m, from the indenter at the pose of ``move_to``, at displacements (r, 3), m."""
        positions = self.rest + displacement[self.rows]
        return patch_gaps(self.surface, self._faces, positions, self.relief, self._pose, self._undecided())[0]

    def _undecided(self) -> NDArray[np.int8]:
        """Marks (k, q) of the points of the searched faces, by which is decided anew whether they are covered."""
        return np.full((len(self._faces), len(self.surface.shapes)), -1, dtype=np.int8)

    def accept_step(self, displacement: Array, forces: Array, gaps: Array) -> None:
        """Take an equilibrium at the pose of ``move_to`` as the new state.

        Parameters
        ----------
        displacement : (r, 3) m
        forces : (m, 3) m^2
            Patch forces over Young's modulus.
        gaps : (m,) m
        """
        self.state = ContactState(self._pose, forces, displacement, gaps)

    def release(self) -> None:
        """Take the gel at rest as the state at the pose of ``move_to``, where nothing touches."""
        self._rest_at(self._pose)

    def forget(self) -> None:
        """Take the gel at rest as the state, at an unknown pose."""
        self._rest_at(np.full((4, 4), np.nan))

    def _rest_at(self, pose: Array) -> None:
        """Take the gel at rest as the state at a pose (4, 4)."""
        self.state = ContactState(
            pose,
            np.zeros_like(self.state.forces),
            np.zeros_like(self.state.displacement),
            np.full(len(self.state.gaps), APART),
        )

    def wrench(self) -> Array:
        """Wrench (6,), m^2 and m^3, of the gel on the indenter over Young's modulus, about the gel's origin."""
        places = self.surface.averaging @ (self.rest + self.state.displacement[self.rows])
        return -np.concatenate([self.state.forces.sum(axis=0), np.cross(places, self.state.forces).sum(axis=0)])


def interpolated_poses(start: Array, end: Array, parts: int) -> list[Array]:
    """Interpolated poses (4, 4) from ``start``, excluded, to ``end``, included, in equal parts.

    Parameters
    ----------
    start, end : (4, 4)
        Positions are interpolated linearly, rotations by slerp.
    parts : int
        Number of poses returned.
    """
    turns = Slerp([0.0, 1.0], Rotation.from_matrix([start[:3, :3], end[:3, :3]]))
    poses = []
    for share in np.arange(1, parts + 1) / parts:
        pose = np.eye(4)
        pose[:3, :3] = turns(share).as_matrix()
        pose[:3, 3] = (1 - share) * start[:3, 3] + share * end[:3, 3]
        poses.append(pose)
    poses[-1] = end
    return poses

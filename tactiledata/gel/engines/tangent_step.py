"""Newton iterations of one load step with the pad's tangent stiffness at the present state, for where others fail."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.gel.contact.contact_path import Ahead, ContactPath
from tactiledata.gel.elasticity.deformed import DeformedPad, TangentFactory
from tactiledata.gel.elasticity.internal_forces import ElasticPad, internal_forces
from tactiledata.gel.elasticity.mixing import SecantMixer
from tactiledata.gel.elasticity.stiffening import Stiffening
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.surface import ContactSurface

TOLERANCE = 5e-7
"""Largest change of a node's position, m, in the iteration that completes a load step.

A quarter of that of the usual iterations: a filtered tangent is too stiff, so that more is left than a change shows."""
USUAL_TOLERANCE = 2e-6
"""m: that of the usual iterations, to which ``TOLERANCE`` belongs."""
FORCE_TOLERANCE = 2.5e-3
"""Largest change of a patch force in that iteration, as a share of the largest force; the sum changes far less."""
MOST_ITERATIONS = 60
"""Iterations after which a load step has failed."""
PATIENCE = (20, 40)
"""Iterations after which the tolerances are ``LENIENCE`` times as large, each time.

After the first, only half of each change of force is made."""
LENIENCE = 4.0
"""Factor on the tolerances."""
SWEEPS = 60
"""Most sweeps of the contact solver in each iteration."""
PROBATION = 12
"""Iterations after which a tangent is made anew where the step has not been solved; it costs about 35 of them."""
FARTHEST = 5e-3
"""Displacement of a node, m, beyond which an iterate has diverged."""
MAY_JOIN = 1.2e-4
"""Largest gap, m, of the patches whose compliance is computed with a tangent."""
SHORTEST = 1.0 / 32.0
"""Smallest share of a Newton step that is tried."""
MOST_BACK = 0.5
"""Largest slope of the energy after a step, as a share of the slope before it."""


@dataclass(frozen=True)
class Body:
    """Parts of one engine that the iterations need.

    Parameters
    ----------
    mesh : PadMesh
        Gives the nodes that are held.
    elastic : ElasticPad
        Nodal forces of the mesh.
    surface : ContactSurface
        Patches of the mesh.
    poisson_ratio : float
        Of the gel.
    stiffening : Stiffening
        Yeoh's terms of the law.
    tangents : TangentFactory
        Makes factorised tangents.
    """

    mesh: PadMesh
    elastic: ElasticPad
    surface: ContactSurface
    poisson_ratio: float
    stiffening: Stiffening
    tangents: TangentFactory

    def unbalanced(self, displacement: Array, forces: Array) -> Array:
        """Nodal forces (v, 3), m^2, that displacements (v, 3) ask for beyond patch forces (m, 3); 0 where held."""
        inner = internal_forces(self.elastic, displacement[None], self.poisson_ratio, None, self.stiffening)[0]
        inner[self.surface.nodes] -= self.surface.averaging.T @ forces
        inner[self.mesh.base] = 0.0
        return inner


@dataclass(frozen=True)
class Iterate:
    """Displacements (v, 3), m, patch forces (m, 3), m^2, gaps (m,), m, and the residual, of a solved load step."""

    displacement: Array
    forces: Array
    gaps: Array
    residual: float


class TangentStep:
    """Newton iterations from the last solved state of a path to the pose of its ``move_to``.

    The contact is solved for the linearised pad in each iteration. A tangent is kept, from load step to load step too,
    until it needs more than ``PROBATION`` iterations; iterations are accelerated by Anderson's method, and shortened
    where they go too far.

    Parameters
    ----------
    body : Body
        Parts of the engine.
    tolerance : m
        Largest change of a node's position in the iteration that completes a step.
    """

    def __init__(self, body: Body, tolerance: float) -> None:
        self._body = body
        self._scale = tolerance / USUAL_TOLERANCE
        self._tangent: DeformedPad | None = None
        self._displacement: Array = np.empty((0, 3))
        self._forces: Array = np.empty((0, 3))
        self._iterations = self._age = 0
        self._mixer: SecantMixer | None = None
        # where one tangent had to be filtered, the next ones of the touch are filtered at once
        self._is_filtered = False

    def forget(self) -> None:
        """Drop the tangent."""
        self._tangent = None
        self._is_filtered = False

    def start(self, path: ContactPath) -> None:
        """Start the load step of the path's present pose, from its state."""
        self._displacement, self._forces = path.state.displacement, path.state.forces
        self._iterations = self._age = 0
        if self._mixer is not None:
            self._mixer.start_step()

    @property
    def has_failed(self) -> bool:
        """Whether the iterations of this step are used up."""
        return self._iterations >= MOST_ITERATIONS

    def iterate(self, path: ContactPath) -> Iterate | None:
        """Make one iteration; return the equilibrium where it has been found."""
        body, displacement, forces = self._body, self._displacement, self._forces
        self._iterations += 1
        if not np.abs(displacement).max() < FARTHEST:
            self._iterations = MOST_ITERATIONS
            return None
        if self._tangent is None:
            self._renew(path)
        tangent = self._tangent
        assert tangent is not None
        # what a Newton step does with the present forces, then the forces that the contact wants after it
        free_step = -tangent.solve(body.unbalanced(displacement, forces))
        ahead = Ahead(body.surface.averaging @ free_step[body.surface.nodes], tangent.members, tangent.compliance)
        pressed, gaps = path.press(displacement, forces, SWEEPS, FORCE_TOLERANCE / 10, ahead)
        largest = max(float(np.abs(pressed).max()), 1e-30)
        force_change = float(np.abs(pressed - forces).max()) / (FORCE_TOLERANCE * self._scale * largest)
        if self._iterations > PATIENCE[0]:
            # contact at edges can alternate between two solutions; their mean is nearer
            pressed = (forces + pressed) / 2
        unbalanced = body.unbalanced(displacement, pressed)
        step = -tangent.solve(unbalanced)
        change = max(float(np.abs(step).max()) / (TOLERANCE * self._scale), force_change)
        missed = np.setdiff1d(np.flatnonzero(gaps < 0), tangent.members)
        if change < LENIENCE ** sum(self._iterations > patience for patience in PATIENCE) and not len(missed):
            residual = float(np.abs(unbalanced).max()) / largest if largest > 1e-30 else 0.0
            return Iterate(displacement + step, pressed, gaps, residual)
        self._age += 1
        share = self._share(displacement, pressed, step, unbalanced)
        self._forces = pressed
        self._displacement = displacement + max(share, SHORTEST) * step
        if share == 1:
            self._mix(displacement, forces, unbalanced)
        elif self._mixer is not None:
            self._mixer.start_step()
        if len(missed) or (share < 1 and self._age > 1) or self._age >= PROBATION:
            self._tangent = None
        return None

    def _mix(self, displacement: Array, forces: Array, unbalanced: Array) -> None:
        """Accelerate the iteration from ``displacement`` (v, 3) and ``forces`` (m, 3) to the present iterate.

        The accelerated iterate is taken where it is not much farther from equilibrium than the last one.
        """
        if self._mixer is None:
            self._mixer = SecantMixer(displacement.size + forces.size, np.arange(displacement.size))
        point = np.concatenate([displacement.ravel(), forces.ravel()])
        image = np.concatenate([self._displacement.ravel(), self._forces.ravel()])
        mixed = self._mixer.mix(point, image)
        moved = mixed[: displacement.size].reshape(displacement.shape)
        pressed = mixed[displacement.size :].reshape(forces.shape)
        farther = np.linalg.norm(self._body.unbalanced(moved, pressed))
        if farther <= np.linalg.norm(unbalanced):
            self._displacement, self._forces = moved, pressed

    def _share(self, displacement: Array, forces: Array, step: Array, unbalanced: Array) -> float:
        """Share of a step after which the unbalanced forces do not push back too much; 0 where there is none.

        Along the step, the work of the unbalanced forces is the slope of the energy: it begins negative, and where it
        has become as large and positive, the step has gone twice too far.
        """
        share, slope = 1.0, float((unbalanced * step).sum())
        while share >= SHORTEST:
            after = self._body.unbalanced(displacement + share * step, forces)
            if float((after * step).sum()) <= MOST_BACK * abs(slope):
                return share
            share /= 2
        return 0.0

    def _renew(self, path: ContactPath) -> None:
        """Factorise the tangent at the present iterate."""
        gaps = path.gaps(self._displacement)
        members = np.flatnonzero((gaps < MAY_JOIN) | self._forces.any(axis=1))
        self._tangent = self._body.tangents.at(self._displacement, members, self._is_filtered)
        self._is_filtered = self._tangent.is_filtered
        self._age = 0
        if self._mixer is not None:
            self._mixer.forget()

"""Answer of the gel engine to a trajectory, in the form on which effects act."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.effects.touch.gel_variants import contact_height
from tactiledata.effects.touch.response import ContactResponse, GelVariant
from tactiledata.effects.touch.shear_stiffness import shear_stiffness
from tactiledata.effects.touch.state import wrench_at
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.contact.history import GelHistory
from tactiledata.gel.mesh.pad import PadMesh

SLIDES = 0.95
"""Share of Coulomb's limit above which the whole contact counts as sliding."""


@dataclass(frozen=True)
class PlayedAnswer:
    """`BaseResponse` of a touch that was simulated with the effects' gel, at the poses to which they moved it.

    It is not simulated again. Another friction acts on the shear of each frame alone: the shear of a sliding contact
    changes in proportion, that of a sticking contact is cut at the limit.

    Parameters
    ----------
    contact : ContactResponse
        Wrench, area, centre, depth, slip and shear stiffness of n frames.
    limit : (n,) N
        Friction times normal force.
    tips : (n, 3) m
        Place of the indenter's tip, gel frame.
    """

    contact: ContactResponse
    limit: Array
    tips: Array

    @staticmethod
    def of(history: GelHistory, rows: Mask, poses: Array, mesh: PadMesh, areas: Array, touch: Touch) -> PlayedAnswer:
        """Response at some of the frames that were simulated.

        Parameters
        ----------
        history : GelHistory
            Answer of the engine.
        rows : (n,) bool
            Mask of the frames that are used.
        poses : (n, 4, 4)
            Poses that were simulated, gel_from_indenter, metres.
        mesh : PadMesh
            Mesh of the pad; its surface gives depths.
        areas : (m,) m^2
            Areas of the patches.
        touch : Touch
            Material and geometry.
        """
        wrench, tips, gel = history.wrench[rows], poses[rows, :3, 3], touch.material
        area = history.pressed[rows] @ areas
        depth = contact_height(mesh, touch.indenter, poses[rows]) - tips[:, 2]
        touching = (area > 0) & (wrench[:, 2] > 0)
        normal = np.where(touching, wrench[:, 2], 1.0)
        # centre of pressure, from the torque M = r x F with r at the height of the tip
        x = (tips[:, 2] * wrench[:, 0] - wrench[:, 4]) / normal
        y = (wrench[:, 3] + tips[:, 2] * wrench[:, 1]) / normal
        centre = np.where(touching[:, None], np.column_stack([x, y]), tips[:, :2])
        # Coulomb's limit, and the stiffness of the contact in shear
        limit = np.where(touching, gel.friction * normal, 0.0)
        sliding = touching & (np.hypot(wrench[:, 0], wrench[:, 1]) >= SLIDES * limit)
        spring = gel.youngs_modulus * shear_stiffness(area, gel.poisson_ratio, touch.geometry.thickness)
        return PlayedAnswer(ContactResponse(wrench, area, centre, depth, sliding, spring), limit, tips)

    @staticmethod
    def untouched(poses: Array) -> PlayedAnswer:
        """Response without contact at poses (n, 4, 4), for the state before the first simulation."""
        count, tips = len(poses), poses[:, :3, 3]
        zeros = np.zeros(count)
        contact = ContactResponse(np.zeros((count, 6)), zeros, tips[:, :2], -np.ones(count), zeros.astype(bool), zeros)
        return PlayedAnswer(contact, zeros, tips)

    def respond(self, offset: Array, shift: Array, friction: Array) -> ContactResponse:
        """Return the response with friction multiplied by factors (n,).

        Parameters
        ----------
        offset, shift : arrays
            Ignored: the simulated poses contain them.
        friction : (n,)
            Factor on the coefficient of friction.
        """
        contact = self.contact
        if (friction == 1.0).all():
            return contact
        shear = np.hypot(contact.wrench[:, 0], contact.wrench[:, 1])
        target = np.where(contact.sliding, shear * friction, np.minimum(shear, self.limit * friction))
        share = np.divide(target, shear, out=np.ones_like(shear), where=shear > 0) - 1.0
        force = contact.wrench[:, :3] * np.column_stack([share, share, np.zeros(len(share))])
        change = wrench_at(force, np.column_stack([contact.centre, self.tips[:, 2]]))
        sliding = contact.touching & (target >= SLIDES * self.limit * friction)
        return replace(contact, wrench=contact.wrench + change, sliding=sliding)

    def difference(self, variant: GelVariant) -> Array:
        """Return zeros (n, 6): the simulation was already made on the variant's gel."""
        return np.zeros((len(self.limit), 6))

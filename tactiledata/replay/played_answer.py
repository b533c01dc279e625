"""What the gel engine answered to a trajectory, for effects that work on the answer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.effects.touch.gel_variants import surface_height
from tactiledata.effects.touch.response import ContactResponse, GelVariant
from tactiledata.effects.touch.shear_stiffness import shear_stiffness
from tactiledata.effects.touch.state import wrench_at
from tactiledata.effects.touch.touch import Touch
from tactiledata.gel.contact.history import GelHistory
from tactiledata.gel.mesh.pad import PadMesh

SLIDES = 0.95
"""Share of Coulomb's limit from which the whole contact is taken to slide."""


@dataclass(frozen=True)
class PlayedAnswer:
    """`BaseResponse` of a touch that was played where the effects had moved it, on the gel that they stand for.

    It is not played again: friction of another size is an operator on the shear, for which neighbouring frames do not
    matter. What slides goes on sliding, with a shear in proportion; what sticks is cut off at the limit.

    Parameters
    ----------
    contact : ContactResponse
    limit : (n,) N
        Friction times normal force.
    tips : (n, 3) m
        Where the indenter was.
    """

    contact: ContactResponse
    limit: Array
    tips: Array

    @staticmethod
    def of(history: GelHistory, rows: Mask, poses: Array, mesh: PadMesh, areas: Array, touch: Touch) -> PlayedAnswer:
        """Of some of the frames that were played.

        Parameters
        ----------
        rows : (n,) bool
        poses : (n, 4, 4)
            That were played.
        areas : (m,) m^2
            Of the patches.
        touch : Touch
            Of these frames, with its material and geometry.
        """
        wrench, tips, gel = history.wrench[rows], poses[rows, :3, 3], touch.material
        area = history.pressed[rows] @ areas
        depth = surface_height(mesh, tips[:, :2]) - tips[:, 2]
        touching = (area > 0) & (wrench[:, 2] > 0)
        normal = np.where(touching, wrench[:, 2], 1.0)
        # of the pressure on the surface: M = r x F with r at the height of the tip
        x = (tips[:, 2] * wrench[:, 0] - wrench[:, 4]) / normal
        y = (wrench[:, 3] + tips[:, 2] * wrench[:, 1]) / normal
        centre = np.where(touching[:, None], np.column_stack([x, y]), tips[:, :2])
        limit = np.where(touching, gel.friction * normal, 0.0)
        sliding = touching & (np.hypot(wrench[:, 0], wrench[:, 1]) >= SLIDES * limit)
        spring = gel.youngs_modulus * shear_stiffness(area, gel.poisson_ratio, touch.geometry.thickness)
        return PlayedAnswer(ContactResponse(wrench, area, centre, depth, sliding, spring), limit, tips)

    @staticmethod
    def untouched(poses: Array) -> PlayedAnswer:
        """Before anything is played: nothing touches (n, 4, 4)."""
        count, tips = len(poses), poses[:, :3, 3]
        nothing = np.zeros(count)
        contact = ContactResponse(
            np.zeros((count, 6)), nothing, tips[:, :2], -np.ones(count), nothing.astype(bool), nothing
        )
        return PlayedAnswer(contact, nothing, tips)

    def respond(self, offset: Array, shift: Array, friction: Array) -> ContactResponse:
        """As `BaseResponse.respond`; offset and shift were played already."""
        contact = self.contact
        if (friction == 1.0).all():
            return contact
        shear = np.hypot(contact.wrench[:, 0], contact.wrench[:, 1])
        wanted = np.where(contact.sliding, shear * friction, np.minimum(shear, self.limit * friction))
        share = np.divide(wanted, shear, out=np.ones_like(shear), where=shear > 0) - 1.0
        force = contact.wrench[:, :3] * np.column_stack([share, share, np.zeros(len(share))])
        change = wrench_at(force, np.column_stack([contact.centre, self.tips[:, 2]]))
        sliding = contact.touching & (wanted >= SLIDES * self.limit * friction)
        return replace(contact, wrench=contact.wrench + change, sliding=sliding)

    def difference(self, variant: GelVariant) -> Array:
        """As `BaseResponse.difference`: none, as it is the variant that was played."""
        return np.zeros((len(self.limit), 6))

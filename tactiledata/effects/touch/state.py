"""A touch on its way through the effects: what they ask of the gel, and the wrench that comes of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.touch.response import BaseResponse, ContactResponse
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError


@dataclass(frozen=True)
class TouchState:
    """One touch of n frames. Effects in the slots P, K, C and I add to what is asked; the gel then answers all at once.

    Parameters
    ----------
    touch : Touch
    base : BaseResponse
    felt : (n, 6) N, N m
        The wrench that bends arm and stem: the answer of the round before, where an effect feeds back.
    offset : (n,) m, shift : (n, 2) m
        How much deeper and further along x and y the indenter is than recorded.
    friction : (n,)
        Factor on Coulomb's coefficient.
    stiffness : (n,)
        Factor on the elastic wrench.
    elastic, interface : (n, 6) N, N m
        Added to the base's wrench before the stiffness multiplies it, and after.
    reading : (n, 6) N, N m, optional
        What the sensor says, in the slots T and S; ``None`` before.
    """

    touch: Touch
    base: BaseResponse
    felt: Array
    offset: Array
    shift: Array
    friction: Array
    stiffness: Array
    elastic: Array
    interface: Array
    reading: Array | None = None

    @staticmethod
    def start(touch: Touch, base: BaseResponse) -> TouchState:
        """The touch as recorded, before any effect."""
        n = len(touch)
        # x + (-0.0) is x, for every x: sums that nobody added to leave no trace
        nothing = np.full((n, 6), -0.0)
        return TouchState(touch, base, nothing, np.zeros(n), np.zeros((n, 2)), np.ones(n), np.ones(n), nothing, nothing)

    @cached_property
    def _answer(self) -> ContactResponse:
        """What the simulation below answers: dear, and the same for all that does not move the indenter or rub."""
        return self.base.respond(self.offset, self.shift, self.friction)

    def _as_asked(self, changed: TouchState) -> TouchState:
        """A state that asks the simulation below for the same, with its answer, if it is known."""
        if "_answer" in self.__dict__:
            changed.__dict__["_answer"] = self._answer
        return changed

    @cached_property
    def contact(self) -> ContactResponse:
        """The gel's answer to all that is asked so far."""
        plain = self._answer
        wrench = (plain.wrench + self.elastic) * self.stiffness[:, None] + self.interface
        return ContactResponse(wrench, plain.area, plain.centre, plain.depth, plain.sliding, plain.spring)

    @property
    def wrench(self) -> Array:
        """The wrench (n, 6): the reading where there is one, the gel's answer before."""
        return self.contact.wrench if self.reading is None else self.reading

    @property
    def moved_poses(self) -> Array:
        """gel_from_indenter (n, 4, 4) with the indenter where the effects have moved it: to replay the gel with."""
        poses = self.touch.poses.copy()
        poses[:, :2, 3] += self.shift
        poses[:, 2, 3] -= self.offset
        return poses

    def moved(self, deeper: Array | float = 0.0, along: Array | float = 0.0) -> TouchState:
        """The indenter deeper by (n,) m and further by (n, 2) m."""
        return replace(self, offset=self.offset + deeper, shift=self.shift + along)

    def rubbed(self, factor: Array) -> TouchState:
        """Friction multiplied by factors (n,); one below 0 counts as 0."""
        return replace(self, friction=self.friction * np.maximum(factor, 0.0))

    def stiffened(self, factor: Array) -> TouchState:
        """The elastic wrench multiplied by factors (n,)."""
        return self._as_asked(replace(self, stiffness=self.stiffness * factor))

    def with_elastic(self, wrench: Array) -> TouchState:
        """A wrench (n, 6) added that is the gel's own, so that its stiffness multiplies it."""
        return self._as_asked(replace(self, elastic=self.elastic + wrench))

    def with_interface(self, wrench: Array) -> TouchState:
        """A wrench (n, 6) added that arises where indenter and gel meet."""
        return self._as_asked(replace(self, interface=self.interface + wrench))

    def with_reading(self, wrench: Array) -> TouchState:
        """The sensor says this wrench (n, 6)."""
        return self._as_asked(replace(self, reading=wrench))

    def covariate(self, name: str, effect: str) -> Any:
        """A field of the touch that an effect depends on.

        Raises
        ------
        UsageError
            The recording does not tell it.
        """
        value = getattr(self.touch, name)
        if value is None:
            raise UsageError(
                f"effect {effect!r} depends on {name!r}, which this touch does not tell",
                f"a touch with {name!r}",
                "Record it, or leave the effect out.",
                effect=effect,
                covariate=name,
            )
        return value


def torque_of(force: Array, at: Array) -> Array:
    """Torques (n, 3) about the origin of forces (n, 3) that act at points (n, 3)."""
    (x, y, z), (fx, fy, fz) = at.T, force.T
    return np.stack([y * fz - z * fy, z * fx - x * fz, x * fy - y * fx], axis=1)


def wrench_at(force: Array, at: Array) -> Array:
    """Wrenches (n, 6) about the gel's origin of forces (n, 3) that act at points (n, 2) or (n, 3)."""
    points = at if at.shape[1] == 3 else np.column_stack([at, np.zeros(len(at))])
    return np.concatenate([force, torque_of(force, points)], axis=1)

"""A touch between two effects: what they ask of the gel so far, and the wrench that results."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.touch.response import BaseResponse, ContactResponse
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError


@dataclass(frozen=True)
class TouchState:
    """One touch of n frames with the changes of effects: those in contact change what the gel is asked.

    Parameters
    ----------
    touch : Touch
        The touch as recorded.
    base : BaseResponse
        The simulation that answers for it.
    felt : (n, 6) N, N m
        Wrench that bends arm and stem: the answer of the iteration before, where an effect feeds back.
    offset : (n,) m
        How much deeper the indenter is than recorded.
    shift : (n, 2) m
        How much further along x and y of the gel frame the indenter is than recorded.
    friction : (n,)
        Factor on Coulomb's coefficient.
    stiffness : (n,)
        Factor on the elastic wrench.
    elastic : (n, 6) N, N m
        Wrench of the gel that is added to that of the base before the stiffness multiplies the sum.
    interface : (n, 6) N, N m
        Wrench between indenter and gel that is added after the stiffness.
    reading : (n, 6) N, N m, optional
        What the sensor reads, in the slots ``time`` and ``sensor``; ``None`` before them.
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

    @classmethod
    def start(cls, touch: Touch, base: BaseResponse) -> TouchState:
        """Return the touch as recorded, before any effect."""
        n = len(touch)
        # x + (-0.0) is x, for every x: a sum to which nothing was added changes no bit
        nothing = np.full((n, 6), -0.0)
        return cls(
            touch, base, felt=nothing, offset=np.zeros(n), shift=np.zeros((n, 2)), friction=np.ones(n),
            stiffness=np.ones(n), elastic=nothing, interface=nothing,
        )  # fmt: skip

    @cached_property
    def _answer(self) -> ContactResponse:
        """Answer of the simulation, kept: it is expensive, and depends on offset, shift and friction alone."""
        return self.base.respond(self.offset, self.shift, self.friction)

    def _as_asked(self, changed: TouchState) -> TouchState:
        """Return a state that asks the simulation for the same, with the answer where that is known already."""
        if "_answer" in self.__dict__:
            changed.__dict__["_answer"] = self._answer
        return changed

    @cached_property
    def contact(self) -> ContactResponse:
        """Contact that results from all that is asked so far."""
        plain = self._answer
        wrench = (plain.wrench + self.elastic) * self.stiffness[:, None] + self.interface
        return ContactResponse(wrench, plain.area, plain.centre, plain.depth, plain.sliding, plain.spring)

    @property
    def wrench(self) -> Array:
        """Wrench (n, 6), N and N m: the reading where there is one, else the answer of the gel."""
        return self.contact.wrench if self.reading is None else self.reading

    @property
    def moved_poses(self) -> Array:
        """gel_from_indenter (n, 4, 4), m, with the indenter where effects have moved it; a replay plays these poses."""
        poses = self.touch.poses.copy()
        poses[:, :2, 3] += self.shift
        poses[:, 2, 3] -= self.offset
        return poses

    def with_felt(self, felt: Array) -> TouchState:
        """Return the state in which a wrench (n, 6) bends arm and stem."""
        return self._changed(felt=felt)

    def _changed(self, **fields: Any) -> TouchState:
        """Return a state with other fields and nothing kept, as `dataclasses.replace` does; it reads no other field."""
        changed = object.__new__(TouchState)
        changed.__dict__.update(self.__dict__, **fields)
        for kept in ("_answer", "contact"):
            changed.__dict__.pop(kept, None)
        return changed

    def moved(self, deeper: Array | float = 0.0, along: Array | float = 0.0) -> TouchState:
        """Return the state with the indenter deeper by (n,) m, and further by (n, 2) m along x and y."""
        return self._changed(offset=self.offset + deeper, shift=self.shift + along)

    def rubbed(self, factor: Array) -> TouchState:
        """Return the state with the friction multiplied by factors (n,); a factor below 0 counts as 0."""
        return self._changed(friction=self.friction * np.maximum(factor, 0.0))

    def stiffened(self, factor: Array) -> TouchState:
        """Return the state with the elastic wrench multiplied by factors (n,)."""
        return self._as_asked(self._changed(stiffness=self.stiffness * factor))

    def with_elastic(self, wrench: Array) -> TouchState:
        """Return the state with a wrench (n, 6) of the gel added, which its stiffness multiplies."""
        return self._as_asked(self._changed(elastic=self.elastic + wrench))

    def with_interface(self, wrench: Array) -> TouchState:
        """Return the state with a wrench (n, 6) added that arises between indenter and gel."""
        return self._as_asked(self._changed(interface=self.interface + wrench))

    def with_reading(self, wrench: Array) -> TouchState:
        """Return the state in which the sensor reads this wrench (n, 6)."""
        return self._as_asked(self._changed(reading=wrench))

    def covariate(self, name: str, effect: str) -> Any:
        """Return a field of the touch on which an effect depends.

        Raises
        ------
        UsageError
            The touch does not state the field.
        """
        value = getattr(self.touch, name)
        if value is None:
            raise UsageError(
                f"effect {effect!r} depends on {name!r}, which this touch does not state",
                f"a touch with {name!r}",
                "Record it, or leave the effect out.",
                effect=effect,
                covariate=name,
            )
        return value


def torque_of(force: Array, at: Array) -> Array:
    """Torques (n, 3), N m, about the origin, of forces (n, 3), N, that act at points (n, 3), m."""
    (x, y, z), (fx, fy, fz) = at.T, force.T
    return np.stack([y * fz - z * fy, z * fx - x * fz, x * fy - y * fx], axis=1)


def wrench_at(force: Array, at: Array) -> Array:
    """Wrenches (n, 6) about the origin of the gel, of forces (n, 3), N, at points (n, 2), z = 0, or (n, 3), m."""
    points = at if at.shape[1] == 3 else np.column_stack([at, np.zeros(len(at))])
    return np.concatenate([force, torque_of(force, points)], axis=1)

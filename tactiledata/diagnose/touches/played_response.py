"""The gel's response to an indenter that is elsewhere, or slides otherwise, than recorded: interpolated plays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.touches.friction_history import Sliders, shear_change
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.played_columns import pressed, wrench_at_height
from tactiledata.effects.touch.response import BaseResponse, ContactResponse, GelVariant
from tactiledata.effects.touch.shear_stiffness import shear_stiffness
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial

SLIDES = 0.95
"""Share of the friction limit from which the whole contact counts as sliding."""


@dataclass(frozen=True)
class PlayedResponse:
    """`BaseResponse` of one touch from its plays, at one material.

    Between plays the wrench is interpolated. The offset of a frame acts as if the whole path had had it. Springs with
    sliders, fitted to this touch, tell what interpolation misses of the shear where friction is not that of a play, or
    differs from frame to frame (`ShearBetweenPlays`). The effect of a shift that differs from frame to frame is that of
    the same springs along the shifted path (`shear_change`).

    Parameters
    ----------
    touch : Touch
        Poses and geometry, n frames.
    plays : TouchPlays
        Plays of this touch.
    material : GelMaterial
        E in pascals, nu and mu.
    """

    touch: Touch
    plays: TouchPlays
    material: GelMaterial

    def respond(self, offset: Array, shift: Array, friction: Array) -> ContactResponse:
        """Return the contact with an indenter that is elsewhere, or slides otherwise, than recorded.

        Parameters
        ----------
        offset : (n,) m
            How much deeper than recorded.
        shift : (n, 2) m
            Along x and y of the gel frame.
        friction : (n,)
            Factor on the friction coefficient of the material at each frame.
        """
        # interpolated plays
        frictions = self.material.friction * friction
        differs = (frictions != frictions[:1]).any()
        ratio = self.material.poisson_ratio
        if differs:
            columns = self.plays.over_friction(ratio, offset, shift).at(frictions)
        else:
            columns = self.plays.at(ratio, frictions[0], offset, shift)
        tips = self.touch.tips
        depth = self.plays.height - tips[:, 2] + offset
        unit, centre, area, load = pressed(columns, depth, tips, shift)
        touching, limit = load > 0, frictions * load
        spring = shear_stiffness(area, ratio, self.touch.geometry.thickness)
        # shear that depends on friction and path before the frame
        between = self.plays.shear_between(tips[:, :2], self.touch.geometry.thickness)
        unit = unit + self._force_at(between.missed(frictions, columns[:, :2], load), centre)
        unit = unit + self._sheared(unit, shift, spring, limit, centre, between.sliders)
        sliding = touching & (np.hypot(unit[:, 0], unit[:, 1]) >= SLIDES * limit)
        modulus = self.material.youngs_modulus
        return ContactResponse(unit * modulus, area, centre, depth, sliding, spring * modulus)

    def _sheared(
        self, unit: Array, shift: Array, spring: Array, limit: Array, centre: Array, sliders: Sliders
    ) -> Array:
        """Return the change (n, 6) of the wrench over Young's modulus by a shift that differs from frame to frame.

        It is 0 where the shift is the same in all frames: the plays have that shift already. With the change, the shear
        exceeds neither the friction limit nor, where it was above that before, its earlier size.

        Parameters
        ----------
        unit : (n, 6)
            Wrench over Young's modulus, without that change.
        shift : (n, 2) m
            Along x and y of the gel frame.
        spring : (n,) m
            Tangential stiffness of the contact over Young's modulus.
        limit : (n,) m^2
            Friction limit over Young's modulus.
        centre : (n, 2) m
            Centre of pressure.
        sliders : Sliders
            Springs with sliders that pull as this touch does.
        """
        path = self.touch.tips[:, :2]
        if not (shift != shift[:1]).any():
            return np.zeros_like(unit)
        change = shear_change(path, shift, spring, limit, sliders)
        shear, before = unit[:, :2] + change, np.hypot(unit[:, 0], unit[:, 1])
        size = np.hypot(shear[:, 0], shear[:, 1])
        # a contact that slides already may exceed the limit a little, by the interpolation
        most = np.maximum(limit, before)
        shear *= np.divide(most, size, out=np.ones_like(size), where=size > most)[:, None]
        return self._force_at(shear - unit[:, :2], centre)

    def _force_at(self, shear: Array, centre: Array) -> Array:
        """Return wrenches (n, 6) of tangential forces (n, 2) at points (n, 2) in metres, at the height of the tip."""
        return wrench_at_height(shear, centre, self.touch.tips[:, 2])

    def difference(self, variant: GelVariant) -> Array:
        """Return the wrench (n, 6), in N and N m, with a variant of the gel, less that with the nominal gel.

        Raises
        ------
        UsageError
            The variant was not played.
        """
        if variant == GelVariant():
            return np.zeros((len(self.touch), 6))
        if variant not in self.plays.variants:
            raise UsageError(f"{variant} was not played", "a design point of an effect", "Play it first.")
        return self.plays.variants[variant] * self.material.youngs_modulus


@dataclass(frozen=True)
class PlayedFamily:
    """The base simulation at any material (`BaseFamily`), for touches that were played.

    Parameters
    ----------
    touches : sequence of Touch
        Touches that were played.
    plays : sequence of TouchPlays
        Their plays, in the same order.
    """

    touches: Sequence[Touch]
    plays: Sequence[TouchPlays]

    def __call__(self, material: GelMaterial) -> Callable[[Touch], BaseResponse]:
        """Return the function that simulates one of the touches at a material; touches are recognised by their poses.

        That function raises `UsageError` for a touch that was not played.
        """

        def answer(touch: Touch) -> BaseResponse:
            plays = self._by_pose.get(_key(touch))
            if plays is None:
                raise UsageError("a touch that was not played", "one of those played", "Play it first.")
            return PlayedResponse(touch, plays, material)

        return answer

    @cached_property
    def _by_pose(self) -> dict[tuple[str, bytes], TouchPlays]:
        """Plays by indenter and poses."""
        return {_key(touch): plays for touch, plays in zip(self.touches, self.plays, strict=True)}


def _key(touch: Touch) -> tuple[str, bytes]:
    """Return the indenter and poses of a touch, as a key of a dictionary."""
    return touch.indenter_name, np.ascontiguousarray(touch.poses).tobytes()

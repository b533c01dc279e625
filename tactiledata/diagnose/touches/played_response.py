"""The gel's response to an indenter that is elsewhere, or slides otherwise, than recorded: interpolated plays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
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

    Between plays the wrench is interpolated: normal force, torques and area of a frame are those of a path that had the
    frame's friction and offset throughout. Springs with sliders, fitted to this touch, tell what that misses of the
    shear, which depends on earlier frames (`ShearBetweenPlays`).

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
        # shear that depends on earlier frames, and what interpolation misses of it
        between = self.plays.shear_between(tips[:, :2], self.touch.geometry.thickness)
        missed = between.missed(frictions, offset, shift, columns[:, :2], load)
        unit = unit + wrench_at_height(missed, centre, tips[:, 2])
        sliding = touching & (np.hypot(unit[:, 0], unit[:, 1]) >= SLIDES * limit)
        modulus = self.material.youngs_modulus
        return ContactResponse(unit * modulus, area, centre, depth, sliding, spring * modulus)

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

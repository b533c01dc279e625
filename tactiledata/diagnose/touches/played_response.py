"""What the gel answers to an indenter that is elsewhere, or slides otherwise, than recorded: between its plays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.touches.friction_history import remembered_shear, shear_change
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.played_columns import pressed, wrench_at_height
from tactiledata.effects.touch.response import BaseResponse, ContactResponse, GelVariant
from tactiledata.effects.touch.shear_stiffness import shear_stiffness
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial

SLIDES = 0.95
"""Share of the sliding force from which the whole contact is taken to slide."""


@dataclass(frozen=True)
class PlayedResponse:
    """`BaseResponse` of a touch from its plays.

    Between plays the wrench is interpolated; the offset of a frame acts as if the whole path had had it. Where friction
    differs from frame to frame, a frame answers as if the whole path had had its own, but shear that sticks remembers
    the pull at which the contact slid last. A shift that differs from frame to frame lets springs and sliders that pull
    as this touch does slide further or less far.

    Parameters
    ----------
    touch : Touch
    plays : TouchPlays
    material : GelMaterial
    """

    touch: Touch
    plays: TouchPlays
    material: GelMaterial

    def respond(self, offset: Array, shift: Array, friction: Array) -> ContactResponse:
        """As `BaseResponse.respond`."""
        frictions = self.material.friction * friction
        differs = (frictions != frictions[:1]).any()
        ratio = self.material.poisson_ratio
        over = self.plays.over_friction(ratio, offset, shift) if differs else None
        columns = over.at(frictions) if over else self.plays.at(ratio, frictions[0], offset, shift)
        tips = self.touch.tips
        depth = self.plays.height - tips[:, 2] + offset
        unit, centre, area, load = pressed(columns, depth, tips, shift)
        touching, limit = load > 0, frictions * load
        spring = shear_stiffness(area, ratio, self.touch.geometry.thickness)
        if over:
            reach = spring * self.touch.lateral_steps
            unit = unit + self._force_at(remembered_shear(frictions, over, columns, touching, reach), centre)
        unit = unit + self._sheared(unit, shift, spring, limit, centre)
        sliding = touching & (np.hypot(unit[:, 0], unit[:, 1]) >= SLIDES * limit)
        modulus = self.material.youngs_modulus
        return ContactResponse(unit * modulus, area, centre, depth, sliding, spring * modulus)

    def _sheared(self, unit: Array, shift: Array, spring: Array, limit: Array, centre: Array) -> Array:
        """Change (n, 6) of the wrench by a shift that differs from frame to frame."""
        path = self.touch.tips[:, :2]
        if not (shift != shift[:1]).any():
            return np.zeros_like(unit)
        change = shear_change(path, shift, spring, limit, self.plays.sliders(path, self.touch.geometry.thickness))
        shear, before = unit[:, :2] + change, np.hypot(unit[:, 0], unit[:, 1])
        size = np.hypot(shear[:, 0], shear[:, 1])
        # what slides already may be a little over the limit, by the interpolation
        most = np.maximum(limit, before)
        shear *= np.divide(most, size, out=np.ones_like(size), where=size > most)[:, None]
        return self._force_at(shear - unit[:, :2], centre)

    def _force_at(self, shear: Array, centre: Array) -> Array:
        """Wrenches (n, 6) of forces (n, 2) along the gel, at the height of the tip."""
        return wrench_at_height(shear, centre, self.touch.tips[:, 2])

    def difference(self, variant: GelVariant) -> Array:
        """As `BaseResponse.difference`.

        Raises
        ------
        UsageError
            A variant that was not played.
        """
        if variant == GelVariant():
            return np.zeros((len(self.touch), 6))
        if variant not in self.plays.variants:
            raise UsageError(f"{variant} was not played", "a design point of an effect", "Play it first.")
        return self.plays.variants[variant] * self.material.youngs_modulus


@dataclass(frozen=True)
class PlayedFamily:
    """The gel at any material, for touches that were played.

    Parameters
    ----------
    touches : sequence of Touch
    plays : sequence of TouchPlays
        In the same order.
    """

    touches: Sequence[Touch]
    plays: Sequence[TouchPlays]

    def __call__(self, material: GelMaterial) -> Callable[[Touch], BaseResponse]:
        """What answers for the touches, told apart by their poses."""

        def answer(touch: Touch) -> BaseResponse:
            plays = self._by_pose.get(_key(touch))
            if plays is None:
                raise UsageError("a touch that was not played", "one of those played", "Play it first.")
            return PlayedResponse(touch, plays, material)

        return answer

    @cached_property
    def _by_pose(self) -> dict[tuple[str, bytes], TouchPlays]:
        return {_key(touch): plays for touch, plays in zip(self.touches, self.plays, strict=True)}


def _key(touch: Touch) -> tuple[str, bytes]:
    return touch.indenter_name, np.ascontiguousarray(touch.poses).tobytes()

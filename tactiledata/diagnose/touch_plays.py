"""A touch as the gel answered it on a grid of plays, and the response to anything in between."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.response import polynomial_weights
from tactiledata.diagnose.friction_memory import CubicsOverFriction, remembered_shear
from tactiledata.diagnose.shear_memory import shear_change
from tactiledata.diagnose.sliders import Sliders, own_sliders
from tactiledata.effects.response import BaseResponse, ContactResponse, GelVariant
from tactiledata.effects.shear_stiffness import shear_stiffness
from tactiledata.effects.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.material import GelMaterial

Array = NDArray[np.float64]
Bend = tuple[Array, Array, Array]
"""What depends on the offset z as a parabola: level, slope and curvature."""

AREA = 6
"""Column of the contact's area; the wrench stands before it."""
RECENT = 16
"""Answers that are kept."""
SLIDES = 0.95
"""Share of the sliding force from which the whole contact is taken to slide."""
LEAST_FORCE = 1e-9
"""m^2, over Young's modulus: less is no contact."""


@dataclass(frozen=True)
class TouchPlays:
    """Plays of one touch of n frames: columns are the wrench over Young's modulus (6) and the contact's area, m^2.

    Parameters
    ----------
    plan : ResponsePlan
        Which pairs of nu and mu, and by how much deeper and less deep.
    level : (n_nu, n_mu, n, 7)
        Without offset.
    by_ratio : (n_nu, 2, n, 7)
        Slope and curvature over the offset, at the middle mu.
    by_friction : (n_mu, 2, n, 7)
        The same at the middle nu.
    by_shift : (2, n, 7) 1/m
        Slopes over the whole path's shift along x and y, at the middle pair.
    height : (n,) m
        Of the undeformed surface below the tip.
    variants : GelVariant -> (n, 6)
        Difference of the wrench over Young's modulus at the middle pair.
    """

    plan: ResponsePlan
    level: Array
    by_ratio: Array
    by_friction: Array
    by_shift: Array
    height: Array
    variants: Mapping[GelVariant, Array] = field(default_factory=dict)

    @property
    def known(self) -> NDArray[np.bool_]:
        """Frames (n,) that every play has solved, or found nothing that touches."""
        return np.asarray(np.isfinite(self.level).all(axis=(0, 1, 3)))

    def part(self, rows: NDArray[np.bool_]) -> TouchPlays:
        """Those of some of the frames (n,)."""
        return TouchPlays(
            self.plan,
            self.level[:, :, rows],
            self.by_ratio[:, :, rows],
            self.by_friction[:, :, rows],
            self.by_shift[:, rows],
            self.height[rows],
            {variant: difference[rows] for variant, difference in self.variants.items()},
        )

    def at(self, ratio: float, frictions: Array, offset: Array, shift: Array) -> Array:
        """Columns (n, 7) at one nu, and at a mu, an offset and a shift of each frame; not to be written to."""
        key = b"".join(np.ascontiguousarray(one).tobytes() for one in (float(ratio), frictions, offset, shift))
        if key not in self._recent:
            if len(self._recent) >= RECENT:
                del self._recent[next(iter(self._recent))]
            self._recent[key] = self._between(ratio, frictions, offset, shift)
        return self._recent[key]

    def _between(self, ratio: float, frictions: Array, offset: Array, shift: Array) -> Array:
        if np.ptp(frictions):
            return self.over_friction(ratio, offset, shift).at(frictions)
        return _bent(self._of_pair(float(ratio), float(frictions[0])), offset[:, None]) + self._shifted(shift)

    def over_friction(self, ratio: float, offset: Array, shift: Array) -> CubicsOverFriction:
        """Columns (n, 7) as functions of the friction, at one nu, and at an offset and a shift of each frame."""
        over = _bent(self._of_ratio(float(ratio)), offset[:, None])
        over[3] += self._shifted(shift)
        return CubicsOverFriction(np.asarray(self.plan.frictions), over)

    def _shifted(self, shift: Array) -> Array:
        """What a shift (n, 2) changes of the columns (n, 7)."""
        return shift[:, :1] * self.by_shift[0] + shift[:, 1:] * self.by_shift[1]

    def _of_one_ratio(self, ratio: float) -> Bend:
        """Cubics over the friction at one nu: coefficients (4, n_mu - 1, n, 7) of the level and of its two bends."""
        weights = polynomial_weights(np.asarray(self.plan.ratios), ratio)
        level = np.tensordot(self._cubics[..., :-2, :], weights, axes=([3], [0]))
        bends = [self._cubics[..., place, :].copy() for place in (-2, -1)]
        more = np.tensordot(weights, self.by_ratio, axes=1) - self.by_friction[self.plan.middle[1]]
        for bend, at_ratio in zip(bends, more, strict=True):
            bend[3] += at_ratio
        return level, bends[0], bends[1]

    def _of_one_pair(self, ratio: float, friction: float) -> Bend:
        """Level and its two bends (n, 7) at one nu and mu."""
        nodes, frictions = np.asarray(self.plan.frictions), np.full(len(self.height), friction)
        level, slope, curvature = (CubicsOverFriction(nodes, one).at(frictions) for one in self._of_ratio(ratio))
        return level, slope, curvature

    def sliders(self, path: Array, thickness: float) -> Sliders:
        """What pulls along a path (n, 2), m, as the gel does at the middle pair; found once."""
        if not self._sliders:
            ratio, friction = self.plan.ratios[self.plan.middle[0]], self.plan.frictions[self.plan.middle[1]]
            columns = self.level[self.plan.middle]
            touching = columns[:, 2] > LEAST_FORCE
            area, load = (np.where(touching, np.maximum(columns[:, place], 0.0), 0.0) for place in (AREA, 2))
            pull = np.where(touching[:, None], -columns[:, :2], 0.0)
            spring = shear_stiffness(area, ratio, thickness)
            self._sliders.append(own_sliders(path, pull, spring, friction * load))
        return self._sliders[0]

    @cached_property
    def _sliders(self) -> list[Sliders]:
        return []

    @cached_property
    def _recent(self) -> dict[bytes, Array]:
        """Answers already given: effects of the sensor ask for the same one again and again."""
        return {}

    @cached_property
    def _of_ratio(self) -> Callable[[float], Bend]:
        return lru_cache(RECENT)(self._of_one_ratio)

    @cached_property
    def _of_pair(self) -> Callable[[float, float], Bend]:
        return lru_cache(RECENT)(self._of_one_pair)

    @cached_property
    def _cubics(self) -> Array:
        """Coefficients (4, n_mu - 1, n, n_nu + 2, 7) over the friction: of the level at each nu, of the two bends."""
        values = np.concatenate([self.level.transpose(1, 2, 0, 3), self.by_friction.transpose(0, 2, 1, 3)], axis=2)
        coefficients: Array = PchipInterpolator(self.plan.frictions, values).c
        return coefficients


def _bent(bend: Bend, z: Array) -> Array:
    """Of a level and its slope and curvature over z."""
    level, slope, curvature = bend
    bent: Array = level + z * (slope + z * curvature)
    return bent


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
        over = self.plays.over_friction(self.material.poisson_ratio, offset, shift) if differs else None
        columns = over.at(frictions) if over else self.plays.at(self.material.poisson_ratio, frictions, offset, shift)
        tips = self.touch.tips
        depth = self.plays.height - tips[:, 2] + offset
        touching = (columns[:, 2] > LEAST_FORCE) & (depth > 0)
        unit = np.where(touching[:, None], columns[:, :6], 0.0)
        normal = np.where(touching, columns[:, 2], 1.0)
        # of the pressure on the surface: M = r x F with r at the height of the tip
        centre = np.column_stack(
            [(tips[:, 2] * unit[:, 0] - unit[:, 4]) / normal, (unit[:, 3] + tips[:, 2] * unit[:, 1]) / normal]
        )
        centre = np.where(touching[:, None], centre, tips[:, :2] + shift)
        area = np.where(touching, np.maximum(columns[:, AREA], 0.0), 0.0)
        load = np.where(touching, normal, 0.0)
        limit = frictions * load
        spring = shear_stiffness(area, self.material.poisson_ratio, self.touch.geometry.thickness)
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
        if not np.ptp(shift, axis=0).any():
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
        (fx, fy), (x, y), z = shear.T, centre.T, self.touch.tips[:, 2]
        wrench = np.stack([fx, fy, np.zeros(len(shear)), -z * fy, z * fx, x * fy - y * fx], axis=1)
        return np.where(np.isnan(wrench), 0.0, wrench)

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

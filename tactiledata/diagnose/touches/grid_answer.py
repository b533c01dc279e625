"""A touch as the gel answered it on a grid of plays, and what it answers in between."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from tactiledata.arrays import Array
from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.response import polynomial_weights
from tactiledata.diagnose.touches.friction_history import CubicsOverFriction, Sliders, own_sliders
from tactiledata.diagnose.touches.played_columns import AREA, LEAST_FORCE
from tactiledata.effects.touch.response import GelVariant
from tactiledata.effects.touch.shear_stiffness import shear_stiffness

Bend = tuple[Array, Array, Array]
"""What depends on the offset z as a parabola: level, slope and curvature."""

RECENT = 16
"""Answers that are kept."""


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

    def at(self, ratio: float, friction: float, offset: Array, shift: Array) -> Array:
        """Columns (n, 7) at one nu and mu, and at an offset and a shift of each frame; not to be written to."""
        pair = float(ratio), float(friction)
        key = pair, *(np.ascontiguousarray(one).tobytes() for one in (offset, shift))
        if key not in self._recent:
            if len(self._recent) >= RECENT:
                del self._recent[next(iter(self._recent))]
            self._recent[key] = _bent(self._of_pair(*pair), offset[:, None]) + self._shifted(shift)
        return self._recent[key]

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
    def _recent(self) -> dict[tuple[object, ...], Array]:
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

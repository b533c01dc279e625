"""Interpolation of the gel's response to one touch between the plays of a grid over nu, mu, offset and shift."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from tactiledata.arrays import Array
from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.response import polynomial_weights
from tactiledata.diagnose.touches.between_plays import (
    CubicsOverFriction,
    Parabola,
    PressedContact,
    ShearBetweenPlays,
)
from tactiledata.diagnose.touches.played_columns import AREA, NORMAL
from tactiledata.effects.touch.response import GelVariant

RECENT = 16
"""Largest number of interpolated results that a cache keeps."""


@dataclass(frozen=True)
class TouchPlays:
    """Plays of one touch of n frames at the nodes of a plan.

    The 7 columns of a play are the wrench (6) over Young's modulus, in m^2 and m^3, and the area of the contact in m^2.

    Parameters
    ----------
    plan : ResponsePlan
        Nodes of nu and mu, and the offset that was played to either side.
    level : (n_nu, n_mu, n, 7)
        Columns at every pair of nu and mu, without offset.
    by_ratio : (n_nu, 2, n, 7)
        Slope (per m) and curvature (per m^2) over the offset at each nu and the middle mu.
    by_friction : (n_mu, 2, n, 7)
        Slope and curvature over the offset at the middle nu and each mu.
    by_shift : (2, n, 7)
        Slopes (per m) over a shift of the whole path along x and along y, at the middle pair.
    height : (n,) m
        Height of the tip at which the lowest point of the indenter meets the undeformed surface.
    variants : dict, GelVariant -> (n, 6)
        Change of the wrench over Young's modulus by each variant, at the middle pair.
    estimated : (n,) bool, optional
        Frames that some play has not solved, and that were interpolated there; none where ``None``.
    by_estimate : frozenset of GelVariant
        Variants whose change is estimated for most touches, not played at the fidelity that was asked for.
    """

    plan: ResponsePlan
    level: Array
    by_ratio: Array
    by_friction: Array
    by_shift: Array
    height: Array
    variants: Mapping[GelVariant, Array] = field(default_factory=dict)
    estimated: NDArray[np.bool_] | None = None
    by_estimate: frozenset[GelVariant] = frozenset()

    def __getstate__(self) -> dict[str, object]:
        """Return the fields: caches are not sent to other processes."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    @property
    def known(self) -> NDArray[np.bool_]:
        """Whether every play has solved a frame (n,), or found no contact in it."""
        return np.asarray(np.isfinite(self.level).all(axis=(0, 1, 3)))

    def part(self, rows: NDArray[np.bool_]) -> TouchPlays:
        """Return the plays of the chosen frames (n,)."""
        return replace(
            self,
            level=self.level[:, :, rows],
            by_ratio=self.by_ratio[:, :, rows],
            by_friction=self.by_friction[:, :, rows],
            by_shift=self.by_shift[:, rows],
            height=self.height[rows],
            variants={variant: difference[rows] for variant, difference in self.variants.items()},
            estimated=None if self.estimated is None else self.estimated[rows],
        )

    def at(self, ratio: float, friction: float, offset: Array, shift: Array) -> Array:
        """Return columns (n, 7) at one nu and mu, and at an offset and a shift of each frame; they must not be changed.

        Parameters
        ----------
        ratio : float
            Poisson's ratio nu.
        friction : float
            Friction coefficient mu.
        offset : (n,) m
            How much deeper than recorded.
        shift : (n, 2) m
            Along x and y of the gel frame.
        """
        pair = float(ratio), float(friction)
        key = pair, *(np.ascontiguousarray(moved).tobytes() for moved in (offset, shift))
        if key not in self._recent:
            if len(self._recent) >= RECENT:
                del self._recent[next(iter(self._recent))]
            self._recent[key] = self._of_pair(*pair).at(offset[:, None]) + self._shifted(shift)
        return self._recent[key]

    def over_friction(self, ratio: float, offset: Array, shift: Array) -> CubicsOverFriction:
        """Return columns (n, 7) as functions of the friction coefficient.

        Parameters
        ----------
        ratio : float
            Poisson's ratio nu.
        offset : (n,) m
            How much deeper than recorded.
        shift : (n, 2) m
            Along x and y of the gel frame.
        """
        over = self._of_ratio(float(ratio)).at(offset[:, None])
        over[3] += self._shifted(shift)
        return CubicsOverFriction(np.asarray(self.plan.frictions), over)

    def _shifted(self, shift: Array) -> Array:
        """Return the change (n, 7) of the columns by a shift (n, 2) in metres."""
        return shift[:, :1] * self.by_shift[0] + shift[:, 1:] * self.by_shift[1]

    def _of_one_ratio(self, ratio: float) -> Parabola:
        """Return coefficients (4, n_mu - 1, n, 7) of cubics over friction at one nu."""
        weights = polynomial_weights(np.asarray(self.plan.ratios), ratio)
        level = np.tensordot(self._cubics[..., :-2, :], weights, axes=([3], [0]))
        bends = [self._cubics[..., place, :].copy() for place in (-2, -1)]
        # slope and curvature are taken as a sum of a part of nu and a part of mu
        more = np.tensordot(weights, self.by_ratio, axes=1) - self.by_friction[self.plan.middle[1]]
        for bend, at_ratio in zip(bends, more, strict=True):
            bend[3] += at_ratio
        return Parabola(level, bends[0], bends[1])

    def _of_one_pair(self, ratio: float, friction: float) -> Parabola:
        """Return the columns (n, 7) at one nu and mu."""
        nodes, frictions = np.asarray(self.plan.frictions), np.full(len(self.height), friction)
        over = self._of_ratio(ratio)
        parts = (over.level, over.slope, over.curvature)
        return Parabola(*(CubicsOverFriction(nodes, part).at(frictions) for part in parts))

    def shear_between(self, path: Array, thickness: float) -> ShearBetweenPlays:
        """Return what tells shear between plays, from those at the middle nu; cached.

        Parameters
        ----------
        path : (n, 2) m
            Recorded path of the tip along the gel.
        thickness : float
            Thickness of the gel in metres.
        """
        if not self._between:
            nu_middle, mu_middle = self.plan.middle
            middle = self.level[nu_middle, mu_middle]
            three = np.stack([middle, *self.by_friction[mu_middle]])
            load, area = (Parabola(*np.ascontiguousarray(three[..., place])) for place in (NORMAL, AREA))
            contact = PressedContact(load, area, self.plan.ratios[nu_middle], thickness)
            nodes, shear = np.asarray(self.plan.frictions), self.level[nu_middle, :, :, :2]
            self._between.append(ShearBetweenPlays.of(nodes, self.plan.offset, path, contact, shear))
        return self._between[0]

    @cached_property
    def _between(self) -> list[ShearBetweenPlays]:
        """Cache of `shear_between`: empty, or the one result."""
        return []

    @cached_property
    def _recent(self) -> dict[tuple[object, ...], Array]:
        """Cache of `at`: effects of the sensor ask for the same columns again and again."""
        return {}

    @cached_property
    def _of_ratio(self) -> Callable[[float], Parabola]:
        """`_of_one_ratio` with a cache."""
        return lru_cache(RECENT)(self._of_one_ratio)

    @cached_property
    def _of_pair(self) -> Callable[[float, float], Parabola]:
        """`_of_one_pair` with a cache."""
        return lru_cache(RECENT)(self._of_one_pair)

    @cached_property
    def _cubics(self) -> Array:
        """Coefficients (4, n_mu - 1, n, n_nu + 2, 7) of cubics over mu: level at each nu, then slope and curvature."""
        values = np.concatenate([self.level.transpose(1, 2, 0, 3), self.by_friction.transpose(0, 2, 1, 3)], axis=2)
        coefficients: Array = PchipInterpolator(self.plan.frictions, values).c
        return coefficients

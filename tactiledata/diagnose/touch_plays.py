"""A touch as the gel answered it on a grid of plays, and the response to anything in between."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.response import polynomial_weights
from tactiledata.diagnose.shear_memory import friction_change, shear_change, shear_stiffness
from tactiledata.effects.response import BaseResponse, ContactResponse, GelVariant
from tactiledata.effects.touch import Touch
from tactiledata.errors import UsageError
from tactiledata.gel.material import GelMaterial

Array = NDArray[np.float64]

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

    @cached_property
    def _recent(self) -> dict[bytes, Array]:
        """Answers already given: effects of the sensor ask for the same one again and again."""
        return {}

    def _between(self, ratio: float, frictions: Array, offset: Array, shift: Array) -> Array:
        weights = polynomial_weights(np.asarray(self.plan.ratios), ratio)
        by_node, bends = self._at_frictions(frictions)
        level = np.tensordot(weights, by_node, axes=([0], [1]))
        slope, curvature = (
            np.tensordot(weights, self.by_ratio, axes=1)
            + bends.transpose(1, 0, 2)
            - self.by_friction[self.plan.middle[1]]
        )
        z = offset[:, None]
        columns: Array = level + z * (slope + z * curvature) + np.einsum("na,ank->nk", shift, self.by_shift)
        return columns

    @cached_property
    def _cubics(self) -> Array:
        """Coefficients (4, n_mu - 1, n, n_nu + 2, 7) over the friction: of the level at each nu, of the two bends."""
        values = np.concatenate([self.level.transpose(1, 2, 0, 3), self.by_friction.transpose(0, 2, 1, 3)], axis=2)
        coefficients: Array = PchipInterpolator(self.plan.frictions, values).c
        return coefficients

    def _at_frictions(self, frictions: Array) -> tuple[Array, Array]:
        """Level (n, n_nu, 7) and bends (n, 2, 7), each row at its own friction (n,)."""
        nodes = np.asarray(self.plan.frictions)
        wanted = np.clip(frictions, nodes[0], nodes[-1])
        place = np.clip(np.searchsorted(nodes, wanted, side="right") - 1, 0, len(nodes) - 2)
        third, second, first, none = self._cubics[:, place, np.arange(len(wanted))]
        x = (wanted - nodes[place])[:, None, None]
        values = ((third * x + second) * x + first) * x + none
        return values[:, :-2], values[:, -2:]


@dataclass(frozen=True)
class PlayedResponse:
    """`BaseResponse` of a touch from its plays.

    Between plays the wrench is interpolated; the offset of a frame acts as if the whole path had had it, and so does
    the median of its friction. Friction that is another at a frame, or a shift that differs from frame to frame, lets a
    spring of the contact's size slide further or less far, and shear that sticks afterwards remembers it.

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
        usual = np.full(len(frictions), self._usual(frictions))
        columns = self.plays.at(self.material.poisson_ratio, usual, offset, shift)
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
        unit = unit + self._sheared(unit, shift, area, (usual * load, limit), centre)
        sliding = touching & (np.hypot(unit[:, 0], unit[:, 1]) >= SLIDES * limit)
        return ContactResponse(unit * self.material.youngs_modulus, area, centre, depth, sliding)

    def _usual(self, frictions: Array) -> float:
        """The friction that stands for the path: the median over frames that touch."""
        deep = np.isfinite(frictions) & (self.plays.height > self.touch.tips[:, 2])
        return float(np.median(frictions[deep])) if deep.any() else self.material.friction

    def _sheared(self, unit: Array, shift: Array, area: Array, limits: tuple[Array, Array], centre: Array) -> Array:
        """Change (n, 6) of the wrench by a shift, and by a limit of friction, that differ from frame to frame.

        ``limits``: with the path's usual friction, and with that of each frame.
        """
        path, (before, limit) = self.touch.tips[:, :2], limits
        stiffness = shear_stiffness(area, self.material.poisson_ratio, self.touch.geometry.thickness)
        change = shear_change(path, shift, stiffness, limit) + friction_change(path, stiffness, before, limit)
        if not change.any():
            return np.zeros_like(unit)
        shear = unit[:, :2] + change
        size = np.hypot(shear[:, 0], shear[:, 1])
        # what slides already may be a little over the limit, by the interpolation
        over = np.divide(np.hypot(unit[:, 0], unit[:, 1]), before, out=np.ones_like(limit), where=before > 0)
        most = limit * np.maximum(over, 1.0)
        shear *= np.divide(most, size, out=np.ones_like(size), where=size > most)[:, None]
        force = np.column_stack([shear - unit[:, :2], np.zeros(len(unit))])
        at = np.column_stack([centre, self.touch.tips[:, 2]])
        return np.nan_to_num(np.concatenate([force, np.cross(at, force)], axis=1))

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
        by_pose = {_key(touch): plays for touch, plays in zip(self.touches, self.plays, strict=True)}

        def answer(touch: Touch) -> BaseResponse:
            if _key(touch) not in by_pose:
                raise UsageError("a touch that was not played", "one of those played", "Play it first.")
            return PlayedResponse(touch, by_pose[_key(touch)], material)

        return answer


def _key(touch: Touch) -> tuple[str, bytes]:
    return touch.indenter_name, np.ascontiguousarray(touch.poses).tobytes()

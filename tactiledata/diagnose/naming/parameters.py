"""A material with effects as a vector of numbers, and back."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import BOUNDS, Bounds
from tactiledata.diagnose.naming.signatures import deviation_of
from tactiledata.diagnose.naming.strength import Strength, strength_of
from tactiledata.effects.parameter import Parameter
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.gel.elasticity.material import GelMaterial


@dataclass(frozen=True)
class Coordinate:
    """A number of an effect that is fitted.

    Parameters
    ----------
    place : int
        Of its effect among the settings.
    parameter : Parameter
    """

    place: int
    parameter: Parameter

    @property
    def is_strength(self) -> bool:
        """Whether it has a null, and with it a prior."""
        return self.parameter.null is not None

    @property
    def is_logarithmic(self) -> bool:
        """Whether it is fitted by its logarithm, as times and lengths are."""
        return not self.is_strength and self.parameter.bounds[0] > 0.0

    @property
    def scale(self) -> float:
        """Of a step that means something: the prior's deviation, a factor e, or a tenth of the bounds."""
        if self.is_strength:
            return deviation_of(self.parameter)
        return 1.0 if self.is_logarithmic else (self.parameter.bounds[1] - self.parameter.bounds[0]) / 10.0

    @property
    def bounds(self) -> tuple[float, float]:
        """In which it moves, in units of its scale."""
        low, high = (self.to_unit(end) for end in self.parameter.bounds)
        return low, high

    def to_unit(self, value: float) -> float:
        """The value as it is fitted."""
        return (float(np.log(value)) if self.is_logarithmic else value) / self.scale

    def to_value(self, unit: float) -> float:
        """The other way, inside the bounds."""
        value = float(np.exp(unit * self.scale)) if self.is_logarithmic else float(unit * self.scale)
        return float(np.clip(value, *self.parameter.bounds))


@dataclass(frozen=True)
class JointModel:
    """E, nu and mu, effects, and what is off without being physics.

    Parameters
    ----------
    material : GelMaterial
    settings : tuple of EffectSetting
    coordinates : tuple of Coordinate
        Numbers of the settings that are free.
    offsets : (t,) m
    errors : (e,)
        Numerical errors, in their standard deviations.
    box : Bounds
        In which E, nu and mu stay.
    """

    material: GelMaterial
    settings: tuple[EffectSetting, ...]
    coordinates: tuple[Coordinate, ...]
    offsets: Array
    errors: Array
    box: Bounds = BOUNDS["wide"]

    @property
    def strengths(self) -> frozenset[Strength]:
        """Those that are free."""
        return frozenset(
            strength_of(self.settings[one.place], one.parameter) for one in self.coordinates if one.is_strength
        )

    def name_of(self, coordinate: Coordinate) -> str:
        """Of one of the numbers, for tables: ``"mount_offset x of ball3"``."""
        setting = self.settings[coordinate.place]
        return f"{setting.effect} {strength_of(setting, coordinate.parameter).label}"

    @property
    def vector(self) -> Array:
        """Logarithm of E, nu, mu, the coordinates in their units, and the errors."""
        of_effects = [one.to_unit(self.settings[one.place].values[one.parameter.name]) for one in self.coordinates]
        gel = [np.log(self.material.youngs_modulus), self.material.poisson_ratio, self.material.friction]
        return np.array([*gel, *of_effects, *self.errors])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Least and largest value of each entry of the vector."""
        ends = [one.bounds for one in self.coordinates]
        free = np.full(len(self.errors), np.inf)
        low = [np.log(self.box.low[0]), *self.box.low[1:], *(low for low, _ in ends), *-free]
        high = [np.log(self.box.high[0]), *self.box.high[1:], *(high for _, high in ends), *free]
        return np.array(low), np.array(high)

    def at(self, vector: Array, offsets: Array) -> JointModel:
        """The model with other numbers."""
        settings = list(self.settings)
        for value, one in zip(vector[3:], self.coordinates, strict=False):
            old = settings[one.place]
            values = {**old.values, one.parameter.name: one.to_value(float(value))}
            settings[one.place] = EffectSetting(old.effect, values, old.where)
        gel = GelMaterial(float(np.exp(vector[0])), float(vector[1]), float(vector[2]))
        errors = vector[3 + len(self.coordinates) :]
        return replace(self, material=gel, settings=tuple(settings), offsets=offsets, errors=errors)


def joint_model(
    material: GelMaterial,
    settings: Sequence[EffectSetting],
    trajectories: int,
    errors: int,
    kept: Collection[Strength] | None = None,
    box: Bounds = BOUNDS["wide"],
) -> JointModel:
    """A model of effects at their nulls or elsewhere.

    Parameters
    ----------
    settings : of each effect, one for each place where it has strengths of its own
    kept : strengths that leave anything; all of them where ``None``
    """
    coordinates = []
    for place, setting in enumerate(settings):
        for parameter in setting.member.parameters:
            if parameter.null is None:
                is_free = len(parameter.grid) > 1
            else:
                is_free = kept is None or strength_of(setting, parameter) in kept
            if is_free:
                coordinates.append(Coordinate(place, parameter))
    return JointModel(material, tuple(settings), tuple(coordinates), np.zeros(trajectories), np.zeros(errors), box)

"""Everything that one fit determines, as a vector: material, effects and the simulation's own errors."""

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
    """One number of an effect that is fitted, and the unit in which it is fitted.

    Parameters
    ----------
    setting_index : int
        Index of its effect among the settings of the model.
    parameter : Parameter
        A strength, or a shape parameter with several grid values.
    """

    setting_index: int
    parameter: Parameter

    @property
    def is_strength(self) -> bool:
        """Whether the parameter has a null value, at which the effect is absent, and a normal prior about it."""
        return self.parameter.null is not None

    @property
    def is_logarithmic(self) -> bool:
        """Whether the logarithm is fitted: of shape parameters that are positive, as times and lengths."""
        return not self.is_strength and self.parameter.bounds[0] > 0.0

    @property
    def scale(self) -> float:
        """Unit in which the fit counts the parameter.

        It is the standard deviation of the prior of a strength, a factor e of a logarithmic parameter, and a tenth of
        the width of the bounds of any other.
        """
        if self.is_strength:
            return deviation_of(self.parameter)
        return 1.0 if self.is_logarithmic else (self.parameter.bounds[1] - self.parameter.bounds[0]) / 10.0

    @property
    def bounds(self) -> tuple[float, float]:
        """Smallest and largest value that a fit may try, in units of the fit."""
        low, high = (self.to_unit(end) for end in self.parameter.bounds)
        return low, high

    def to_unit(self, value: float) -> float:
        """Return a value of the parameter in units of the fit."""
        return (float(np.log(value)) if self.is_logarithmic else value) / self.scale

    def to_value(self, unit: float) -> float:
        """Return the parameter's value for a number in units of the fit, clipped to the parameter's bounds."""
        value = float(np.exp(unit * self.scale)) if self.is_logarithmic else float(unit * self.scale)
        return float(np.clip(value, *self.parameter.bounds))


@dataclass(frozen=True)
class JointModel:
    """Fit parameters: material (E, nu, mu), effects, contact offset of each trajectory, and the simulator's own errors.

    Parameters
    ----------
    material : GelMaterial
        Young's modulus E in pascals, Poisson's ratio nu and friction coefficient mu.
    settings : tuple of EffectSetting
        Effects with their values, one setting for each place where an effect has strengths of its own.
    coordinates : tuple of Coordinate
        Numbers of the settings that are free.
    offsets : (t,) m
        By how much each trajectory is deeper than recorded.
    errors : (e,)
        Errors of the simulation, in their standard deviations.
    box : Bounds
        Bounds of E, nu and mu.
    """

    material: GelMaterial
    settings: tuple[EffectSetting, ...]
    coordinates: tuple[Coordinate, ...]
    offsets: Array
    errors: Array
    box: Bounds = BOUNDS["wide"]

    @property
    def strengths(self) -> frozenset[Strength]:
        """Strengths that are free."""
        return frozenset(
            strength_of(self.settings[coordinate.setting_index], coordinate.parameter)
            for coordinate in self.coordinates
            if coordinate.is_strength
        )

    def name_of(self, coordinate: Coordinate) -> str:
        """Return effect, parameter and place of a number, for tables: ``"mount_offset x of ball3"``."""
        setting = self.settings[coordinate.setting_index]
        return f"{setting.effect} {strength_of(setting, coordinate.parameter).label}"

    @property
    def vector(self) -> Array:
        """Fitted numbers (q,) that all trajectories share: ln E, nu, mu, the coordinates in their units, the errors."""
        of_effects = [
            coordinate.to_unit(self.settings[coordinate.setting_index].values[coordinate.parameter.name])
            for coordinate in self.coordinates
        ]
        gel = [np.log(self.material.youngs_modulus), self.material.poisson_ratio, self.material.friction]
        return np.array([*gel, *of_effects, *self.errors])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Smallest and largest value (q,) of each entry of the vector; the errors are unbounded."""
        ends = [coordinate.bounds for coordinate in self.coordinates]
        free = np.full(len(self.errors), np.inf)
        low = [np.log(self.box.low[0]), *self.box.low[1:], *(low for low, _ in ends), *-free]
        high = [np.log(self.box.high[0]), *self.box.high[1:], *(high for _, high in ends), *free]
        return np.array(low), np.array(high)

    def at(self, vector: Array, offsets: Array) -> JointModel:
        """Return the same model with other numbers: a vector (q,) as of `vector`, and offsets (t,) in metres."""
        settings = list(self.settings)
        for value, coordinate in zip(vector[3:], self.coordinates, strict=False):
            old = settings[coordinate.setting_index]
            values = {**old.values, coordinate.parameter.name: coordinate.to_value(float(value))}
            settings[coordinate.setting_index] = EffectSetting(old.effect, values, old.where)
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
    """Return the model from which a fit starts, its offsets and errors at 0.

    Free are the strengths in ``kept`` and the shape parameters that have several grid values.

    Parameters
    ----------
    material : GelMaterial
        Start of E, nu and mu.
    settings : sequence of EffectSetting
        Effects with their start values, one setting for each place where an effect has strengths of its own.
    trajectories : int
        Number t of contact offsets.
    errors : int
        Number e of the simulation's own errors.
    kept : collection of Strength, optional
        Strengths that change anything in these touches; all of them where ``None``.
    box : Bounds
        Bounds of E, nu and mu.
    """
    coordinates = []
    for setting_index, setting in enumerate(settings):
        for parameter in setting.member.parameters:
            if parameter.null is None:
                is_free = len(parameter.grid) > 1
            else:
                is_free = kept is None or strength_of(setting, parameter) in kept
            if is_free:
                coordinates.append(Coordinate(setting_index, parameter))
    return JointModel(material, tuple(settings), tuple(coordinates), np.zeros(trajectories), np.zeros(errors), box)

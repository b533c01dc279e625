"""One fitted strength of an effect, at one place where the effect has numbers of its own for each place."""

from __future__ import annotations

from typing import NamedTuple

from tactiledata.effects import EFFECTS
from tactiledata.effects.parameter import Parameter
from tactiledata.effects.simulate.setting import EffectSetting


class Strength(NamedTuple):
    """One strength of an effect: a parameter with a null value, at which the effect is absent.

    Parameters
    ----------
    effect : str
        Name of the effect in the catalogue.
    name : str
        Name of the parameter.
    place : str
        Sensor, indenter or mount whose touches it acts on; empty where it acts on all.
    """

    effect: str
    name: str
    place: str = ""

    @property
    def label(self) -> str:
        """The strength in words for tables: ``"x of ball3"``."""
        return f"{self.name} of {self.place}" if self.place else self.name

    @property
    def parameter(self) -> Parameter:
        """The parameter as the effect declares it."""
        return next(parameter for parameter in EFFECTS[self.effect]().parameters if parameter.name == self.name)

    @property
    def end(self) -> float:
        """End of the plausible range that is farther from 0, in the parameter's unit."""
        return max(self.parameter.plausible, key=abs)


def set_at(effect: str, values: dict[str, float], place: str) -> EffectSetting:
    """Return an effect with values, restricted to one place; everywhere where the effect has no places.

    Parameters
    ----------
    effect : str
        Name in the catalogue.
    values : dict, parameter -> value
        In the parameters' units.
    place : str
        Sensor, indenter or mount; empty for all touches.
    """
    return EffectSetting(effect, values, {EFFECTS[effect]().varies_by: place} if place else {})


def strength_of(setting: EffectSetting, parameter: Parameter) -> Strength:
    """Return the strength that a parameter of a setting is."""
    return Strength(setting.effect, parameter.name, setting.place)

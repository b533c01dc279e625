"""What a candidate fits: a strength of an effect, at one place where the effect is another one for each."""

from __future__ import annotations

from typing import NamedTuple

from tactiledata.effects import EFFECTS
from tactiledata.effects.parameter import Parameter
from tactiledata.effects.simulate.setting import EffectSetting


class Strength(NamedTuple):
    """One strength of an effect, of the touches at one place where the effect is another one for each."""

    effect: str
    name: str
    place: str = ""

    @property
    def label(self) -> str:
        """For tables: ``"x of ball3"``."""
        return f"{self.name} of {self.place}" if self.place else self.name

    @property
    def parameter(self) -> Parameter:
        """As the effect has it."""
        return next(one for one in EFFECTS[self.effect]().parameters if one.name == self.name)

    @property
    def end(self) -> float:
        """Of what is plausible, the farther one from nothing."""
        return max(self.parameter.plausible, key=abs)


def set_at(effect: str, values: dict[str, float], place: str) -> EffectSetting:
    """An effect with values, at one place where it is another one for each; everywhere where no place is named."""
    return EffectSetting(effect, values, {EFFECTS[effect]().varies_by: place} if place else {})


def strength_of(setting: EffectSetting, parameter: Parameter) -> Strength:
    """The strength that a parameter is in a setting."""
    return Strength(setting.effect, parameter.name, setting.place)

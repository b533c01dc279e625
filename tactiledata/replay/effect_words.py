"""Words for the effects with which a mesh was replayed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactiledata.effects.simulate.setting import EffectSetting


def effects_in_words(settings: Mapping[str, Any]) -> str:
    """Describe the effects in a mesh's settings, separated by semicolons; empty where there are none."""
    return "; ".join(_words(EffectSetting(**document)) for document in settings.get("effects", []))


def _words(setting: EffectSetting) -> str:
    """Describe one effect: title, values with units, and the sensor, indenter or mounting that it is restricted to."""
    parameters = setting.member.parameters
    # a parameter at its null changes nothing and is left out
    shown = [
        parameter
        for parameter in parameters
        if parameter.null is None or setting.values[parameter.name] != parameter.null
    ]
    values = [
        f"{parameter.name} {setting.values[parameter.name]:.3g}{'' if parameter.unit == '1' else ' ' + parameter.unit}"
        for parameter in shown
    ]
    where = [f"of {name.removesuffix('_name')} {value}" for name, value in setting.where.items()]
    return " ".join([setting.member.title, f"({', '.join(values)})", *where])

"""The effects that a mesh was replayed with, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactiledata.effects.simulate.setting import EffectSetting


def effects_in_words(settings: Mapping[str, Any]) -> str:
    """Of a mesh's settings; empty where there are none."""
    return "; ".join(_words(EffectSetting(**one)) for one in settings.get("effects", []))


def _words(setting: EffectSetting) -> str:
    parameters = setting.member.parameters
    # a strength at its null says nothing, nor do shapes of it
    told = [one for one in parameters if one.null is None or setting.values[one.name] != one.null]
    values = [f"{one.name} {setting.values[one.name]:.3g}{'' if one.unit == '1' else ' ' + one.unit}" for one in told]
    where = [f"of {name.removesuffix('_name')} {wanted}" for name, wanted in setting.where.items()]
    return " ".join([setting.member.title, f"({', '.join(values)})", *where])

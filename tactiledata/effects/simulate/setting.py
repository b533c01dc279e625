"""An effect with its values, as a simulator takes it and as a file keeps it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import write_json_atomic
from tactiledata.contract.schema import check_document, read_document
from tactiledata.effects import EFFECTS
from tactiledata.effects.base import SLOTS, Effect
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UnknownName
from tactiledata.gel.elasticity.material import GelMaterial

FORMAT = "tactiledata-effects/1"
"""Format that a file of settings states."""
PLACES = ("sensor", "indenter_name", "mount")
"""Fields of a touch to whose values a setting can be restricted."""


@dataclass(frozen=True)
class EffectSetting:
    """One effect with its values; the same effect may be set several times, for example as a spectrum of relaxations.

    Parameters
    ----------
    effect : str
        Name in the table.
    values : dict, parameter -> value
        Values in SI units; parameters that are not given have their defaults.
    where : dict, place -> value
        Restricts the setting to touches of one ``sensor``, ``indenter_name`` or ``mount``; empty for all touches.

    Raises
    ------
    UnknownName
        An effect, a parameter or a place that does not exist.
    UsageError
        A value outside its bounds.
    """

    effect: str
    values: Mapping[str, float] = field(default_factory=dict)
    where: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Complete the values, and refuse a place that is no field of ``PLACES``."""
        object.__setattr__(self, "values", self.member.complete(self.values))
        for name in self.where:
            if name not in PLACES:
                raise UnknownName("place of an effect", name, PLACES)

    @cached_property
    def member(self) -> Effect:
        """The effect that the table holds under the name."""
        member: Effect = EFFECTS[self.effect]()
        return member

    @cached_property
    def is_null(self) -> bool:
        """Whether every strength is null, so that the setting changes nothing."""
        return self.member.has_no_strength(self.values)

    def acts_on(self, touch: Touch) -> bool:
        """Whether a touch is among those to which the setting is restricted."""
        return not self.where or all(getattr(touch, name) == value for name, value in self.where.items())

    def apply(self, state: TouchState) -> TouchState:
        """Return the state with the effect; the very same object where the setting does not act on the touch."""
        return state if self.is_null or not self.acts_on(state.touch) else self.member.applied(state, self.values)

    def weakened(self, share: float) -> EffectSetting:
        """Return the setting with a share of its strengths; its shape parameters stay."""
        nulls = {one.name: one.null for one in self.member.parameters if one.null is not None}
        weak = {name: nulls[name] + share * (self.values[name] - nulls[name]) for name in nulls}
        return EffectSetting(self.effect, {**self.values, **weak}, self.where)

    @property
    def place(self) -> str:
        """Values to which the setting is restricted, in words; empty where it acts on all touches."""
        return ", ".join(self.where.values())

    @property
    def document(self) -> dict[str, Any]:
        """The setting as an entry of ``schemas/effect.json``."""
        where = {"where": dict(self.where)} if self.where else {}
        return {"effect": self.effect, "values": dict(self.values), **where}


def in_order(settings: Iterable[EffectSetting]) -> tuple[EffectSetting, ...]:
    """Return settings in the order in which they act: by slot, then by the table, then as given."""
    place = {name: index for index, name in enumerate(EFFECTS)}
    return tuple(sorted(settings, key=lambda setting: (SLOTS.index(setting.member.slot), place[setting.effect])))


def effects_document(settings: Iterable[EffectSetting], material: GelMaterial | None = None) -> dict[str, Any]:
    """Return settings as a document that fits ``schemas/effect.json``.

    Parameters
    ----------
    settings : iterable of EffectSetting
        Effects with their values, in any order.
    material : GelMaterial, optional
        Material of the gel that was fitted together with the effects.
    """
    gel = {} if material is None else {"material": asdict(material)}
    return {"format": FORMAT, "effects": [setting.document for setting in in_order(settings)], **gel}


def settings_of(document: Any, where: str) -> tuple[EffectSetting, ...]:
    """Return the settings in a document, in the order in which they act.

    Parameters
    ----------
    document : dict
        A document as ``schemas/effect.json`` describes it.
    where : str
        Name of the document, for messages.

    Raises
    ------
    SchemaError
        A document that does not fit ``schemas/effect.json``.
    UnknownName
        An effect, a parameter or a place that does not exist.
    UsageError
        A value out of bounds.
    """
    check_document(document, "effect", where)
    return in_order(
        EffectSetting(entry["effect"], entry["values"], entry.get("where", {})) for entry in document["effects"]
    )


def write_settings(settings: Iterable[EffectSetting], path: Path | str, material: GelMaterial | None = None) -> None:
    """Write settings to a JSON file, whole or not at all.

    Parameters
    ----------
    settings : iterable of EffectSetting
        Effects with their values, in any order.
    path : Path
        The file; one that exists is replaced.
    material : GelMaterial, optional
        Material of the gel that was fitted together with the effects.
    """
    write_json_atomic(Path(path), effects_document(settings, material))


def read_settings(path: Path | str) -> tuple[EffectSetting, ...]:
    """Return the settings in a file; the errors are those of `settings_of`."""
    return settings_of(read_document(Path(path)), str(path))


def read_material(path: Path | str) -> GelMaterial | None:
    """Return the material that was fitted together with the effects of a file; ``None`` where the file has none."""
    document = read_document(Path(path), "effect")
    return GelMaterial(**document["material"]) if "material" in document else None

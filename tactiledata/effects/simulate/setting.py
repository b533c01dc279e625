"""An effect with its values: what a simulator is given, and what is kept in a file."""

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
PLACES = ("sensor", "indenter_name", "mount")
"""What a setting can be restricted to."""


@dataclass(frozen=True)
class EffectSetting:
    """One effect as it is set; the same effect may be set several times, as a spectrum of relaxations.

    Parameters
    ----------
    effect : str
        Name in the table.
    values : dict, parameter -> value
        Those not given have their defaults.
    where : dict
        Restricts it to touches of one ``sensor``, ``indenter_name`` or ``mount``.

    Raises
    ------
    UnknownName
        No such effect, parameter or place.
    UsageError
        A value outside its bounds.
    """

    effect: str
    values: Mapping[str, float] = field(default_factory=dict)
    where: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", self.member.complete(self.values))
        for name in self.where:
            if name not in PLACES:
                raise UnknownName("place of an effect", name, PLACES)

    @cached_property
    def member(self) -> Effect:
        """The effect itself."""
        member: Effect = EFFECTS[self.effect]()
        return member

    @cached_property
    def is_null(self) -> bool:
        """Whether it changes nothing."""
        return self.member.is_null(self.values)

    def acts_on(self, touch: Touch) -> bool:
        """Whether a touch is one of those that it is restricted to."""
        return all(getattr(touch, name) == wanted for name, wanted in self.where.items())

    def apply(self, state: TouchState) -> TouchState:
        """The state with the effect."""
        return state if self.is_null or not self.acts_on(state.touch) else self.member.applied(state, self.values)

    @property
    def place(self) -> str:
        """What it is restricted to, in words; empty where it acts everywhere."""
        return ", ".join(self.where.values())

    @property
    def document(self) -> dict[str, Any]:
        """The setting as ``schemas/effect.json`` has it."""
        where = {"where": dict(self.where)} if self.where else {}
        return {"effect": self.effect, "values": dict(self.values), **where}


def in_order(settings: Iterable[EffectSetting]) -> tuple[EffectSetting, ...]:
    """Settings in the order in which they act: by slot, then as the table has them, then as given."""
    place = {name: number for number, name in enumerate(EFFECTS)}
    return tuple(sorted(settings, key=lambda setting: (SLOTS.index(setting.member.slot), place[setting.effect])))


def effects_document(settings: Iterable[EffectSetting], material: GelMaterial | None = None) -> dict[str, Any]:
    """Settings, and the gel that was fitted together with them, as a document that fits ``schemas/effect.json``."""
    gel = {} if material is None else {"material": asdict(material)}
    return {"format": FORMAT, "effects": [setting.document for setting in in_order(settings)], **gel}


def settings_of(document: Any, where: str) -> tuple[EffectSetting, ...]:
    """The settings in a document.

    Raises
    ------
    SchemaError
        It does not fit ``schemas/effect.json``.
    UnknownName, UsageError
        An effect, a parameter or a value that there is not.
    """
    check_document(document, "effect", where)
    return in_order(
        EffectSetting(entry["effect"], entry["values"], entry.get("where", {})) for entry in document["effects"]
    )


def write_settings(settings: Iterable[EffectSetting], path: Path | str, material: GelMaterial | None = None) -> None:
    """Write them to a JSON file, whole or not at all."""
    write_json_atomic(Path(path), effects_document(settings, material))


def read_settings(path: Path | str) -> tuple[EffectSetting, ...]:
    """The settings in a file; errors as those of `settings_of`."""
    return settings_of(read_document(Path(path)), str(path))


def read_material(path: Path | str) -> GelMaterial | None:
    """The gel that was fitted together with the effects of a file, where it says so."""
    document = read_document(Path(path), "effect")
    return GelMaterial(**document["material"]) if "material" in document else None

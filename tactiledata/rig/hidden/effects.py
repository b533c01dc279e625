"""The table of hidden effects, and the reading of a scenario's `hidden` section."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from tactiledata.errors import SchemaError
from tactiledata.registry import Registry

if TYPE_CHECKING:
    from tactiledata.rig.hidden.base import HiddenEffect

_RIG = "tactiledata.rig.hidden"
HIDDEN_EFFECTS = Registry(
    "hidden effect",
    {
        "relaxation": f"{_RIG}.time:HiddenSpringpot",
        "mullins": f"{_RIG}.history:HiddenWorkSoftening",
        "stiffening": f"{_RIG}.material:HiddenOgdenShear",
        "thickness": f"{_RIG}.geometry:HiddenThickness",
        "dome": f"{_RIG}.geometry:HiddenDome",
        "adhesion": f"{_RIG}.adhesion:HiddenPinnedEdge",
        "shear_strength": f"{_RIG}.friction:HiddenShearStrength",
        "rate_friction": f"{_RIG}.friction:HiddenRateFriction",
        "ageing_friction": f"{_RIG}.friction:HiddenAgeingFriction",
        "partial_slip": f"{_RIG}.friction:HiddenManySliders",
        "arm_compliance": f"{_RIG}.pose:HiddenJointCompliance",
        "stem_bending": f"{_RIG}.pose:HiddenStemBending",
        "ft_drift": f"{_RIG}.sensor:HiddenWanderingZero",
        "cross_talk": f"{_RIG}.sensor:HiddenCrossTalk",
        "tool_weight": f"{_RIG}.load:HiddenToolWeight",
        "cable_drag": f"{_RIG}.load:HiddenCableDrag",
        "frame_rotation": f"{_RIG}.sensor:HiddenFrameRotation",
        "lag": f"{_RIG}.sensor:HiddenSlowSensor",
        "clock_skew": f"{_RIG}.clock:HiddenClockSkew",
        "indenter_mount": f"{_RIG}.geometry:HiddenIndenterMount",
        "warm_up": f"{_RIG}.history:HiddenWarmUp",
        "wear": f"{_RIG}.history:HiddenWear",
        "delamination": f"{_RIG}.material:HiddenDelamination",
        "pad_edge": f"{_RIG}.material:HiddenPadEdge",
        "skin": f"{_RIG}.material:HiddenSkin",
        "dead_band": f"{_RIG}.sensor:HiddenDeadBand",
        "saturation": f"{_RIG}.sensor:HiddenSaturation",
        "inertia": f"{_RIG}.load:HiddenInertia",
        "joint_backlash": f"{_RIG}.pose:HiddenJointBacklash",
        "drainage": f"{_RIG}.time:HiddenDrainage",
        "anisotropy": f"{_RIG}.friction:HiddenAnisotropy",
        "warm_relaxation": f"{_RIG}.time:HiddenWarmSpringpot",
    },
)


def name_of(effect: HiddenEffect) -> str:
    """Return the name under which ``HIDDEN_EFFECTS`` holds the class of an effect, such as ``"wear"``."""
    return next(name for name in HIDDEN_EFFECTS if HIDDEN_EFFECTS[name] is type(effect))


def hidden_effect(entry: Mapping[str, Any], path: str, where: str) -> HiddenEffect:
    """Return the effect that one entry of a scenario's `hidden` section names.

    Parameters
    ----------
    entry : dict
        ``effect``, and ``strength`` or ``parameters`` or both: stated parameters win over those of the strength, and
        all others keep the value of no effect.
    path, where : str
        Place of the entry in the document, and the document's name, for error messages.

    Raises
    ------
    SchemaError
        The effect or a parameter is unknown, a value is out of its range, or the entry states neither strength nor
        parameters.
    """
    name = entry["effect"]
    if name not in HIDDEN_EFFECTS:
        raise _fault(
            where, f"{path}.effect", f"no hidden effect is called {name!r}", f"one of: {_listed(HIDDEN_EFFECTS)}"
        )
    kind: type[HiddenEffect] = HIDDEN_EFFECTS[name]
    if "strength" not in entry and "parameters" not in entry:
        raise _fault(where, path, f"{name} says neither how strong it is nor its parameters", "strength or parameters")
    stated = dict(entry.get("parameters", {}))
    for key, value in stated.items():
        if key not in kind.RANGES:
            raise _fault(
                where, f"{path}.parameters.{key}", f"{name} has no parameter {key!r}", f"of {_listed(kind.RANGES)}"
            )
        least, most = kind.RANGES[key]
        if not least <= value <= most:
            raise _fault(where, f"{path}.parameters.{key}", f"{value:g}", f"between {least:g} and {most:g}")
    strength = kind.STRENGTHS[entry["strength"]] if "strength" in entry else {}
    return kind(**{**strength, **stated})


def is_null(effect: HiddenEffect) -> bool:
    """Return whether a hidden effect changes nothing: every parameter of its strengths has exactly its default.

    A hidden effect is physics that a scenario puts into the recordings and a diagnosis has to find. Its class names
    strengths (`HiddenEffect.STRENGTHS`: weak, medium, strong), each a value for one or several of its parameters, and
    the defaults of a class are those of no effect. Parameters that no strength sets, such as a reference speed, do not
    count, so that a class without strengths would always be null. Scenarios leave out effects that are null.
    """
    nulls = {item.name: item.default for item in fields(effect)}  # type: ignore[arg-type]
    scaled = {key for strength in type(effect).STRENGTHS.values() for key in strength}
    return all(getattr(effect, key) == nulls[key] for key in scaled)


def _listed(names: Any) -> str:
    """Return names, sorted, with commas between."""
    return ", ".join(sorted(names))


def _fault(where: str, path: str, found: str, expected: str) -> SchemaError:
    """Return the error for a fault at a path inside a scenario file."""
    return SchemaError(f"{where}, at {path}: {found}", expected, "Mend the scenario file.", path=path, file=where)

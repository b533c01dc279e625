"""What the rig's hidden effects are called in the catalogue, and worlds of two, or of none, of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import log1p, tanh
from typing import Any, ClassVar

import numpy as np

from tactiledata.effects.interface.area_friction import AreaFriction
from tactiledata.effects.interface.static_friction import StaticFriction
from tactiledata.rig.contact.contact import TouchSetup
from tactiledata.rig.contact.footprint import GelGrid, make_footprint
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, TouchFacts
from tactiledata.rig.hidden.friction import AGEING_ONSET, HiddenAgeingFriction, HiddenShearStrength
from tactiledata.rig.hidden.slider import CRITICAL_SLIP
from tactiledata.rig.hidden.time import HiddenSpringpot

TITLES = {
    "relaxation": "relaxation",
    "mullins": "mullins",
    "stiffening": "strain_stiffening",
    "thickness": "thickness",
    "dome": "dome",
    "adhesion": "adhesion",
    "shear_strength": "area_friction",
    "rate_friction": "rate_friction",
    "ageing_friction": "static_friction",
    "partial_slip": "partial_slip",
    "arm_compliance": "arm_compliance",
    "stem_bending": "stem_bending",
    "ft_drift": "sensor_drift",
    "cross_talk": "gain_crosstalk",
    "tool_weight": "tool_weight",
    "cable_drag": "cable_drag",
    "frame_rotation": "frame_rotation",
    "lag": "lag",
    "clock_skew": "clock_skew",
    "indenter_mount": "mount_offset",
    "warm_up": "heating",
    "wear": "wear",
    "delamination": "soft_region",
    "pad_edge": "pad_edge",
    "skin": "skin",
    "dead_band": "quantisation",
    "saturation": "clipping",
    "inertia": "inertia",
}
OUTSIDE = ("joint_backlash", "drainage", "anisotropy", "warm_relaxation")
PAIRS = (
    ("relaxation", "frame_rotation"),
    ("rate_friction", "tool_weight"),
    ("relaxation", "ft_drift"),
    ("arm_compliance", "rate_friction"),
    ("cross_talk", "relaxation"),
    ("warm_up", "lag"),
)


RELAXED_AFTER = 10.0
"""Time, s, that a touch lasts, about: no power law has a modulus of its own at rest."""


def modulus_left(effects: Sequence[HiddenEffect]) -> float:
    """Share of the modulus at once that hidden relaxation leaves after a touch: what a relaxed gel's E is then."""
    springpots = [one for one in effects if isinstance(one, HiddenSpringpot)]
    return float(np.prod([(1 + RELAXED_AFTER / one.onset) ** -one.alpha for one in springpots]))


def friction_left(effects: Sequence[HiddenEffect], friction: float) -> float:
    """What hidden laws make of friction where the effect that they are called says that mu holds, as a share of it.

    That is a long slide at 1 mm/s for rest, and a mean pressure of 0.3 MPa for a shear strength.
    """
    speed, pressure = StaticFriction().complete({})["speed"], AreaFriction().complete({})["pressure"]
    share = 1.0
    for one in effects:
        if isinstance(one, HiddenAgeingFriction):
            share *= 1 + one.growth * log1p(CRITICAL_SLIP / speed / AGEING_ONSET)
        if isinstance(one, HiddenShearStrength) and one.softness > 0:
            load = friction * pressure * one.softness
            share *= tanh(load) / load
    return share


@dataclass(frozen=True)
class WrongRadius(HiddenEffect):
    """One indenter is larger than the log says.

    Parameters
    ----------
    indenter : str
        Name of the indenter.
    share : float
        By which share its radius is larger.
    """

    NUMBER: ClassVar[str] = "20"
    ACTS: ClassVar[str] = "pose"
    SOURCE: ClassVar[str] = "a wrong entry in a log"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {}
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {}
    indenter: str = ""
    share: float = 0.0

    def prepared(self, setup: TouchSetup, facts: TouchFacts) -> TouchSetup:
        """Return the touch with the real radius; see `HiddenEffect.prepared`."""
        if facts.touch.indenter != self.indenter:
            return setup
        stated: Any = setup.indenter
        real = replace(stated, radius=stated.radius * (1 + self.share))
        grid = GelGrid.of(facts.scenario.sensors[facts.touch.sensor].gel)
        footprint = make_footprint(real, setup.rotation, facts.touch.position, grid)
        return replace(setup, indenter=real, footprint=footprint)

"""Hidden geometry: a gel of another thickness, a dome, an indenter of another place and size than the log states."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from tactiledata.indenters import make_indenter
from tactiledata.rig.contact.contact import TouchSetup
from tactiledata.rig.contact.footprint import GelGrid, make_footprint
from tactiledata.rig.contact.gel_cap import Cap
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, TouchFacts, touch_random


@dataclass(frozen=True)
class HiddenThickness(HiddenEffect):
    """The gel is ``(1 + error)`` times as thick as stated; every form of contact is solved on that gel.

    Parameters
    ----------
    error : float
        Relative error of the stated thickness.
    """

    NUMBER: ClassVar[str] = "4"
    ACTS: ClassVar[str] = "contact"
    SOURCE: ClassVar[str] = "the rig's own layer, on another thickness"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"error": -0.05},
        "medium": {"error": -0.10},
        "strong": {"error": -0.20},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"error": (-0.5, 1.0)}
    error: float = 0.0

    def prepared(self, setup: TouchSetup, facts: TouchFacts) -> TouchSetup:
        """Return the touch on a gel of the real thickness."""
        return replace(setup, thickness=setup.thickness * (1 + self.error))


@dataclass(frozen=True)
class HiddenDome(HiddenEffect):
    """The outer surface is a spherical cap over a flat base, so that the gel is lower, thinner and inclined off centre.

    At a distance r from the middle it is lower and thinner by R - sqrt(R² - r²). In a touch the gel is everywhere as
    thin as it is at the touch's position.

    Parameters
    ----------
    curvature : 1/m
        Reciprocal of the sphere's radius, 1 / R.
    """

    NUMBER: ClassVar[str] = "5"
    ACTS: ClassVar[str] = "contact"
    SOURCE: ClassVar[str] = "geometry of a spherical cap"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"curvature": 1 / 0.160},
        "medium": {"curvature": 1 / 0.080},
        "strong": {"curvature": 1 / 0.040},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"curvature": (0.0, 50.0)}
    curvature: float = 0.0

    def prepared(self, setup: TouchSetup, facts: TouchFacts) -> TouchSetup:
        """Return the touch on a dome: thinner and lower by the dome's sag at its position."""
        if self.curvature == 0:
            return setup
        cap = Cap(self.curvature)
        # at least a third of the gel's thickness is left
        sag = min(float(cap.fall(*facts.touch.position)), 2 * setup.thickness / 3)
        offset = setup.offset - np.array([0.0, 0.0, sag])
        return replace(setup, thickness=setup.thickness - sag, offset=offset, cap=cap)


@dataclass(frozen=True)
class HiddenIndenterMount(HiddenEffect):
    """Each indenter stands elsewhere than the log states and has another radius, the same in every log.

    The offsets have the stated sizes; signs and the direction in the plane are drawn per indenter.

    Parameters
    ----------
    height, aside : m
        Sizes of the offsets along and across the indenter's axis.
    radius : float
        Relative error of the radius, of shapes that have one.
    """

    NUMBER: ClassVar[str] = "20"
    ACTS: ClassVar[str] = "pose"
    SOURCE: ClassVar[str] = "tolerances of printed parts"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"height": 5e-5, "aside": 1e-4, "radius": 0.005},
        "medium": {"height": 1e-4, "aside": 2e-4, "radius": 0.015},
        "strong": {"height": 2e-4, "aside": 5e-4, "radius": 0.03},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {
        "height": (0.0, 1e-3),
        "aside": (0.0, 2e-3),
        "radius": (-0.2, 0.2),
    }
    height: float = 0.0
    aside: float = 0.0
    radius: float = 0.0

    def prepared(self, setup: TouchSetup, facts: TouchFacts) -> TouchSetup:
        """Return the touch with the indenter's real place and size."""
        rng = touch_random(facts, f"mount of {facts.touch.indenter}")
        signs = rng.choice([-1.0, 1.0], 2)
        angle = rng.uniform(0.0, 2 * np.pi)
        # fixed on the table: it turns with the indenter's yaw over the gel
        across = setup.rotation[:2, :2] @ [np.cos(angle), np.sin(angle)]
        offset = setup.offset + np.array([*(self.aside * across), signs[0] * self.height])
        setup = replace(setup, offset=offset)
        entry: Mapping[str, Any] = facts.scenario.indenters[facts.touch.indenter]
        if self.radius == 0 or "radius" not in setup.indenter.sizes or "mesh" in entry:
            return setup
        real = {**entry, "radius": setup.indenter.sizes["radius"] * (1 + signs[1] * self.radius)}
        indenter = make_indenter(real, facts.scenario.folder, f"indenters.{facts.touch.indenter}")
        grid = GelGrid.of(facts.scenario.sensors[facts.touch.sensor].gel)
        footprint = make_footprint(indenter, setup.rotation, facts.touch.position, grid)
        return replace(setup, indenter=indenter, footprint=footprint)

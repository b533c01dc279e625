"""Hidden friction: limits of friction that depend on more than the load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import asinh, cos, exp, log, log1p, tanh
from typing import ClassVar

from tactiledata.rig.hidden.base import FrictionFactor, HiddenEffect, Parameters, RealTouch, Slide

AGEING_ONSET = 0.03
"""Time of rest, s, from which on a contact ages."""


@dataclass(frozen=True)
class HiddenRateFriction(HiddenEffect):
    """Friction depends on the speed: the rate part of rate-and-state friction, regularised at rest.

    limit = N A asinh[v / (2 v0) exp(mu / A)], A = per_decade mu / ln 10, with mu Coulomb's coefficient at the speed v0.

    Parameters
    ----------
    per_decade : float
        Relative rise of friction per factor ten of the speed.
    speed : m/s
        The reference speed v0.
    """

    NUMBER: ClassVar[str] = "8"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "A. Ruina, J. Geophys. Res. 88 (1983); J. R. Rice, N. Lapusta, K. Ranjith, JMPS 49 (2001)"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"per_decade": 0.05},
        "medium": {"per_decade": 0.12},
        "strong": {"per_decade": 0.25},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"per_decade": (0.0, 0.5), "speed": (1e-6, 0.1)}
    per_decade: float = 0.0
    speed: float = 1e-3

    def friction(self, real_touch: RealTouch) -> FrictionFactor | None:
        """Return the factor on Coulomb's limit at a speed; None without effect."""
        if self.per_decade == 0:
            return None
        share = self.per_decade / log(10.0)
        scale = exp(1 / share) / (2 * self.speed)
        return lambda slide: share * asinh(slide.speed * scale)


@dataclass(frozen=True)
class HiddenAgeingFriction(HiddenEffect):
    """A contact that rests grows stronger: limit (1 + b ln(1 + age / 0.03 s)); it forgets its age in 30 µm of sliding.

    Rate-and-state friction's state part in the ageing law, d age / dt = 1 - v age / 30 µm.

    Parameters
    ----------
    growth : float
        The factor b; after 1 s of rest the limit is 1 + 3.5 b times that of a fresh contact.
    """

    NUMBER: ClassVar[str] = "9"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = (
        "J. H. Dieterich, J. Geophys. Res. 84 (1979); T. Baumberger, C. Caroli, Adv. Phys. 55 (2006)"
    )
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"growth": 0.015},
        "medium": {"growth": 0.04},
        "strong": {"growth": 0.10},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"growth": (0.0, 0.5)}
    growth: float = 0.0

    def friction(self, real_touch: RealTouch) -> FrictionFactor | None:
        """Return the factor on Coulomb's limit at an age of the contact."""
        return lambda slide: 1 + self.growth * log1p(slide.age / AGEING_ONSET)


@dataclass(frozen=True)
class HiddenShearStrength(HiddenEffect):
    """The interface carries no more shear stress than its strength tau: limit = A tau tanh[mu N / (A tau)].

    Parameters
    ----------
    softness : 1/Pa
        Reciprocal of the shear strength, 1 / tau.
    """

    NUMBER: ClassVar[str] = "7"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "Coulomb's law limited by a shear strength (F. P. Bowden, D. Tabor), joined by tanh"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"softness": 1 / 0.8e6},
        "medium": {"softness": 1 / 0.4e6},
        "strong": {"softness": 1 / 0.2e6},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"softness": (0.0, 1e-4)}
    softness: float = 0.0

    def friction(self, real_touch: RealTouch) -> FrictionFactor | None:
        """Return the factor on Coulomb's limit at a pressure."""
        coefficient = real_touch.setup.material.friction

        def factor(slide: Slide) -> float:
            load = coefficient * slide.pressure * self.softness
            return tanh(load) / load if load > 0 else 1.0

        return factor


@dataclass(frozen=True)
class HiddenManySliders(HiddenEffect):
    """The contact slides part by part (Iwan's model): it is twelve sliders side by side with different limits.

    Parameters
    ----------
    width : float
        Relative half-width of the limits, which lie evenly within ``1 -/+ width`` of their mean.
    """

    NUMBER: ClassVar[str] = "10"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "W. D. Iwan, J. Appl. Mech. 33 (1966)"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"width": 0.3},
        "medium": {"width": 0.6},
        "strong": {"width": 1.0},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"width": (0.0, 1.0)}
    width: float = 0.0

    def spread(self) -> float:
        """Return the relative half-width of the sliders' limits."""
        return self.width


@dataclass(frozen=True)
class HiddenAnisotropy(HiddenEffect):
    """Friction depends on the direction over the gel: limit [1 + share cos 2 (direction - angle)].

    Parameters
    ----------
    share : float
        Relative amplitude.
    angle : rad
        Direction of the largest friction, gel frame, from x.
    """

    NUMBER: ClassVar[str] = "outside"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "first even harmonic of a direction-dependent limit"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"share": 0.05},
        "medium": {"share": 0.12},
        "strong": {"share": 0.25},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"share": (0.0, 0.9), "angle": (-4.0, 4.0)}
    share: float = 0.0
    angle: float = 0.0

    def friction(self, real_touch: RealTouch) -> FrictionFactor | None:
        """Return the factor on Coulomb's limit at a direction of the pull."""
        return lambda slide: 1 + self.share * cos(2 * (slide.direction - self.angle))

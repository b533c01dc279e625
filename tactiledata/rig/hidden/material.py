"""Hidden material: stiffening with strain, a stiff skin, a loose region, an edge that is nearer than stated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactiledata.arrays import RealArray
from tactiledata.rig.hidden.base import HiddenEffect, Parameters, RealTouch

STEEPEST = 0.6
"""Strain beyond which stiffening grows no more."""


@dataclass(frozen=True)
class HiddenOgdenShear(HiddenEffect):
    """The gel stiffens with strain: Ogden's material of one term in pure shear, relative to the neo-Hookean one.

    F = F0 [sinh(a e) / (a e)] / [sinh(2 e) / (2 e)]; the exponent a = 2 is the neo-Hookean material.

    The logarithmic strain e = -ln(1 - s) comes from the layer's own measure s = 0.2 d / a + d / (3 h): Tabor's strain
    of an indentation of depth d and contact radius a, and a share of the layer's compression.

    Parameters
    ----------
    exponent : float
        The exponent a.
    """

    NUMBER: ClassVar[str] = "3"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "R. W. Ogden, Proc. R. Soc. A 326 (1972); D. Tabor, The Hardness of Metals (1951)"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"exponent": 3.0},
        "medium": {"exponent": 4.0},
        "strong": {"exponent": 6.0},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"exponent": (1.0, 12.0)}
    STIFFENS: ClassVar[bool] = True
    exponent: float = 2.0

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, of the stiffening gel."""
        local = 0.2 * np.divide(
            real_touch.depth, real_touch.radius, out=np.zeros_like(real_touch.depth), where=real_touch.radius > 0
        )
        strain = -np.log1p(-np.minimum(local + real_touch.depth / (3 * real_touch.setup.thickness), STEEPEST))
        return force * _shear_factor(self.exponent * strain) / _shear_factor(2.0 * strain)


def _shear_factor(argument: RealArray) -> RealArray:
    """Return sinh(x) / x of an argument (n,); 1 at 0."""
    return np.divide(np.sinh(argument), argument, out=np.ones_like(argument), where=argument > 1e-9)


@dataclass(frozen=True)
class HiddenSkin(HiddenEffect):
    """The gel has a skin of thickness t that is ``ratio`` times as stiff: F = F0 [1 + (ratio - 1) I(t / a)].

    I(x) = (2 / pi) atan x + {(1 - 2 nu) x ln[(1 + x²) / x²] - x / (1 + x²)} / [2 pi (1 - nu)], first order in the
    difference of the moduli, for a contact of radius a; contacts smaller than the skin count as large as it.

    Parameters
    ----------
    thickness : m
        Thickness t of the skin.
    ratio : float
        Modulus of the skin over that of the gel.
    """

    NUMBER: ClassVar[str] = "25"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "H. Gao, C.-H. Chiu, J. Lee, Int. J. Solids Structures 29 (1992)"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"thickness": 2e-5},
        "medium": {"thickness": 5e-5},
        "strong": {"thickness": 1e-4},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"thickness": (0.0, 3e-4), "ratio": (1.0, 20.0)}
    STIFFENS: ClassVar[bool] = True
    thickness: float = 0.0
    ratio: float = 6.0

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, of the gel with its skin."""
        if self.thickness == 0:
            return force
        nu = real_touch.setup.material.poisson_ratio
        x = self.thickness / np.maximum(real_touch.radius, self.thickness)
        share = (1 - 2 * nu) * x * np.log((1 + x**2) / x**2) - x / (1 + x**2)
        weight = 2 / np.pi * np.arctan(x) + share / (2 * np.pi * (1 - nu))
        return force * (1 + (self.ratio - 1) * weight)


@dataclass(frozen=True)
class HiddenPadEdge(HiddenEffect):
    """The free edge of the pad is nearer than the log states: F = F0 [1 - 0.5 exp(-s / a)], s the distance to it.

    Parameters
    ----------
    inset : m
        Distance by which the pad is smaller on every side; 0 is the stated outline, without any loss of force.
    """

    NUMBER: ClassVar[str] = "24"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "half of the support is lost at a free border; decay over one contact radius assumed"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"inset": 0.003},
        "medium": {"inset": 0.0045},
        "strong": {"inset": 0.006},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {"inset": (0.0, 0.009)}
    STIFFENS: ClassVar[bool] = True
    inset: float = 0.0

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, with the loss near the edge."""
        if self.inset == 0:
            return force
        half = np.asarray(real_touch.setup.footprint.grid.outline) / 2 - self.inset
        away = np.maximum((half - np.abs(real_touch.positions[:, :2])).min(axis=1), 0.0)
        return force * (1 - 0.5 * np.exp(-away / np.maximum(real_touch.radius, 1e-6)))


@dataclass(frozen=True)
class HiddenDelamination(HiddenEffect):
    """The backing has come off in a round region, where the gel is softer, above all along its surface.

    Tangential stiffness falls by ``share``, normal stiffness by a quarter of it, both times 1 / (1 + (r / radius)⁶).

    Parameters
    ----------
    share : float
        Relative loss of tangential stiffness.
    x, y, radius : m
        Centre and radius of the region, gel frame.
    """

    NUMBER: ClassVar[str] = "23"
    ACTS: ClassVar[str] = "force"
    SOURCE: ClassVar[str] = "a weaker bond as a weaker layer; the quarter is assumed"
    STRENGTHS: ClassVar[Mapping[str, Parameters]] = {
        "weak": {"share": 0.10},
        "medium": {"share": 0.30},
        "strong": {"share": 0.50},
    }
    RANGES: ClassVar[Mapping[str, tuple[float, float]]] = {
        "share": (0.0, 0.9),
        "x": (-0.01, 0.01),
        "y": (-0.015, 0.015),
        "radius": (1e-4, 0.01),
    }
    share: float = 0.0
    x: float = 0.0015
    y: float = 0.002
    radius: float = 0.0025

    def normal(self, force: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the normal force (n,), N, over the loose region."""
        return force * (1 - self.share / 4 * self._inside(real_touch))

    def tangential_stiffness(self, stiffness: RealArray, real_touch: RealTouch) -> RealArray:
        """Return the tangential stiffness (n,), N/m, over the loose region."""
        return stiffness * (1 - self.share * self._inside(real_touch))

    def _inside(self, real_touch: RealTouch) -> RealArray:
        """Return the weight (n,), 0 to 1, of the region at each position."""
        away = np.hypot(real_touch.positions[:, 0] - self.x, real_touch.positions[:, 1] - self.y)
        return 1 / (1 + (away / self.radius) ** 6)

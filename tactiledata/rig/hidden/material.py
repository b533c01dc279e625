"""Hidden material: stiffening with strain, a stiff skin, a loose region, a border nearer than the log says."""

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
    """Ogden's material of one term in pure shear against the neo-Hookean one, which it is at exponent 2:
    F = F0 [sinh(a e) / (a e)] / [sinh(2 e) / (2 e)].

    The logarithmic strain e = -ln(1 - s) comes from the layer's own measure s = 0.2 d / a + d / (3 h): Tabor's strain
    of an indentation of depth d and contact radius a, and a share of the layer's compression.

    Parameters
    ----------
    exponent : float
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
        """See `HiddenEffect.normal`."""
        local = 0.2 * np.divide(
            real_touch.depth, real_touch.radius, out=np.zeros_like(real_touch.depth), where=real_touch.radius > 0
        )
        strain = -np.log1p(-np.minimum(local + real_touch.depth / (3 * real_touch.setup.thickness), STEEPEST))
        return force * _shear_factor(self.exponent * strain) / _shear_factor(2.0 * strain)


def _shear_factor(argument: RealArray) -> RealArray:
    return np.divide(np.sinh(argument), argument, out=np.ones_like(argument), where=argument > 1e-9)


@dataclass(frozen=True)
class HiddenSkin(HiddenEffect):
    """A paint of thickness t, ``ratio`` times as stiff as the gel: F = F0 [1 + (ratio - 1) I(t / a)].

    I(x) = (2 / pi) atan x + {(1 - 2 nu) x ln[(1 + x²) / x²] - x / (1 + x²)} / [2 pi (1 - nu)], first order in the
    difference of the moduli, for a contact of radius a; contacts smaller than the skin count as large as it.

    Parameters
    ----------
    thickness : m
    ratio : float
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
        """See `HiddenEffect.normal`."""
        if self.thickness == 0:
            return force
        nu = real_touch.setup.material.poisson_ratio
        x = self.thickness / np.maximum(real_touch.radius, self.thickness)
        share = (1 - 2 * nu) * x * np.log((1 + x**2) / x**2) - x / (1 + x**2)
        weight = 2 / np.pi * np.arctan(x) + share / (2 * np.pi * (1 - nu))
        return force * (1 + (self.ratio - 1) * weight)


@dataclass(frozen=True)
class HiddenPadEdge(HiddenEffect):
    """The free border lies nearer than the log says: F = F0 [1 - 0.5 exp(-s / a)], s the distance to it.

    Parameters
    ----------
    inset : m
        By how much the pad is smaller on every side. Null: the stated outline, with nothing added.
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
        """See `HiddenEffect.normal`."""
        if self.inset == 0:
            return force
        half = np.asarray(real_touch.setup.footprint.grid.outline) / 2 - self.inset
        away = np.maximum((half - np.abs(real_touch.positions[:, :2])).min(axis=1), 0.0)
        return force * (1 - 0.5 * np.exp(-away / np.maximum(real_touch.radius, 1e-6)))


@dataclass(frozen=True)
class HiddenDelamination(HiddenEffect):
    """The backing has come off in a round region: tangential stiffness falls by ``share``, normal stiffness by a
    quarter of that, within a border that is smooth as 1 / (1 + (r / radius)⁶).

    Parameters
    ----------
    share : float
    x, y, radius : m
        The region, on the gel.
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
        """See `HiddenEffect.normal`."""
        return force * (1 - self.share / 4 * self._inside(real_touch))

    def tangential_stiffness(self, stiffness: RealArray, real_touch: RealTouch) -> RealArray:
        """See `HiddenEffect.tangential_stiffness`."""
        return stiffness * (1 - self.share * self._inside(real_touch))

    def _inside(self, real_touch: RealTouch) -> RealArray:
        away = np.hypot(real_touch.positions[:, 0] - self.x, real_touch.positions[:, 1] - self.y)
        return 1 / (1 + (away / self.radius) ** 6)

"""How much a press does to a gel, so that presses of several indenters can be compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import Indenter

SPREAD = 1.5e-3
"""m: standard deviation of the bell by which an earlier press counts at another place; about a contact's radius."""
DEEPEST = 2e-3
"""m: presses deeper than this count as this deep."""
_REACH, _PITCH, _DEPTHS = 6e-3, 1e-4, 81


@dataclass(frozen=True)
class ImprintTable:
    """Imprints of one indenter that presses head-on: the integral of the overlap's square over a flat gel, m^4.

    An elastic foundation of modulus E and thickness h holds E / (2 h) times as much energy.

    Parameters
    ----------
    depths : (d,) m
    imprints : (d,) m^4
    """

    depths: Array
    imprints: Array

    @staticmethod
    def of(indenter: Indenter) -> ImprintTable:
        """From where its body is."""
        line = np.arange(-_REACH, _REACH, _PITCH) + _PITCH / 2
        height = indenter.height(*np.meshgrid(line, line, indexing="ij")).ravel()
        depths = np.linspace(0.0, DEEPEST, _DEPTHS)
        overlap = np.maximum(depths[:, None] - np.sort(height[height < DEEPEST]), 0.0)
        return ImprintTable(depths, np.square(overlap).sum(axis=1) * _PITCH**2)

    def imprint(self, depth: Array | float) -> Array:
        """Of presses of these depths, m."""
        return np.asarray(np.interp(depth, self.depths, self.imprints))

    def depth(self, imprint: Array | float) -> Array:
        """How deep, m, this indenter has to press for such an imprint, m^4; 0 for none."""
        first = int(np.flatnonzero(self.imprints > 0)[0]) - 1
        depth = np.interp(imprint, self.imprints[first:], self.depths[first:])
        return np.where(np.asarray(imprint) > 0, depth, 0.0)


def strongest_imprint(places: Array, pressed: Array, imprints: Array) -> Array:
    """The largest imprint (n,), m^4, that counts at places (n, 2), m, of presses at places (p, 2); 0 without any."""
    away = np.linalg.norm(places[:, None] - pressed.reshape(-1, 2), axis=2)
    found: Array = (imprints * nearness(away)).max(axis=1, initial=0.0)
    return found


def nearness(distance: Array) -> Array:
    """By what an imprint counts at such a distance, m, from its place."""
    near: Array = np.exp(-0.5 * np.square(distance / SPREAD))
    return near

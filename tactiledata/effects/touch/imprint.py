"""A measure of how much a press strains a gel, by which presses of several indenters can be compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.indenters.base import Indenter

SPREAD = 1.5e-3
"""Standard deviation, m, of the Gaussian weight of an earlier press at a distance; about the radius of a contact."""
DEEPEST = 2e-3
"""Largest depth, m, of the table; deeper presses count as this deep."""
_REACH, _PITCH, _DEPTHS = 6e-3, 1e-4, 81
"""Half width, m, and pitch, m, of the grid on which an overlap is integrated; number of depths of a table."""


@dataclass(frozen=True)
class ImprintTable:
    """Imprints of one indenter that presses head-on, by depth.

    An imprint is the integral over a flat gel of the squared overlap, m^4. An elastic foundation of modulus E and
    thickness h holds E / (2 h) times as much energy.

    Parameters
    ----------
    depths : (d,) m
        Depths of the tip below the surface, ascending from 0 to ``DEEPEST``.
    imprints : (d,) m^4
        Imprint at each depth.
    """

    depths: Array
    imprints: Array

    @classmethod
    def of(cls, indenter: Indenter) -> ImprintTable:
        """Return the table of an indenter, integrated over the height of its body."""
        line = np.arange(-_REACH, _REACH, _PITCH) + _PITCH / 2
        height = indenter.height(*np.meshgrid(line, line, indexing="ij")).ravel()
        depths = np.linspace(0.0, DEEPEST, _DEPTHS)
        overlap = np.maximum(depths[:, None] - np.sort(height[height < DEEPEST]), 0.0)
        return cls(depths, np.square(overlap).sum(axis=1) * _PITCH**2)

    def imprint(self, depth: Array | float) -> Array:
        """Imprints, m^4, of presses of these depths, m."""
        return np.asarray(np.interp(depth, self.depths, self.imprints))

    def depth(self, imprint: Array | float) -> Array:
        """Depths, m, at which this indenter makes such imprints, m^4; 0 where the imprint is 0."""
        first = int(np.flatnonzero(self.imprints > 0)[0]) - 1
        depth = np.interp(imprint, self.imprints[first:], self.depths[first:])
        return np.where(np.asarray(imprint) > 0, depth, 0.0)


def strongest_imprint(places: Array, pressed: Array, imprints: Array) -> Array:
    """Largest imprint (n,), m^4, of earlier presses at each place, weighted by `nearness`; 0 without presses.

    Parameters
    ----------
    places : (n, 2), m
        Places on the gel, gel frame.
    pressed : (p, 2), m
        Places of the earlier presses.
    imprints : (p,), m^4
        Imprints of the earlier presses.
    """
    away = np.linalg.norm(places[:, None] - pressed.reshape(-1, 2), axis=2)
    strongest: Array = (imprints * nearness(away)).max(axis=1, initial=0.0)
    return strongest


def nearness(distance: Array) -> Array:
    """Weight, 1 to 0, of an imprint at a distance, m, from its place: a Gaussian of width ``SPREAD``."""
    near: Array = np.exp(-0.5 * np.square(distance / SPREAD))
    return near

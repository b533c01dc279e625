"""The three gel parameters that are fitted, and the boxes in which they are searched."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.errors import UnknownName

NAMES = ("youngs_modulus", "poisson_ratio", "friction")
SYMBOLS = {"youngs_modulus": "E", "poisson_ratio": "nu", "friction": "mu"}


@dataclass(frozen=True)
class Bounds:
    """The box of E, nu and mu that is searched.

    Parameters
    ----------
    name : str
        Key in ``BOUNDS``.
    low, high : (3,)
        Smallest and largest E (Pa), nu and mu.
    friction_nodes : ascending
        Coefficients of friction at which the gel is simulated; they span the box.
    """

    name: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    friction_nodes: tuple[float, ...]

    @property
    def span(self) -> Array:
        """Width (3,) of the box in E (Pa), nu and mu."""
        return np.subtract(self.high, self.low)

    def inside(self, values: Array) -> Array:
        """Return parameters (3,), each clipped to the box."""
        return np.clip(values, self.low, self.high)

    def scaled(self, shares: Array) -> Array:
        """Parameters E (Pa), nu, mu (3,) at shares (3,) of the way from low to high."""
        return self.inside(self.low + np.asarray(shares) * self.span)

    def shares(self, values: Array) -> Array:
        """Return parameters (3,) as shares (3,) of the way from low (0) to high (1)."""
        return (np.asarray(values) - self.low) / self.span

    @property
    def with_free_modulus(self) -> Bounds:
        """Copy of the box with E as free as in the widest box.

        E only multiplies simulated wrenches, so a wider range costs no simulation.
        """
        low, high = BOUNDS["wide"].low[0], BOUNDS["wide"].high[0]
        return replace(self, low=(low, *self.low[1:]), high=(high, *self.high[1:]))

    def __iter__(self) -> Iterator[tuple[str, float, float]]:
        return zip(NAMES, self.low, self.high, strict=True)


LARGEST_NU = 0.495
"""Largest Poisson's ratio of any box: the paper searches to 0.5, which would take an infinite bulk modulus."""

BOUNDS = {
    "paper": Bounds("paper", (838e3, 0.45, 0.5), (970e3, LARGEST_NU, 0.99), (0.5, 0.7, 0.99)),
    "wide": Bounds("wide", (200e3, 0.45, 0.2), (4e6, LARGEST_NU, 1.5), (0.2, 0.5, 0.7, 0.99, 1.5)),
}


def find_bounds(name: str) -> Bounds:
    """Return the box of a name in ``BOUNDS``; refuse an unknown name."""
    if name not in BOUNDS:
        raise UnknownName("bounds", name, BOUNDS)
    return BOUNDS[name]

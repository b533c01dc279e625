"""What is sought, and where."""

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
    """The box that is searched.

    Parameters
    ----------
    name : str
    low, high : (3,)
        Of E (Pa), nu and mu.
    friction_nodes : ascending
        Coefficients of friction at which the gel is played; they span the box.
    """

    name: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    friction_nodes: tuple[float, ...]

    @property
    def span(self) -> Array:
        """Width (3,) of the box."""
        return np.subtract(self.high, self.low)

    def inside(self, values: Array) -> Array:
        """The values (3,), moved into the box."""
        return np.clip(values, self.low, self.high)

    def scaled(self, shares: Array) -> Array:
        """Parameters (3,) at shares (3,) of the way from low to high."""
        return self.inside(self.low + np.asarray(shares) * self.span)

    def shares(self, values: Array) -> Array:
        """Shares (3,) of the way from low to high."""
        return (np.asarray(values) - self.low) / self.span

    @property
    def with_free_modulus(self) -> Bounds:
        """The same with E where the widest box has it: E only multiplies what is played."""
        low, high = BOUNDS["wide"].low[0], BOUNDS["wide"].high[0]
        return replace(self, low=(low, *self.low[1:]), high=(high, *self.high[1:]))

    def __iter__(self) -> Iterator[tuple[str, float, float]]:
        return zip(NAMES, self.low, self.high, strict=True)


LARGEST_NU = 0.495
"""The paper searches to 0.5, where no gel of finite bulk modulus is; the grid of responses ends here."""

BOUNDS = {
    "paper": Bounds("paper", (838e3, 0.45, 0.5), (970e3, LARGEST_NU, 0.99), (0.5, 0.7, 0.99)),
    "wide": Bounds("wide", (200e3, 0.45, 0.2), (4e6, LARGEST_NU, 1.5), (0.2, 0.5, 0.7, 0.99, 1.5)),
}


def find_bounds(name: str) -> Bounds:
    """The box of a name."""
    if name not in BOUNDS:
        raise UnknownName("bounds", name, BOUNDS)
    return BOUNDS[name]

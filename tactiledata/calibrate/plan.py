"""Which plays of the trajectories hold the response over nu, mu and the contact offset."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tactiledata.calibrate.bounds import Bounds

OFFSET = 5e-5
"""m: trajectories are played this much deeper and less deep, too."""
NU_NODES = 3
"""Chebyshev nodes over nu."""


@dataclass(frozen=True)
class Node:
    """One play of all trajectories.

    Parameters
    ----------
    poisson_ratio, friction : float
    offset : m
        By how much the indenter is deeper than recorded, along the gel frame's -z.
    """

    poisson_ratio: float
    friction: float
    offset: float


@dataclass(frozen=True)
class ResponsePlan:
    """Every pair of nu and mu without an offset; offsets along the two lines through the middle of the pairs.

    What an offset changes is taken to depend on nu and on mu, but not on both together: a third of the plays of a full
    grid, and within the noise (docs/calibration.md).

    Parameters
    ----------
    ratios, frictions : ascending nodes
    offset : m
    """

    ratios: tuple[float, ...]
    frictions: tuple[float, ...]
    offset: float = OFFSET

    @classmethod
    def of(cls, bounds: Bounds) -> ResponsePlan:
        """The nodes for a box."""
        low, high = bounds.low[1], bounds.high[1]
        angles = np.pi * (2 * np.arange(NU_NODES)[::-1] + 1) / (2 * NU_NODES)
        ratios = (low + high) / 2 + (high - low) / 2 * np.cos(angles)
        return cls(tuple(round(float(ratio), 6) for ratio in ratios), bounds.friction_nodes)

    @property
    def middle(self) -> tuple[int, int]:
        """Places of the pair through which the lines of offsets go."""
        return len(self.ratios) // 2, len(self.frictions) // 2

    def nodes(self) -> Iterator[Node]:
        """All plays, those of one nu and mu side by side."""
        nu_middle, mu_middle = self.middle
        for i, ratio in enumerate(self.ratios):
            for j, friction in enumerate(self.frictions):
                yield Node(ratio, friction, 0.0)
                if i == nu_middle or j == mu_middle:
                    yield Node(ratio, friction, -self.offset)
                    yield Node(ratio, friction, self.offset)

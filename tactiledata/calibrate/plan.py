"""The nodes over nu, mu and contact offset at which trajectories are simulated."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tactiledata.calibrate.bounds import Bounds

OFFSET = 5e-5
"""Contact offset, m, by which trajectories are also simulated deeper and less deep."""
NU_NODES = 3
"""Number of Chebyshev nodes over nu."""


@dataclass(frozen=True)
class Node:
    """Poisson's ratio, friction and contact offset of one simulation of all trajectories.

    Parameters
    ----------
    poisson_ratio, friction : float
        Of the gel.
    offset : m
        By how much the indenter is deeper than recorded, along the gel frame's -z.
    """

    poisson_ratio: float
    friction: float
    offset: float


@dataclass(frozen=True)
class ResponsePlan:
    """All pairs of nu and mu nodes without an offset, and offsets at the middle nu and at the middle mu only.

    The effect of an offset is taken to depend on nu and on mu, but not on their product. That costs a third of the
    simulations of a full grid, and the error stays within the noise (docs/calibration.md).

    Parameters
    ----------
    ratios, frictions : ascending
        Nodes over Poisson's ratio and friction.
    offset : m
        Step of the contact offset, taken in both directions.
    """

    ratios: tuple[float, ...]
    frictions: tuple[float, ...]
    offset: float = OFFSET

    @classmethod
    def of(cls, bounds: Bounds) -> ResponsePlan:
        """Return the nodes for a box: Chebyshev over nu, the box's own over friction."""
        low, high = bounds.low[1], bounds.high[1]
        angles = np.pi * (2 * np.arange(NU_NODES)[::-1] + 1) / (2 * NU_NODES)
        ratios = (low + high) / 2 + (high - low) / 2 * np.cos(angles)
        return cls(tuple(round(float(ratio), 6) for ratio in ratios), bounds.friction_nodes)

    @property
    def middle(self) -> tuple[int, int]:
        """Places of the middle nu and the middle mu, at which offsets are simulated."""
        return len(self.ratios) // 2, len(self.frictions) // 2

    def nodes(self) -> Iterator[Node]:
        """Yield all nodes; those of one nu and mu follow one another."""
        nu_middle, mu_middle = self.middle
        for i, ratio in enumerate(self.ratios):
            for j, friction in enumerate(self.frictions):
                yield Node(ratio, friction, 0.0)
                if i == nu_middle or j == mu_middle:
                    yield Node(ratio, friction, -self.offset)
                    yield Node(ratio, friction, self.offset)

"""What the gel answers at any nu, mu and offset, from a grid of plays; Young's modulus multiplies it exactly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator

from tactiledata.arrays import Array, Indices
from tactiledata.calibrate.plan import Node, ResponsePlan
from tactiledata.nuisance.offsets import OffsetSeries


@dataclass(frozen=True)
class Response:
    """Wrenches of n frames of t trajectories over Young's modulus, interpolated.

    Over nu by the polynomial through its nodes, over mu by a monotone cubic (friction is a straight line while all
    slips and a constant while all sticks), over the offset by a parabola.

    Parameters
    ----------
    plan : ResponsePlan
    starts : (t,)
        First row of each trajectory.
    level : (n_nu, n_mu, n, 6) m^2, m^3
        Without offset.
    by_ratio : (n_nu, 2, n, 6)
        Slope and curvature over the offset, at the middle mu.
    by_friction : (n_mu, 2, n, 6)
        The same at the middle nu.
    """

    plan: ResponsePlan
    starts: Indices
    level: Array
    by_ratio: Array
    by_friction: Array

    @classmethod
    def of(cls, plan: ResponsePlan, plays: Mapping[Node, Array], starts: Indices) -> Response:
        """From the plays' wrenches (n, 6), Young's modulus 1."""
        nu_middle, mu_middle = plan.middle

        def over_offset(ratio: float, friction: float) -> Array:
            less, none, more = (plays[Node(ratio, friction, z)] for z in (-plan.offset, 0.0, plan.offset))
            return np.stack([(more - less) / (2 * plan.offset), (more + less - 2 * none) / (2 * plan.offset**2)])

        return cls(
            plan,
            starts,
            np.array([[plays[Node(ratio, friction, 0.0)] for friction in plan.frictions] for ratio in plan.ratios]),
            np.array([over_offset(ratio, plan.frictions[mu_middle]) for ratio in plan.ratios]),
            np.array([over_offset(plan.ratios[nu_middle], friction) for friction in plan.frictions]),
        )

    @cached_property
    def _level_over_mu(self) -> PchipInterpolator:
        return PchipInterpolator(self.plan.frictions, self.level, axis=1)

    @cached_property
    def _offset_over_mu(self) -> PchipInterpolator:
        return PchipInterpolator(self.plan.frictions, self.by_friction, axis=0)

    @property
    def counts(self) -> Indices:
        """Frames (t,) of each trajectory."""
        return np.diff(self.starts, append=self.level.shape[2])

    def at(self, ratio: float, friction: float) -> OffsetSeries:
        """The response over the offset, Young's modulus 1."""
        mu_middle = self.plan.middle[1]
        weights = polynomial_weights(np.asarray(self.plan.ratios), ratio)
        slope, curvature = (
            np.tensordot(weights, self.by_ratio, axes=1) + self._offset_over_mu(friction) - self.by_friction[mu_middle]
        )
        return OffsetSeries(self.level_at(ratio, friction), slope, curvature)

    def level_at(self, ratio: float, friction: float) -> Array:
        """Wrenches (n, 6) without offset, Young's modulus 1."""
        return np.tensordot(
            polynomial_weights(np.asarray(self.plan.ratios), ratio), self._level_over_mu(friction), axes=1
        )

    def part(self, trajectories: Indices) -> Response:
        """The response of some trajectories, in the order given."""
        counts = self.counts[trajectories]
        rows = np.concatenate([np.arange(s, s + c) for s, c in zip(self.starts[trajectories], counts, strict=True)])
        return Response(
            self.plan,
            np.concatenate([[0], np.cumsum(counts)[:-1]]),
            self.level[:, :, rows],
            self.by_ratio[:, :, rows],
            self.by_friction[:, :, rows],
        )


def polynomial_weights(nodes: Array, place: float) -> Array:
    """Weights (n,) that give the polynomial through values at nodes (n,), at a place (Lagrange)."""
    gaps = nodes[:, None] - nodes
    np.fill_diagonal(gaps, 1.0)
    factors = np.broadcast_to(place - nodes, gaps.shape).copy()
    np.fill_diagonal(factors, 1.0)
    return factors.prod(axis=1) / gaps.prod(axis=1)

"""Simulated wrenches at any nu, mu and offset, interpolated in a grid of plays; Young's modulus is an exact factor."""

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
    """Interpolated wrenches of n frames of t trajectories, divided by Young's modulus.

    Over nu they follow the polynomial through the nodes, over the offset a parabola, and over mu a monotone cubic:
    the wrench is linear in mu while the whole contact slips and constant while all of it sticks.

    Parameters
    ----------
    plan : ResponsePlan
        The nodes.
    starts : (t,)
        First row of each trajectory.
    level : (n_nu, n_mu, n, 6) m^2, m^3
        Wrenches without offset.
    by_ratio : (n_nu, 2, n, 6)
        Slope and curvature over the offset (per m and m^2), at the middle mu.
    by_friction : (n_mu, 2, n, 6)
        Slope and curvature over the offset, at the middle nu.
    """

    plan: ResponsePlan
    starts: Indices
    level: Array
    by_ratio: Array
    by_friction: Array

    @classmethod
    def of(cls, plan: ResponsePlan, plays: Mapping[Node, Array], starts: Indices) -> Response:
        """Response from simulated wrenches.

        Parameters
        ----------
        plan : ResponsePlan
            The nodes.
        plays : mapping, node -> (n, 6) m^2, m^3
            Wrenches of every node of the plan, with Young's modulus 1.
        starts : (t,)
            First row of each trajectory.
        """
        nu_middle, mu_middle = plan.middle

        def over_offset(ratio: float, friction: float) -> Array:
            """Slope and curvature (2, n, 6) over the offset, by central differences."""
            shallower, level, deeper = (plays[Node(ratio, friction, z)] for z in (-plan.offset, 0.0, plan.offset))
            return np.stack(
                [(deeper - shallower) / (2 * plan.offset), (deeper + shallower - 2 * level) / (2 * plan.offset**2)]
            )

        return cls(
            plan,
            starts,
            np.array([[plays[Node(ratio, friction, 0.0)] for friction in plan.frictions] for ratio in plan.ratios]),
            np.array([over_offset(ratio, plan.frictions[mu_middle]) for ratio in plan.ratios]),
            np.array([over_offset(plan.ratios[nu_middle], friction) for friction in plan.frictions]),
        )

    @cached_property
    def _level_over_mu(self) -> PchipInterpolator:
        """Interpolation of ``level`` over mu."""
        return PchipInterpolator(self.plan.frictions, self.level, axis=1)

    @cached_property
    def _offset_over_mu(self) -> PchipInterpolator:
        """Interpolation of ``by_friction`` over mu."""
        return PchipInterpolator(self.plan.frictions, self.by_friction, axis=0)

    @property
    def counts(self) -> Indices:
        """Number of frames (t,) of each trajectory."""
        return np.diff(self.starts, append=self.level.shape[2])

    def at(self, ratio: float, friction: float) -> OffsetSeries:
        """Response at one nu and mu as a parabola over the offset, Young's modulus 1."""
        # effects of nu and of mu on slope and curvature add up; at the middle mu the correction is zero
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
        """Response of the trajectories at these places, in the order given."""
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
    """Lagrange weights (n,) of values at nodes (n,): their sum is the interpolating polynomial at ``place``."""
    gaps = nodes[:, None] - nodes
    np.fill_diagonal(gaps, 1.0)
    factors = np.broadcast_to(place - nodes, gaps.shape).copy()
    np.fill_diagonal(factors, 1.0)
    return factors.prod(axis=1) / gaps.prod(axis=1)

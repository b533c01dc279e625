"""Whether the zero of a force sensor wanders: a random walk, which follows neither time, gravity nor the joints.

A zero that wanders differs more between trajectories that lie further apart in time. The zeros of trajectories are
modelled as a line in time for each stretch between two tares, what gravity and the joints may do, white scatter, and a
random walk. The share of the walk maximises the restricted likelihood (Patterson and Thompson 1971).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices, Mask
from tactiledata.diagnose.zeros.readings import ForceZeros
from tactiledata.diagnose.zeros.zero_models import cable_shapes

SHARES = np.concatenate([[0.0], np.logspace(-2.0, 3.0, 31)])
"""Variances of the walk's step from one trajectory to the next that are tried, over that of the white scatter."""
DRAWS = 999
"""Permutations of trajectories in the test: the smallest p-value is 1 / 1000."""
LEVEL = 0.002
"""Largest p-value at which a walk is reported. Each diagnosis asks, and permutations of what a linear model leaves are
not quite as free as the zeros were."""
FEWEST_FREE = 8
"""Fewest trajectories beyond the columns of the model."""
NO_VARIANCE = 1e-30
"""Variance, N^2, of a component that always reads the same."""
CONSTANT = 1e-8
"""Size below which a direction of the model's unit columns counts as none."""


@dataclass(frozen=True)
class Wander:
    """A random walk of the zero's force.

    Parameters
    ----------
    p : float
        p-value by permutation of trajectories between two tares.
    explained : float
        Share of the squared errors with which zeros are predicted from all others that the walk takes away.
    before, after : float
        Root mean square of these errors, N, without and with the walk.
    walk : (3,) N/s^0.5
        Standard deviation of each component after 1 s.
    within : float
        Root mean square of the change of the force from the free air to the end of a trajectory, N.
    """

    p: float
    explained: float
    before: float
    after: float
    walk: Array
    within: float


@dataclass(frozen=True)
class _Walks:
    """The restricted likelihood of walks, for zeros that all have one linear model.

    Parameters
    ----------
    free : (m, t)
        Orthonormal combinations of the t trajectories that the linear model does not touch.
    turned : (m, m)
        The same combinations, turned to the axes of the walk's covariance.
    sizes : (m,)
        Variances of a walk along these axes, over that of its step from one trajectory to the next.
    """

    free: Array
    turned: Array
    sizes: Array

    def fitted(self, left: Array) -> tuple[float, float, Array]:
        """Return twice the gain of the log likelihood by a walk, its share, and the white variance of each component.

        Parameters
        ----------
        left : (m, 3) N
            Combinations of the zeros that the linear model does not touch.
        """
        spread = 1.0 + SHARES[:, None] * self.sizes
        white = np.einsum("sm,mk->sk", 1.0 / spread, (self.turned @ left) ** 2) / len(self.sizes)
        # the components have variances of their own, and one share
        costs = len(self.sizes) * np.log(np.maximum(white, NO_VARIANCE)).sum(axis=1) + white.shape[1] * np.log(
            spread
        ).sum(axis=1)
        best = int(np.argmin(costs))
        return float(costs[0] - costs[best]), float(SHARES[best]), white[best]


def wandering_zero(zeros: ForceZeros, times: Sequence[float] = (), seed: int = 0) -> Wander | None:
    """Return the random walk of the zeros' force; ``None`` where none is certain, where trajectories are few, or where
    the sensor is tared before each of them.

    Parameters
    ----------
    zeros : ForceZeros
        Mean readings in free air, as `StoreReadings.zeros` returns them.
    times : sequence of float
        Time constants, s, of drifts since power-on that the zeros may follow as well.
    seed : int
        Random seed of the permutations.
    """
    owner, first = np.unique(zeros.trajectory, return_index=True)
    tares = zeros.zeroed[first]
    # a trajectory that was tared in free air counts with what it read before
    is_of = ((zeros.trajectory == owner[:, None]) & (zeros.zeroed == tares[:, None])).astype(np.float64)
    is_of /= is_of.sum(axis=1)[:, None]
    force, seconds, remaining = is_of @ zeros.load[:, :3], is_of @ zeros.seconds, is_of @ zeros.remaining
    together = tares[:, None] == np.unique(tares)
    cable = None if zeros.joints is None else is_of @ cable_shapes(zeros)
    design = _design(is_of @ zeros.down, cable, seconds, together, times)
    step, covariance = _walk_covariance(seconds, together)
    basis, sizes, _ = np.linalg.svd(design)
    rank = int((sizes > CONSTANT * sizes[0]).sum())
    if len(owner) - rank < FEWEST_FREE or step == 0.0:
        return None
    free = basis[:, rank:].T
    variances, axes = np.linalg.eigh(free @ covariance @ free.T)
    walks = _Walks(free, axes.T, np.maximum(variances, 0.0))
    left = free @ force
    gain, share, white = walks.fitted(left)
    if share == 0.0:
        return None
    p = _exchanged(walks, left, gain, together, seed)
    if p > LEVEL:
        return None
    before, after = (_unseen(design, np.eye(len(owner)) + one * covariance, force) for one in (0.0, share))
    walk = np.sqrt(share * white / step)
    within = float(np.sqrt((walk**2).sum() * remaining.mean()))
    return Wander(p, max(0.0, 1.0 - (after / before) ** 2), before, after, walk, within)


def _design(down: Array, cable: Array | None, seconds: Array, together: Mask, times: Sequence[float]) -> Array:
    """Return unit columns (t, k): a line in time for each stretch between two tares, drifts since power-on, gravity,
    and, where joints are known, what the pull of a cable follows.
    """
    stretches = together.astype(np.float64)
    columns = [stretches, stretches * (seconds - seconds.mean())[:, None], down]
    columns += [np.exp(-seconds / time)[:, None] for time in times]
    if cable is not None:
        columns.append(cable)
    design = np.hstack(columns)
    lengths: Array = np.linalg.norm(design, axis=0)
    return design / np.where(lengths > 0, lengths, 1.0)


def _walk_covariance(seconds: Array, together: Mask) -> tuple[float, Array]:
    """Return the usual time between two trajectories, s, and the covariance (t, t) of walks that begin with the first
    trajectory of each stretch, over the variance of a step of that time; a time of 0 where each stretch has one.
    """
    covariance, steps = np.zeros((len(seconds), len(seconds))), [np.empty(0)]
    for members in together.T:
        since = seconds[members] - seconds[members].min()
        covariance[np.ix_(members, members)] = np.minimum(since[:, None], since)
        steps.append(np.diff(np.sort(since)))
    joined = np.concatenate(steps)
    step = float(np.median(joined)) if len(joined) else 0.0
    return step, covariance / step if step > 0.0 else covariance


def _exchanged(walks: _Walks, left: Array, gain: float, together: Mask, seed: int) -> float:
    """Return the share of permutations, within stretches, of what the linear model leaves that gain as much."""
    rng = np.random.default_rng(seed)
    residual, count = walks.free.T @ left, 0
    stretches: list[Indices] = [np.flatnonzero(members) for members in together.T]
    for _ in range(DRAWS):
        drawn = residual.copy()
        for members in stretches:
            drawn[members] = residual[rng.permutation(members)]
        count += walks.fitted(walks.free @ drawn)[0] >= gain
    return (count + 1) / (DRAWS + 1)


def _unseen(design: Array, covariance: Array, force: Array) -> float:
    """Return the root mean square, N, of the errors with which each zero is predicted from all others."""
    inverse = np.linalg.inv(covariance)
    weighted = inverse @ design
    hat: Array = inverse - weighted @ np.linalg.pinv(design.T @ weighted) @ weighted.T
    errors = (hat @ force) / np.maximum(np.diag(hat), 1e-12)[:, None]
    return float(np.sqrt((errors**2).sum(axis=1).mean()))

"""Scores in the metric that offsets, numerical errors and a refit of shared parameters leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array, Indices


@dataclass(frozen=True)
class RandomEffects:
    """Normal errors of trajectories and of all of them: the covariance I + a aᵀ by trajectory + C diag(v) Cᵀ.

    Parameters
    ----------
    own : (N, 6)
        What one standard deviation of a trajectory's offset changes; 0 where there is none.
    shared : (N, 6, m)
        What one unit of each shared parameter changes.
    precision : (m,)
        Of those parameters' priors; 0 where there is none: such a direction is no evidence.
    starts : (t,)
        First row of each trajectory.
    """

    own: Array
    shared: Array
    precision: Array
    starts: Indices

    @cached_property
    def _share(self) -> Array:
        return 1.0 / (1.0 + self._sum(np.einsum("nk,nk->n", self.own, self.own)))

    @cached_property
    def _trajectory(self) -> Indices:
        return np.repeat(np.arange(len(self.starts)), np.diff(self.starts, append=len(self.own)))

    def _sum(self, rows: Array) -> Array:
        return np.add.reduceat(rows, self.starts, axis=0)

    def without_own(self, field: Array) -> Array:
        """A field (N, 6, c) times the inverse covariance of noise and offsets."""
        inside = self._sum(np.einsum("nk,nkc->nc", self.own, field)) * self._share[:, None]
        return field - self.own[:, :, None] * inside[self._trajectory][:, None, :]

    @cached_property
    def _held(self) -> Array:
        return self.without_own(self.shared)

    @cached_property
    def _inverse(self) -> Array:
        gram = np.einsum("nkp,nkq->pq", self.shared, self._held) + np.diag(self.precision)
        scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
        inverse: Array = np.linalg.pinv(gram / np.outer(scale, scale), rcond=1e-10, hermitian=True)
        return inverse / np.outer(scale, scale)

    def weigh(self, field: Array) -> Array:
        """A field (N, 6, c) times the inverse of the whole covariance."""
        if not self.shared.shape[2]:
            return self.without_own(field)
        told = np.einsum("nkp,nkc->pc", self._held, field)
        return self.without_own(field) - np.einsum("nkp,pc->nkc", self._held, self._inverse @ told)

    def products(self, field: Array, other: Array) -> Array:
        """Products (c, d) of fields (N, 6, c) and (N, 6, d) in this metric."""
        return np.einsum("nkc,nkd->cd", field, self.weigh(other), optimize=True)

    def cost(self, residual: Array) -> float:
        """Square of a residual (N, 6) in this metric."""
        return float(self.products(residual[:, :, None], residual[:, :, None])[0, 0])


def cosines(metric: RandomEffects, fields: Sequence[Array]) -> Array:
    """Cosines (k, k) of fields (N, 6) in the metric; 0 where nothing of one is left."""
    stacked = np.stack(fields, axis=2)
    together = metric.products(stacked, stacked)
    size = np.sqrt(np.maximum(np.diag(together), 1e-300))
    return np.clip(together / np.outer(size, size), -1.0, 1.0)


def best_imitation(metric: RandomEffects, field: Array, others: Array) -> float:
    """Cosine of a field (N, 6) with the nearest of all that fields (N, 6, p) can make together."""
    inner = metric.products(others, others)
    toward = metric.products(others, field[:, :, None])[:, 0]
    size = float(metric.products(field[:, :, None], field[:, :, None])[0, 0])
    if not size > 0:
        return 0.0
    scale = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    strengths = np.linalg.pinv(inner / np.outer(scale, scale), rcond=1e-8, hermitian=True) @ (toward / scale)
    return float(np.sqrt(np.clip(strengths @ (toward / scale) / size, 0.0, 1.0)))

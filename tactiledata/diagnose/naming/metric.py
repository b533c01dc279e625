"""The metric in which whitened fields are compared: what offsets, numerical errors and refits can imitate counts as 0.

A field is what something changes in the whitened wrenches of all frames, (N, 6). The product of two fields u and v is
uᵀ M v with M the inverse of the covariance I + a aᵀ (one such term a trajectory) + C diag(1/p) Cᵀ. Directions C with a
small precision p, as of a parameter that a refit is free to move, carry no information in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.diagnose.residuals.scaled_matrix import scaled_matrix
from tactiledata.diagnose.residuals.scores import cosines_of


@dataclass(frozen=True)
class RandomEffects:
    """Covariance of whitened frames: unit noise, one random offset a trajectory, and parameters that all share.

    Parameters
    ----------
    own : (N, 6)
        Change over one standard deviation of the offset of the row's trajectory; 0 where there is none.
    shared : (N, 6, m)
        Change over one unit of each shared parameter.
    precision : (m,)
        Inverse variance of each shared parameter's prior; 0 where there is no prior, so that a change in its direction
        counts as 0.
    starts : (t,)
        First row of each trajectory.
    """

    own: Array
    shared: Array
    precision: Array
    starts: Indices

    @cached_property
    def _share(self) -> Array:
        """Factor (t,) 1 / (1 + aᵀa) of the inverse covariance of each trajectory's noise and offset."""
        return 1.0 / (1.0 + self._sum(np.einsum("nk,nk->n", self.own, self.own)))

    @cached_property
    def _trajectory(self) -> Indices:
        """Trajectory of each row (N,)."""
        return np.repeat(np.arange(len(self.starts)), np.diff(self.starts, append=len(self.own)))

    def _sum(self, rows: Array) -> Array:
        """Sums (t, ...) of rows (N, ...) over each trajectory."""
        return np.add.reduceat(rows, self.starts, axis=0)

    def without_own(self, field: Array) -> Array:
        """Return fields (N, 6, c) times the inverse covariance of noise and offsets alone (Sherman and Morrison)."""
        inside = self._sum(np.einsum("nk,nkc->nc", self.own, field)) * self._share[:, None]
        return field - self.own[:, :, None] * inside[self._trajectory][:, None, :]

    @cached_property
    def _shared_without_own(self) -> Array:
        """Shared fields (N, 6, m) times the inverse covariance of noise and offsets."""
        return self.without_own(self.shared)

    @cached_property
    def _inverse(self) -> Array:
        """Posterior covariance (m, m) of the shared parameters; directions without information and prior are 0."""
        gram = np.tensordot(self.shared, self._shared_without_own, axes=([0, 1], [0, 1])) + np.diag(self.precision)
        # with the diagonal scaled to 1, the cut-off of the pseudo-inverse does not depend on the parameters' units
        return scaled_matrix(gram).pseudo_inverse(1e-10)

    def weigh(self, field: Array) -> Array:
        """Return fields (N, 6, c) times the inverse of the whole covariance (Woodbury's identity)."""
        if not self.shared.shape[2]:
            return self.without_own(field)
        onto_shared = np.tensordot(self._shared_without_own, field, axes=([0, 1], [0, 1]))
        return self.without_own(field) - self._shared_without_own @ (self._inverse @ onto_shared)

    def products(self, field: Array, other: Array) -> Array:
        """Return products (c, d) of fields (N, 6, c) with fields (N, 6, d) in the metric."""
        found: Array = np.tensordot(field, self.weigh(other), axes=([0, 1], [0, 1]))
        return found

    def cost(self, residual: Array) -> float:
        """Return the square of a residual (N, 6) in the metric."""
        return float(self.products(residual[:, :, None], residual[:, :, None])[0, 0])


def cosines(metric: RandomEffects, fields: Sequence[Array]) -> Array:
    """Return the cosines (k, k) of the angles between k fields in the metric, at least one field.

    A field that the shared parameters imitate, up to rounding, has no direction of its own: its cosines are 0, also
    that with itself (`cosines_of`).

    Parameters
    ----------
    metric : RandomEffects
        Metric of the cosines.
    fields : sequence of k (N, 6)
        Whitened changes of the wrench.
    """
    stacked = np.stack(fields, axis=2)
    products = metric.products(stacked, stacked)
    return cosines_of(products, (stacked**2).sum(axis=(0, 1)))


def best_imitation(metric: RandomEffects, field: Array, others: Array) -> float:
    """Return the cosine, 0 to 1, of a field with the nearest linear combination of other fields, in the metric.

    Parameters
    ----------
    metric : RandomEffects
        Metric of the cosine.
    field : (N, 6)
        Field that is imitated.
    others : (N, 6, p)
        Fields that are combined.
    """
    inner = metric.products(others, others)
    toward = metric.products(others, field[:, :, None])[:, 0]
    size = float(metric.products(field[:, :, None], field[:, :, None])[0, 0])
    if not size > 0:
        return 0.0
    scaled = scaled_matrix(inner)
    strengths = np.linalg.pinv(scaled.values, rcond=1e-8, hermitian=True) @ (toward / scaled.scale)
    return float(np.sqrt(np.clip(strengths @ (toward / scaled.scale) / size, 0.0, 1.0)))

"""A residual without what each trajectory's own parameters and a refit of the shared ones can take from it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.residuals import Residuals

ANY = 1e6
"""Standard deviations of noise that a parameter without prior may move a frame by."""
SINGULAR = 1e-10
"""Of the largest eigenvalue: directions below it are no directions."""


@dataclass(frozen=True)
class ProjectedResiduals:
    """Residuals after own parameters are marginalised and shared ones refitted, in the metric that this leaves.

    A parameter b ~ N(0, v) of one trajectory, with sensitivities s, is the same as the covariance ``I + v s sᵀ`` over
    its frames; its inverse is ``I - B Bᵀ``. Shared parameters are refitted linearly, so that scores are orthogonal to
    them: what a refit could take away is no evidence.

    Parameters
    ----------
    residuals : Residuals
    basis : (n, k, o)
        B of each frame's trajectory.
    directions : (n, k, p)
        Sensitivities of the shared parameters.
    weighed : (n, k, p)
        The same, times the inverse covariance.
    inverse : (p, p)
        Inverse of ``directionsᵀ weighed``.
    refit : (p,)
        By how much the shared parameters move.
    left : (n, k)
        Residual after the refit.
    score : (n, k)
        The same, times the inverse covariance: what is left when each trajectory's own parameters, too, are at their
        most likely values.
    """

    residuals: Residuals
    basis: Array
    directions: Array
    weighed: Array
    inverse: Array
    refit: Array
    left: Array
    score: Array

    def weigh(self, field: Array) -> Array:
        """A field (n, k, …) times the inverse covariance."""
        return _weigh(self.basis, self.residuals, field)

    def orthogonal(self, field: Array) -> Array:
        """A field (n, k, c) without what the shared parameters can imitate."""
        together = np.einsum("nkp,nkc->pc", self.weighed, field)
        return field - np.einsum("nkp,pc->nkc", self.directions, self.inverse @ together)

    def information(self, place: int) -> Array:
        """What each frame (n,) tells of one of the shared parameters, as a weight."""
        told: Array = np.einsum("nk,nk->n", self.directions[:, :, place], self.weighed[:, :, place])
        return np.maximum(told, 0.0)

    def dot(self, field: Array, other: Array) -> Array:
        """Products (u, c) over each unit of exchange of fields (n, k, c), the second weighed."""
        return self.residuals.by_unit(np.einsum("nkc,nkc->nc", field, other))


def project(residuals: Residuals) -> ProjectedResiduals:
    """The projection of residuals."""
    shared = list(residuals.shared)
    own = [place for place in range(len(residuals.parameters)) if place not in shared]
    basis = _own_basis(residuals, own)
    directions = residuals.slopes[:, :, shared]
    weighed = _weigh(basis, residuals, directions)
    gram = np.einsum("nkp,nkq->pq", directions, weighed)
    inverse = _pseudo_inverse(gram)
    weighed_values = _weigh(basis, residuals, residuals.values)
    refit = inverse @ np.einsum("nkp,nk->p", directions, weighed_values)
    left = residuals.values - directions @ refit
    score = weighed_values - weighed @ refit
    return ProjectedResiduals(residuals, basis, directions, weighed, inverse, refit, left, score)


def _pseudo_inverse(gram: Array) -> Array:
    if not gram.size:
        return gram
    scale = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    inverse: Array = np.linalg.pinv(gram / np.outer(scale, scale), rcond=SINGULAR, hermitian=True)
    return inverse / np.outer(scale, scale)


def _own_basis(residuals: Residuals, own: list[int]) -> Array:
    rows, width = residuals.values.shape
    basis = np.zeros((rows, width, len(own)))
    if not own:
        return basis
    slopes = residuals.slopes[:, :, own]
    size = np.maximum(np.sqrt(np.mean(slopes**2, axis=(0, 1))), 1e-300)
    priors = [residuals.parameters[place].own_deviation or 0.0 for place in own]
    deviations = np.array(
        [prior if np.isfinite(prior) else ANY / each for prior, each in zip(priors, size, strict=True)]
    )
    for start, count in zip(residuals.starts, residuals.counts, strict=True):
        rows_of = slice(start, start + count)
        block = (slopes[rows_of] * deviations).reshape(count * width, len(own))
        left, values, _ = np.linalg.svd(block, full_matrices=False)
        factors = left * (values / np.sqrt(1.0 + values**2))
        basis[rows_of, :, : factors.shape[1]] = factors.reshape(count, width, -1)
    return basis


def _weigh(basis: Array, residuals: Residuals, field: Array) -> Array:
    if not basis.shape[2]:
        return field
    flat = field.reshape(*field.shape[:2], -1)
    inside = np.add.reduceat(np.einsum("nko,nkc->noc", basis, flat), residuals.starts, axis=0)
    taken = np.einsum("nko,noc->nkc", basis, inside[residuals.trajectory])
    return (flat - taken).reshape(field.shape)

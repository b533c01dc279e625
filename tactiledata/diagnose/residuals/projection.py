"""Residuals after own parameters of trajectories are marginalised and the shared parameters are refitted linearly."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.scaled_matrix import scaled_matrix

ANY = 1e6
"""Prior standard deviation of a parameter without prior, in noise standard deviations of a typical frame."""
SINGULAR = 1e-10
"""Eigenvalues of the scaled information matrix below this share of the largest one count as 0."""


@dataclass(frozen=True)
class ProjectedResiduals:
    """Residuals of n frames and k components after own parameters are marginalised and shared ones refitted.

    A parameter b ~ N(0, v) of one trajectory, with sensitivities s, adds ``v s sᵀ`` to the covariance of its frames.
    The inverse of ``I + v s sᵀ`` is ``I - B Bᵀ``. Shared parameters are refitted linearly, so that scores are
    orthogonal to them: what a refit could absorb is no evidence.

    Parameters
    ----------
    residuals : Residuals
        What was projected.
    basis : (n, k, o)
        B of each frame's trajectory, one column for each of o own parameters.
    directions : (n, k, p)
        Sensitivities of the p shared parameters, in the order of `Residuals.shared`.
    weighed : (n, k, p)
        ``directions`` times the inverse covariance.
    inverse : (p, p)
        Pseudo-inverse of the information matrix ``directionsᵀ weighed``.
    refit : (p,)
        Shift of each shared parameter in the refit, in the parameter's unit.
    left : (n, k)
        Whitened residual after the refit.
    score : (n, k)
        ``left`` times the inverse covariance: the residual when each trajectory's own parameters are at their most
        likely values, too.
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
        """Return the product of the inverse covariance and a field (n, k, …)."""
        return _weigh(self.basis, self.residuals, field)

    def orthogonal(self, field: Array) -> Array:
        """Return the part of a field (n, k, c) that is orthogonal to all shared parameters."""
        together = np.einsum("nkp,nkc->pc", self.weighed, field)
        return field - np.einsum("nkp,pc->nkc", self.directions, self.inverse @ together)

    @cached_property
    def score_with_priors(self) -> Array:
        """``score`` (n, k) if shared parameters are refitted under their priors.

        A free refit fits noise with parameters that priors hold near 0, and the trajectories' own parameters make up
        for it.
        """
        shared = [self.residuals.parameters[place] for place in self.residuals.shared]
        precision = np.array([parameter.prior_deviation for parameter in shared]) ** -2.0
        values = self.weigh(self.residuals.values)
        gram = np.einsum("nkp,nkq->pq", self.directions, self.weighed)
        found = _pseudo_inverse(gram + np.diag(precision)) @ np.einsum("nkp,nk->p", self.directions, values)
        return values - self.weighed @ found

    @cached_property
    def score_by_unit(self) -> Array:
        """Score (u, p) of each unit of exchange for each shared parameter."""
        return self.residuals.by_unit(np.einsum("nkp,nk->np", self.directions, self.score))

    @cached_property
    def information_by_unit(self) -> Array:
        """Information matrix (u, p, p) of each unit of exchange on the shared parameters."""
        count = self.directions.shape[2]
        pairs = zip(self.directions.transpose(1, 0, 2), self.weighed.transpose(1, 0, 2), strict=True)
        of_components = [self.residuals.products(direction, weighed) for direction, weighed in pairs]
        return self.residuals.units_of(sum(of_components, np.zeros((len(self.residuals.starts), count, count))))

    def information(self, place: int) -> Array:
        """Return Fisher information (n,) of each frame on a shared parameter, by its place in `Residuals.shared`."""
        weights: Array = np.einsum("nk,nk->n", self.directions[:, :, place], self.weighed[:, :, place])
        return np.maximum(weights, 0.0)

    def dot(self, field: Array, other: Array) -> Array:
        """Return inner products (u, c) of two fields (n, k, c) in each unit of exchange; weigh one of them before."""
        return self.residuals.by_unit(np.einsum("nkc,nkc->nc", field, other))


def project(residuals: Residuals) -> ProjectedResiduals:
    """Marginalise each trajectory's own parameters, refit the shared ones linearly, and return the projection."""
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
    """Return the pseudo-inverse (p, p) of an information matrix, its rows scaled as parameters differ in unit."""
    if not gram.size:
        return gram
    return scaled_matrix(gram).pseudo_inverse(SINGULAR)


def _own_basis(residuals: Residuals, own: list[int]) -> Array:
    """Return B (n, k, o) of the own parameters at the places ``own``: ``I - B Bᵀ`` is the inverse covariance."""
    rows, width = residuals.values.shape
    basis = np.zeros((rows, width, len(own)))
    if not own:
        return basis
    slopes = residuals.slopes[:, :, own]
    size = np.maximum(np.sqrt(np.mean(slopes**2, axis=(0, 1))), 1e-300)
    priors = [residuals.parameters[place].own_deviation or 0.0 for place in own]
    deviations = np.array(
        [prior if np.isfinite(prior) else ANY / effect_size for prior, effect_size in zip(priors, size, strict=True)]
    )
    # one singular value decomposition for each trajectory
    for start, count in zip(residuals.starts, residuals.counts, strict=True):
        members = slice(start, start + count)
        block = (slopes[members] * deviations).reshape(count * width, len(own))
        left, values, _ = np.linalg.svd(block, full_matrices=False)
        factors = left * (values / np.sqrt(1.0 + values**2))
        basis[members, :, : factors.shape[1]] = factors.reshape(count, width, -1)
    return basis


def _weigh(basis: Array, residuals: Residuals, field: Array) -> Array:
    """Return the field (n, k, …) times ``I - B Bᵀ`` of each trajectory."""
    if not basis.shape[2]:
        return field
    flat = field.reshape(*field.shape[:2], -1)
    inside = np.add.reduceat(np.einsum("nko,nkc->noc", basis, flat), residuals.starts, axis=0)
    taken = np.einsum("nko,noc->nkc", basis, inside[residuals.trajectory])
    return (flat - taken).reshape(field.shape)

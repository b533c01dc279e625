"""Whether there is anything to explain at all, beside noise, own parameters and the simulation's own errors.

The residual is compared with residuals drawn from the noise model, the numerical discrepancy, and the doubt about the
size of the noise, each put through the same projection. Two numbers are compared: the mean square, and the share of
slow variation inside trajectories, which no error in the size of the noise can raise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.wording import p_words, rounded

DRAWS = 399
CHUNK = 16
SLOW = 3
"""Cosines, from the constant on, that count as slow."""


@dataclass(frozen=True)
class NoiseModel:
    """What a residual may be when nothing is missing.

    Parameters
    ----------
    correlation : float, optional
        Of neighbouring frames of one trajectory, as in an AR(1) process; ``None``: not known, and slow variation
        proves nothing.
    doubt : float
        Relative standard deviation of the noise's size: how well it is known.
    discrepancy : (n, k, m), optional
        Whitened differences between a refined simulation and the one used: each comes with a normal factor of its own.
    scatter : (n,), optional
        Share of each frame's standard deviation, 0 to 1, that is no noise but scatter of the simulation: it goes slowly
        along a trajectory, and as slowly as can be counts as usual.
    """

    correlation: float | None = 0.0
    doubt: float = 0.05
    discrepancy: Array | None = None
    scatter: Array | None = None

    @property
    def inflation(self) -> float | None:
        """Of the variance of sums over neighbouring frames, by their memory; ``None`` where that is not known."""
        return None if self.correlation is None else (1.0 + self.correlation) / (1.0 - self.correlation)


@dataclass(frozen=True)
class Gate:
    """The answer.

    Parameters
    ----------
    mean_square, slow_share : float
        Of the residual.
    usual_mean_square, usual_slow_share : float
        95 % quantiles where nothing is missing.
    p : float
        For both together.
    words : str
    """

    mean_square: float
    slow_share: float
    usual_mean_square: float
    usual_slow_share: float
    p: float
    words: str

    @property
    def is_passed(self) -> bool:
        """Whether nothing needs an explanation."""
        return self.p > 0.05


def gate(projection: ProjectedResiduals, noise: NoiseModel, seed: int = 0, draws: int = DRAWS) -> Gate:
    """The gate for residuals whose noise is known."""
    residuals = projection.residuals
    rng = np.random.default_rng(seed)
    slow = _slow_basis(residuals)
    observed = _numbers(projection, slow, residuals.values[:, :, None])[:, 0]
    drawn = np.concatenate(
        [
            _numbers(projection, slow, _draws(residuals, noise, rng, min(CHUNK, draws - start)))
            for start in range(0, draws, CHUNK)
        ],
        axis=1,
    )
    each = (1 + (drawn >= observed[:, None]).sum(axis=1)) / (1 + draws)
    p = float(each[0] if noise.correlation is None else min(1.0, 2.0 * each.min()))
    usual = np.quantile(drawn, 0.95, axis=1)
    if p > 0.05:
        words = f"Nothing needs an explanation: the residual is what noise leaves ({p_words(p)})."
    elif noise.correlation is None or each[0] <= each[1]:
        words = (
            f"The residual is {rounded(float(np.sqrt(observed[0])))} times the noise, where up to "
            f"{rounded(float(np.sqrt(usual[0])))} is usual ({p_words(p)})."
        )
    else:
        words = (
            f"The residual is slower than noise: {100 * observed[1]:.0f} % of it is slow variation inside "
            f"trajectories, where up to {100 * usual[1]:.0f} % is usual ({p_words(p)})."
        )
    return Gate(float(observed[0]), float(observed[1]), float(usual[0]), float(usual[1]), p, words)


def _draws(residuals: Residuals, noise: NoiseModel, rng: np.random.Generator, draws: int) -> Array:
    """Residuals (n, k, d) where nothing is missing."""
    values = rng.normal(size=(*residuals.values.shape, draws))
    if noise.correlation:
        fresh = np.sqrt(1.0 - noise.correlation**2)
        for later in range(1, int(residuals.counts.max())):
            rows = residuals.starts[residuals.counts > later] + later
            values[rows] = noise.correlation * values[rows - 1] + fresh * values[rows]
    values *= np.maximum(rng.normal(1.0, noise.doubt, draws), 0.1)
    if noise.scatter is not None:
        share = noise.scatter[:, None, None]
        values = np.sqrt(1.0 - share**2) * values + share * _slow_draws(residuals, rng, draws)
    if noise.discrepancy is not None:
        values += noise.discrepancy @ rng.normal(size=(noise.discrepancy.shape[2], draws))
    for place, parameter in enumerate(residuals.parameters):
        if parameter.own_deviation is not None and np.isfinite(parameter.own_deviation):
            own = rng.normal(0.0, parameter.own_deviation, (len(residuals.starts), draws))
            values += residuals.slopes[:, :, place, None] * own[residuals.trajectory][:, None, :]
    return values


def _slow_draws(residuals: Residuals, rng: np.random.Generator, draws: int) -> Array:
    """Values (n, k, d) of unit variance in the mean that are slow in each trajectory, and nothing else."""
    shape = (len(residuals.starts), SLOW, residuals.values.shape[1], draws)
    waves = (
        _slow_basis(residuals)
        * np.sqrt(residuals.counts / np.minimum(residuals.counts, SLOW))[residuals.trajectory, None]
    )
    drawn: Array = np.einsum("ns,nskd->nkd", waves, rng.normal(size=shape)[residuals.trajectory], optimize=True)
    return drawn


def _numbers(projection: ProjectedResiduals, slow: Array, values: Array) -> Array:
    """Mean square and slow share (2, d) of residuals (n, k, d) after the projection."""
    weighed = projection.weigh(values)
    refit = np.einsum("pq,nkq,nkd->pd", projection.inverse, projection.directions, weighed, optimize=True)
    left = values - np.einsum("nkp,pd->nkd", projection.directions, refit)
    score = weighed - np.einsum("nkp,pd->nkd", projection.weighed, refit)
    size = values.shape[0] * values.shape[1]
    square = np.einsum("nkd,nkd->d", left, score) / size
    inside = np.add.reduceat(np.einsum("ns,nkd->nskd", slow, score), projection.residuals.starts, axis=0)
    whole = np.einsum("nkd,nkd->d", score, score)
    return np.stack([square, (inside**2).sum(axis=(0, 1, 2)) / np.maximum(whole, 1e-300)])


def _slow_basis(residuals: Residuals) -> Array:
    """Orthonormal slow cosines (n, s) of each trajectory."""
    basis = np.zeros((len(residuals.values), SLOW))
    for start, count in zip(residuals.starts, residuals.counts, strict=True):
        phase = np.pi * (np.arange(count) + 0.5) / count
        for order in range(min(SLOW, count)):
            wave = np.cos(order * phase)
            basis[start : start + count, order] = wave / np.linalg.norm(wave)
    return basis

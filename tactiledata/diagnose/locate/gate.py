"""Whether the residual exceeds what noise, own parameters and errors of the simulation leave.

The residual is compared with simulated ones, drawn from the noise model, the numerical discrepancy and the uncertainty
of the noise's size, and projected in the same way. Two statistics are compared: the mean square, and the share of slow
variation inside trajectories. A wrong size of the noise cannot raise the second one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.wording import p_words, rounded

DRAWS = 399
"""Simulated residuals: the smallest p-value is 1 / 400."""
CHUNK = 16
"""Simulated residuals that are held in memory at a time."""
SLOW = 3
"""Number of cosines of each trajectory, the constant included, that count as slow variation."""


@dataclass(frozen=True)
class NoiseModel:
    """The distribution of the residual when no physics is missing.

    Parameters
    ----------
    correlation : float, optional
        Correlation of the noise of neighbouring frames of a trajectory, as in an AR(1) process. ``None``: not known;
        slow variation is then not tested.
    doubt : float
        Relative standard deviation of the noise's size: how uncertain it is.
    discrepancy : (n, k, m), optional
        m whitened differences between a refined simulation and the one used; each is multiplied by an independent
        standard normal number.
    scatter : (n,), optional
        Share of each frame's standard deviation, 0 to 1, that is scatter of the simulation instead of noise. It varies
        slowly along a trajectory; the draws make it as slow as possible.
    """

    correlation: float | None = 0.0
    doubt: float = 0.05
    discrepancy: Array | None = None
    scatter: Array | None = None

    @property
    def inflation(self) -> float | None:
        """Factor on the variance of sums over frames, by their correlation; ``None`` where that is not known."""
        return None if self.correlation is None else (1.0 + self.correlation) / (1.0 - self.correlation)


@dataclass(frozen=True)
class Gate:
    """Mean square and slow share of the residual, compared with their distribution when no physics is missing.

    Parameters
    ----------
    mean_square, slow_share : float
        Statistics of the residual after the projection; the mean square of white noise is about 1.
    usual_mean_square, usual_slow_share : float
        95 % quantiles of the statistics when no physics is missing.
    p : float
        p-value of both statistics together (Bonferroni), or of the mean square where slow variation is not tested.
    words : str
        The result as a sentence.
    """

    mean_square: float
    slow_share: float
    usual_mean_square: float
    usual_slow_share: float
    p: float
    words: str

    @property
    def is_passed(self) -> bool:
        """Whether the residual is compatible with noise at the 5 % level."""
        return self.p > 0.05


def gate(projection: ProjectedResiduals, noise: NoiseModel, seed: int = 0, draws: int = DRAWS) -> Gate:
    """Return whether a residual exceeds residuals that are simulated without missing physics, with a p-value.

    The locators run whatever the result is; `locate` corrects its p-value together with theirs.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    noise : NoiseModel
        Distribution of the residual when no physics is missing.
    seed : int
        Random seed of the simulated residuals.
    draws : int
        Number of simulated residuals.
    """
    residuals = projection.residuals
    rng = np.random.default_rng(seed)
    slow = _slow_basis(residuals)
    observed = _statistics(projection, slow, residuals.values[:, :, None])[:, 0]
    drawn = np.concatenate(
        [
            _statistics(projection, slow, _draws(residuals, noise, rng, min(CHUNK, draws - start)))
            for start in range(0, draws, CHUNK)
        ],
        axis=1,
    )
    # one p-value for each statistic; without a known correlation only the mean square counts
    p_values = (1 + (drawn >= observed[:, None]).sum(axis=1)) / (1 + draws)
    p = float(p_values[0] if noise.correlation is None else min(1.0, 2.0 * p_values.min()))
    usual = np.quantile(drawn, 0.95, axis=1)
    if p > 0.05:
        words = f"Nothing needs an explanation: the residual is no larger than noise alone would be ({p_words(p)})."
    elif noise.correlation is None or p_values[0] <= p_values[1]:
        words = (
            f"The residual is {rounded(float(np.sqrt(observed[0])))} times the noise, where up to "
            f"{rounded(float(np.sqrt(usual[0])))} is usual ({p_words(p)})."
        )
    else:
        words = (
            f"The residual varies more slowly than noise: {100 * observed[1]:.0f} % of it is slow variation inside "
            f"trajectories, where up to {100 * usual[1]:.0f} % is usual ({p_words(p)})."
        )
    return Gate(float(observed[0]), float(observed[1]), float(usual[0]), float(usual[1]), p, words)


def _draws(residuals: Residuals, noise: NoiseModel, rng: np.random.Generator, draws: int) -> Array:
    """Return simulated whitened residuals (n, k, d) when no physics is missing.

    Parameters
    ----------
    residuals : Residuals
        Shapes, trajectories and own parameters of the residuals.
    noise : NoiseModel
        Distribution of the noise and of errors of the simulation.
    rng : numpy.random.Generator
        Source of random numbers.
    draws : int
        Number d of simulated residuals.
    """
    # white noise, made an AR(1) process along each trajectory
    values = rng.normal(size=(*residuals.values.shape, draws))
    if noise.correlation:
        fresh = np.sqrt(1.0 - noise.correlation**2)
        for frame in range(1, int(residuals.counts.max())):
            rows = residuals.starts[residuals.counts > frame] + frame
            values[rows] = noise.correlation * values[rows - 1] + fresh * values[rows]
    # uncertain size of the noise, then scatter, discrepancy and own parameters
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
    """Return random values (n, k, d) that are sums of slow cosines in each trajectory, with a mean variance of 1."""
    shape = (len(residuals.starts), SLOW, residuals.values.shape[1], draws)
    waves = (
        _slow_basis(residuals)
        * np.sqrt(residuals.counts / np.minimum(residuals.counts, SLOW))[residuals.trajectory, None]
    )
    drawn: Array = np.einsum("ns,nskd->nkd", waves, rng.normal(size=shape)[residuals.trajectory], optimize=True)
    return drawn


def _statistics(projection: ProjectedResiduals, slow: Array, values: Array) -> Array:
    """Return the mean square and slow share (2, d) of residuals (n, k, d) after the projection.

    Parameters
    ----------
    projection : ProjectedResiduals
        The projection that is applied to each residual.
    slow : (n, s)
        Orthonormal slow functions of each trajectory.
    values : (n, k, d)
        Whitened residuals, observed or simulated.
    """
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
    """Return the orthonormal slow cosines (n, s) of each trajectory; columns beyond its number of frames are 0."""
    basis = np.zeros((len(residuals.values), SLOW))
    for start, count in zip(residuals.starts, residuals.counts, strict=True):
        phase = np.pi * (np.arange(count) + 0.5) / count
        for order in range(min(SLOW, count)):
            wave = np.cos(order * phase)
            basis[start : start + count, order] = wave / np.linalg.norm(wave)
    return basis

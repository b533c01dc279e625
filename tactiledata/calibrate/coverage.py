"""How often the intervals hold the truth, on surrogate data drawn from a response that is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.intervals import intervals_hold
from tactiledata.calibrate.least_squares import polish
from tactiledata.calibrate.losses import VectorLoss
from tactiledata.nuisance.tare import tare_variance


@dataclass(frozen=True)
class Coverage:
    """What was counted.

    Parameters
    ----------
    share : (3,)
        Of the data sets whose interval of E, nu and mu holds the truth.
    estimates : (draws, 3)
    """

    share: Array
    estimates: Array


def coverage(loss: VectorLoss, bounds: Bounds, truth: Array, draws: int = 200, seed: int = 0) -> Coverage:
    """Coverage of the 95 % intervals at a truth (3,): noise, zeros, offsets and factors are drawn anew, the plays
    are not.
    """
    chance = np.random.default_rng([seed, 3])
    covered = np.zeros(3)
    estimates = np.empty((draws, 3))
    for draw in range(draws):
        one = loss.with_measured(surrogate(loss, truth, chance))
        estimates[draw] = bounds.scaled(polish(one, bounds, bounds.shares(truth)).shares)
        covered += intervals_hold(one, bounds, estimates[draw], truth)
    return Coverage(covered / draws, estimates)


def surrogate(loss: VectorLoss, truth: Array, chance: np.random.Generator) -> Array:
    """Wrenches (n, 6), N and N m, as they might have been measured were ``truth`` true."""
    response = loss.response
    counts = response.counts
    offsets = loss.prior * chance.standard_normal(len(counts))
    series = response.at(float(truth[1]), float(truth[2]))
    clean = truth[0] * series.at(np.repeat(offsets, counts))
    if loss.shapes is not None and loss.shape_error > 0:
        factors = 1.0 + loss.shape_error * chance.standard_normal(int(loss.shapes.max()) + 1)
        clean = clean * np.repeat(factors[loss.shapes], counts)[:, None]
    factor = np.linalg.cholesky(loss.noise.covariance * loss.noise.inflation).T
    spread = np.sqrt(tare_variance(loss.free_samples, loss.noise.reading_variance))
    zeros = spread[:, None] * chance.standard_normal((len(counts), 6))
    scatter = chance.standard_normal(clean.shape) / loss.weights[:, None]
    rows = scatter + np.repeat(zeros, counts, axis=0)
    return clean + rows @ factor

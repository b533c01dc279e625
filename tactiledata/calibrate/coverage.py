"""How often the 95 % intervals hold the true parameters, on wrenches drawn from a known response."""

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
    """Result of a coverage experiment.

    Parameters
    ----------
    share : (3,)
        Share of the data sets whose interval of E, nu and mu holds the truth.
    estimates : (draws, 3)
        E (Pa), nu and mu fitted to each data set.
    """

    share: Array
    estimates: Array


def coverage(loss: VectorLoss, bounds: Bounds, truth: Array, draws: int = 200, seed: int = 0) -> Coverage:
    """Return how often the 95 % intervals hold a true E, nu, mu when the measurement is repeated.

    Noise, force zeros, contact offsets and indenter factors are drawn anew for each data set; the simulated response
    stays.

    Parameters
    ----------
    loss : VectorLoss
        Response, noise model and priors; its measured wrenches are replaced.
    bounds : Bounds
        The box that is searched.
    truth : (3,)
        E (Pa), nu, mu from which data sets are drawn.
    draws : int
        Number of data sets.
    seed : int
        Seed of the draws.
    """
    rng = np.random.default_rng([seed, 3])
    covered = np.zeros(3)
    estimates = np.empty((draws, 3))
    for draw in range(draws):
        redrawn = loss.with_measured(surrogate(loss, truth, rng))
        estimates[draw] = bounds.scaled(polish(redrawn, bounds, bounds.shares(truth)).shares)
        covered += intervals_hold(redrawn, bounds, estimates[draw], truth)
    return Coverage(covered / draws, estimates)


def surrogate(loss: VectorLoss, truth: Array, rng: np.random.Generator) -> Array:
    """Draw wrenches (n, 6), N and N m, as they might have been measured if ``truth`` were true.

    Parameters
    ----------
    loss : VectorLoss
        Response, noise model and priors from which is drawn.
    truth : (3,)
        E (Pa), nu, mu.
    rng : numpy.random.Generator
        Source of the draws.
    """
    response = loss.response
    counts = response.counts
    offsets = loss.prior * rng.standard_normal(len(counts))
    series = response.at(float(truth[1]), float(truth[2]))
    # wrenches without noise, at drawn contact offsets and drawn factors of the indenters
    clean = truth[0] * series.at(np.repeat(offsets, counts))
    if loss.shapes is not None and loss.shape_error > 0:
        factors = 1.0 + loss.shape_error * rng.standard_normal(int(loss.shapes.max()) + 1)
        clean = clean * np.repeat(factors[loss.shapes], counts)[:, None]
    # scatter of each frame and one zero of each trajectory, in the whitened space of the noise
    factor = np.linalg.cholesky(loss.noise.covariance * loss.noise.inflation).T
    spread = np.sqrt(tare_variance(loss.free_samples, loss.noise.reading_variance))
    zeros = spread[:, None] * rng.standard_normal((len(counts), 6))
    scatter = rng.standard_normal(clean.shape) / loss.weights[:, None]
    rows = scatter + np.repeat(zeros, counts, axis=0)
    return clean + rows @ factor

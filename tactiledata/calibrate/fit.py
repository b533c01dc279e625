"""From an experiment to E, nu and mu, their intervals, and the losses before, after and on what was held out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.experiment import Experiment
from tactiledata.calibrate.gent import youngs_modulus_of_shore_a
from tactiledata.calibrate.intervals import Intervals, bootstrap_intervals, profile_intervals
from tactiledata.calibrate.least_squares import polish
from tactiledata.calibrate.losses import Loss, LossName, NormLoss, VectorLoss
from tactiledata.calibrate.options import FEWEST, CalibrationOptions
from tactiledata.calibrate.search import search
from tactiledata.calibrate.simulation_error import SimulationError, simulation_error
from tactiledata.nuisance.noise import WrenchNoise


@dataclass(frozen=True)
class LossValues:
    """A loss at the start, at the optimum, and there on the trajectories held out (NaN: none).

    ``vector``: root mean square of the whitened residual, 1 where noise is all there is. ``norm``: N.
    """

    start: float
    fitted: float
    held_out_start: float
    held_out: float


@dataclass(frozen=True)
class Fit:
    """What was found.

    Parameters
    ----------
    parameters, start : (3,)
        E (Pa), nu, mu.
    intervals : Intervals
    simulation_error : SimulationError
    offsets : (t,) m
        Contact offset of every touch of the experiment, those held out included.
    fitted, held_out : places of the touches in the experiment
    shape_factors : dict, indenter -> factor
        On the forces of each indenter, those held out included; empty where the loss has none.
    losses : dict
        Both losses' values; the fit made the one of its name small.
    """

    parameters: Array
    start: Array
    intervals: Intervals
    simulation_error: SimulationError
    offsets: Array
    fitted: Indices
    held_out: Indices
    shape_factors: dict[str, float]
    losses: dict[LossName, LossValues]


def fit(experiment: Experiment, noise: WrenchNoise, bounds: Bounds, options: CalibrationOptions) -> Fit:
    """E, nu and mu inside the bounds."""
    fitted, held_out = deal(len(experiment.touches), options.hold_out, options.seed)
    start = bounds.inside(
        np.array([youngs_modulus_of_shore_a(options.shore_a), *(np.add(bounds.low, bounds.high) / 2)[1:]])
    )
    vector = vector_loss(experiment, noise, fitted, options.offset_prior, options.shape_share)
    norm = norm_loss(experiment, fitted)
    if options.loss == "vector":
        found = search(vector, bounds, start)
        found = bounds.scaled(polish(vector, bounds, bounds.shares(found)).shares)
        intervals = profile_intervals(vector, bounds, found)
    else:
        found = search(norm, bounds, start)
        intervals = bootstrap_intervals(norm, bounds, found, options.seed)
    erring = simulation_error(
        vector if options.loss == "vector" else norm, bounds, found, intervals.ends, options.mechanics
    )
    everything = np.arange(len(experiment.touches))
    whole = vector_loss(experiment, noise, everything, options.offset_prior, options.shape_share)
    unseen: dict[LossName, Loss] = {}
    if len(held_out):
        unseen = {
            "vector": vector_loss(experiment, noise, held_out, options.offset_prior, options.shape_share),
            "norm": norm_loss(experiment, held_out),
        }
    seen: dict[LossName, Loss] = {"vector": vector, "norm": norm}
    losses = {name: _values(loss, unseen.get(name), start, found) for name, loss in seen.items()}
    offsets = whole.offsets(found) if options.loss == "vector" else np.zeros(len(everything))
    factors = {}
    if options.loss == "vector" and options.shape_share > 0:
        names = sorted({touch.indenter for touch in experiment.touches})
        factors = dict(zip(names, map(float, whole.factors(found)), strict=True))
    return Fit(found, start, intervals, erring, offsets, fitted, held_out, factors, losses)


def deal(count: int, share: float, seed: int) -> tuple[Indices, Indices]:
    """Places of the trajectories to fit and of those held out, ascending; at least two are fitted."""
    held = max(0, min(round(share * count), count - FEWEST))
    order = np.random.default_rng([seed, 2]).permutation(count)
    return np.sort(order[held:]), np.sort(order[:held])


def vector_loss(
    experiment: Experiment, noise: WrenchNoise, which: Indices, prior: float, shape_error: float
) -> VectorLoss:
    """Over some of the touches."""
    names = [experiment.touches[k].indenter for k in which]
    shapes = np.unique(names, return_inverse=True)[1].astype(np.int64)
    return VectorLoss(
        experiment.response.part(which),
        _measured(experiment, which),
        noise,
        experiment.free_samples[which],
        prior,
        shapes,
        shape_error,
    )


def norm_loss(experiment: Experiment, which: Indices) -> NormLoss:
    """Over some of the touches."""
    return NormLoss(experiment.response.part(which), _measured(experiment, which))


def _measured(experiment: Experiment, which: Indices) -> Array:
    starts, counts = experiment.response.starts, experiment.response.counts
    return np.concatenate([experiment.measured[starts[k] : starts[k] + counts[k]] for k in which])


def _values(loss: Loss, unseen: Loss | None, start: Array, found: Array) -> LossValues:
    nothing = float("nan")
    return LossValues(
        loss.value(start),
        loss.value(found),
        unseen.value(start) if unseen else nothing,
        unseen.value(found) if unseen else nothing,
    )

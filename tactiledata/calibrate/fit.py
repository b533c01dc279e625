"""The fit of E, nu and mu to an experiment: optimum, intervals, and losses on fitted and held-out trajectories."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.experiment import Experiment
from tactiledata.calibrate.gent import youngs_modulus_of_shore_a
from tactiledata.calibrate.intervals import Intervals, bootstrap_intervals, profile_intervals
from tactiledata.calibrate.losses import Loss, LossName, NormLoss, VectorLoss
from tactiledata.calibrate.options import FEWEST, CalibrationOptions
from tactiledata.calibrate.search import search, search_squares
from tactiledata.calibrate.simulation_error import SimulationError, simulation_error
from tactiledata.nuisance.noise import WrenchNoise


@dataclass(frozen=True)
class LossValues:
    """Values of one loss at the start and at the optimum, on fitted and on held-out trajectories (NaN: none held out).

    The vector loss is a root mean square of the whitened residual, about 1 where only noise is left; the norm loss is
    in newtons.

    Parameters
    ----------
    start, fitted : float
        On the fitted trajectories, at the start and at the optimum.
    held_out_start, held_out : float
        On the trajectories held out, at the start and at the optimum.
    """

    start: float
    fitted: float
    held_out_start: float
    held_out: float


@dataclass(frozen=True)
class Fit:
    """Fitted gel parameters, how well they are known, and the losses.

    Parameters
    ----------
    parameters, start : (3,)
        E (Pa), nu, mu at the optimum, and where the search started.
    intervals : Intervals
        95 % intervals from the data alone.
    simulation_error : SimulationError
        The intervals widened for errors of the simulation.
    offsets : (t,) m
        Contact offset of every touch of the experiment, those held out included.
    fitted, held_out : (n_fitted,), (n_held_out,) int
        Places of the touches in the experiment.
    shape_factors : dict, indenter -> factor
        Measured over simulated force of each indenter, those held out included; empty where the loss has none.
    losses : dict, loss name -> LossValues
        Values of both losses; only the one that the options name was minimised.
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
    """Fit E, nu and mu inside the bounds.

    Parameters
    ----------
    experiment : Experiment
        Measured wrenches and their simulated response.
    noise : WrenchNoise
        Whitens the residual of the vector loss.
    bounds : Bounds
        The box that is searched.
    options : CalibrationOptions
        Loss, hold-out share, seed, hardness for the start, priors.
    """
    # the start: E from the hardness, nu and mu from the middle of the box
    fitted, held_out = draw_held_out(len(experiment.touches), options.hold_out, options.seed)
    start = bounds.inside(
        np.array([youngs_modulus_of_shore_a(options.shore_a), *(np.add(bounds.low, bounds.high) / 2)[1:]])
    )
    # the minimum of the chosen loss and its intervals
    vector = vector_loss(experiment, noise, fitted, options.offset_prior, options.shape_share)
    norm = norm_loss(experiment, fitted)
    if options.loss == "vector":
        optimum = search_squares(vector, bounds, start)
        intervals = profile_intervals(vector, bounds, optimum)
    else:
        optimum = search(norm, bounds, start)
        intervals = bootstrap_intervals(norm, bounds, optimum, options.seed)
    simulation_errors = simulation_error(
        vector if options.loss == "vector" else norm, bounds, optimum, intervals.ends, options.mechanics
    )
    # both losses on fitted and held-out trajectories
    all_places = np.arange(len(experiment.touches))
    all_touches = vector_loss(experiment, noise, all_places, options.offset_prior, options.shape_share)
    held_out_losses: dict[LossName, Loss] = {}
    if len(held_out):
        held_out_losses = {
            "vector": vector_loss(experiment, noise, held_out, options.offset_prior, options.shape_share),
            "norm": norm_loss(experiment, held_out),
        }
    fitted_losses: dict[LossName, Loss] = {"vector": vector, "norm": norm}
    losses = {name: _values(loss, held_out_losses.get(name), start, optimum) for name, loss in fitted_losses.items()}
    # offsets and factors of all trajectories at the optimum
    offsets = all_touches.offsets(optimum) if options.loss == "vector" else np.zeros(len(all_places))
    factors = {}
    if options.loss == "vector" and options.shape_share > 0:
        names = sorted({touch.indenter for touch in experiment.touches})
        factors = dict(zip(names, map(float, all_touches.factors(optimum)), strict=True))
    return Fit(optimum, start, intervals, simulation_errors, offsets, fitted, held_out, factors, losses)


def draw_held_out(count: int, share: float, seed: int) -> tuple[Indices, Indices]:
    """Draw which of ``count`` trajectories are fitted and which held out: two ascending arrays of places.

    Parameters
    ----------
    count : int
        Number of trajectories.
    share : float
        Share that is held out, 0 to below 1; fewer are held out where fewer than two would be left to fit.
    seed : int
        Seed of the draw.
    """
    held = max(0, min(round(share * count), count - FEWEST))
    order = np.random.default_rng([seed, 2]).permutation(count)
    return np.sort(order[held:]), np.sort(order[:held])


def vector_loss(
    experiment: Experiment, noise: WrenchNoise, which: Indices, prior: float, shape_error: float
) -> VectorLoss:
    """Vector loss over some of the touches.

    Parameters
    ----------
    experiment : Experiment
        Measured wrenches and their simulated response.
    noise : WrenchNoise
        Whitens the residual.
    which : (t,) int
        Places of the touches.
    prior : m
        Standard deviation of the contact offsets; 0 leaves them out.
    shape_error : float
        Standard deviation of the force factor of each indenter about 1; 0 leaves the factors out.
    """
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
    """Norm loss of the SPLIT paper over the touches at places ``which``."""
    return NormLoss(experiment.response.part(which), _measured(experiment, which))


def _measured(experiment: Experiment, which: Indices) -> Array:
    """Measured wrenches (n, 6) of the touches at places ``which``, frame after frame."""
    starts, counts = experiment.response.starts, experiment.response.counts
    return np.concatenate([experiment.measured[starts[k] : starts[k] + counts[k]] for k in which])


def _values(loss: Loss, held_out: Loss | None, start: Array, optimum: Array) -> LossValues:
    """Return a loss at start and optimum, on fitted and held-out trajectories; NaN where ``held_out`` is ``None``."""
    missing = float("nan")
    return LossValues(
        loss.value(start),
        loss.value(optimum),
        held_out.value(start) if held_out else missing,
        held_out.value(optimum) if held_out else missing,
    )

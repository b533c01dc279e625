"""A fit of E, nu and mu whose interpolated forces are corrected by simulations at the optimum.

Interpolation between nodes, and plays that were estimated, are off by about a hundredth of the force. That moves the
optimum by up to a third of an interval. A simulation at the optimum tells the error there, frame by frame; with it the
fit is done again. What is left is the error of slopes, and of the solver's tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds
from tactiledata.calibrate.experiment import Experiment
from tactiledata.calibrate.fit import Fit, fit
from tactiledata.calibrate.measured import Measured
from tactiledata.calibrate.options import CalibrationOptions
from tactiledata.calibrate.plays.player import play_at
from tactiledata.calibrate.response import Response
from tactiledata.compute.base import Scheduler

MOST_CORRECTIONS = 2
"""Corrections, at most: more do not settle, since plays are smooth in nu and mu only to the solver's tolerance."""
MOST_TOGETHER = 7
"""Touches that are simulated together at an optimum, at most: one that is hard to solve holds up few others."""
SETTLED = 0.2
"""Share of a 95 % interval: where E, nu and mu all move by less, a second correction would move them by less than a
tenth, which is what plays at nearly the same place differ by: docs/decisions/0089."""


@dataclass(frozen=True)
class CorrectedFit:
    """A fit, with the corrected response that it rests on.

    Parameters
    ----------
    fit : Fit
        Of the corrected response.
    experiment : Experiment
        Its response agrees with the simulations at the last optimum but one, frame by frame.
    simulated : (n, 6) N, N m
        Wrenches of all frames by the corrected response, at the optimum and the fitted contact offsets.
    interpolation_error : (2,) N
        Root mean square and largest difference of the interpolated forces from the simulated ones, before the last
        correction; NaN where no frame can be solved.
    """

    fit: Fit
    experiment: Experiment
    simulated: Array
    interpolation_error: tuple[float, float]


def corrected_fit(
    experiment: Experiment, measured: Measured, bounds: Bounds, options: CalibrationOptions, runner: Scheduler
) -> CorrectedFit:
    """Fit, simulate at the optimum, correct the response by the difference, and fit again.

    A frame that the gel cannot be solved for at the optimum is not corrected.

    Parameters
    ----------
    experiment : Experiment
        The frames and their interpolated response.
    measured : Measured
        Gives the mesh, and the noise of the wrenches.
    bounds : Bounds
        The box that is searched.
    options : CalibrationOptions
        Loss, hold-out, priors, engine and its fidelity.
    runner : Scheduler
        Where the touches are simulated.
    """
    assert measured.mesh is not None
    optimum = fit(experiment, measured.noise, bounds, options)
    for _ in range(MOST_CORRECTIONS):
        modulus, ratio, friction = (float(value) for value in optimum.parameters)
        # rounded to nanometres, so that a fit repeated elsewhere finds the same kept plays
        offsets = np.round(optimum.offsets, 9)
        plays = play_at(
            measured.mesh, options.mechanics, experiment.touches, ratio, friction, offsets, runner, MOST_TOGETHER
        )
        response = experiment.response
        difference = experiment.rows([play.wrench for play in plays]) - interpolated(response, ratio, friction, offsets)
        error = _size(modulus * difference)
        # the difference is taken to be the same at every nu and mu
        shifted = response.level + np.where(np.isfinite(difference), difference, 0.0)
        experiment = replace(experiment, response=replace(response, level=shifted))
        before, optimum = optimum, fit(experiment, measured.noise, bounds, options)
        widths = np.diff(optimum.intervals.ends, axis=1)[:, 0]
        if np.all(np.abs(optimum.parameters - before.parameters) <= SETTLED * widths):
            break
    modulus, ratio, friction = (float(value) for value in optimum.parameters)
    wrenches = modulus * interpolated(experiment.response, ratio, friction, optimum.offsets)
    return CorrectedFit(optimum, experiment, wrenches, error)


def interpolated(response: Response, ratio: float, friction: float, offsets: Array) -> Array:
    """Return the wrenches (n, 6) over Young's modulus, m^2 and m^3, of touches at their own contact offsets.

    Parameters
    ----------
    response : Response
        Of n frames of t touches.
    ratio, friction : float
        Poisson's ratio and coefficient of friction of the gel.
    offsets : (t,) m
        By how much each indenter is deeper than recorded.
    """
    return response.at(ratio, friction).at(np.repeat(offsets, response.counts))


def _size(difference: Array) -> tuple[float, float]:
    """Root mean square and largest size, N, of the forces of wrenches (n, 6); NaN where none is known."""
    sizes = np.linalg.norm(difference[:, :3], axis=1)
    known = sizes[np.isfinite(sizes)]
    if not len(known):
        return float("nan"), float("nan")
    return float(np.sqrt(np.mean(known**2))), float(known.max())

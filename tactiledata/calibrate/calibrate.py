"""`calibrate`: read, play, fit, check, say."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds, find_bounds
from tactiledata.calibrate.experiment import Experiment, assemble
from tactiledata.calibrate.fit import Fit, fit
from tactiledata.calibrate.measured import Measured, read_measured
from tactiledata.calibrate.options import FEWEST, CalibrationOptions
from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.player import play_at, play_nodes
from tactiledata.calibrate.remarks import remarks
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.records import Finding
from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount
from tactiledata.errors import TactileDataError
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_trajectories


@dataclass(frozen=True)
class Calibration:
    """A calibration and all that it rests on.

    Parameters
    ----------
    options : CalibrationOptions
    bounds : Bounds
    measured : Measured
    experiment : Experiment
    fit : Fit
    played : (n, 6) N, N m
        Played, not interpolated, at the optimum and the offsets found.
    interpolation_error : (2,) N
        Root mean square and largest difference of the interpolated forces from those played.
    findings : tuple of Finding
    store : str, digest of the store
    simulated : SimulatedCount
        Of the trajectories that took part.
    """

    options: CalibrationOptions
    bounds: Bounds
    measured: Measured
    experiment: Experiment
    fit: Fit
    played: Array
    interpolation_error: tuple[float, float]
    findings: tuple[Finding, ...]
    store: str
    simulated: SimulatedCount = NOTHING_STATED


def calibrate(store: Store, options: CalibrationOptions, tell: Progress = no_progress) -> Calibration:
    """E, nu and mu of the gel of a store's trajectories.

    Raises
    ------
    TactileDataError
        Fewer than two trajectories can be used; the message counts the reasons.
    UsageError
        Options that do not fit the store.
    """
    measured = read_measured(store, options)
    if measured.mesh is None or len(measured.touches) < FEWEST:
        raise too_few(len(measured.touches), measured.left_out)
    done = calibrate_measured(measured, options, store.digest, tell)
    return replace(done, simulated=simulated_trajectories(store, [touch.uid for touch in done.experiment.touches]))


def calibrate_measured(
    measured: Measured, options: CalibrationOptions, store: str, tell: Progress = no_progress
) -> Calibration:
    """The same from touches that were read."""
    assert measured.mesh is not None
    bounds = find_bounds(options.bounds)
    plan = ResponsePlan.of(bounds)
    plays = play_nodes(measured.mesh, options.mechanics, measured.touches, list(plan.nodes()), options.workers, tell)
    experiment = assemble(measured.touches, plan, plays)
    if isinstance(experiment, dict) or len(experiment.touches) < FEWEST:
        reasons = experiment if isinstance(experiment, dict) else experiment.left_out
        raise too_few(0 if isinstance(experiment, dict) else len(experiment.touches), {**measured.left_out, **reasons})
    found = fit(experiment, measured.noise, bounds, options)
    played, error = check_interpolation(experiment, found, measured, options)
    left_out = {**measured.left_out, **experiment.left_out}
    said = remarks(found, bounds, options.offset_prior, left_out, options.loss == "vector", options.shape_share)
    return Calibration(options, bounds, measured, experiment, found, played, error, tuple(said), store)


def check_interpolation(
    experiment: Experiment, found: Fit, measured: Measured, options: CalibrationOptions
) -> tuple[Array, tuple[float, float]]:
    """Wrenches (n, 6) played at the optimum, and how far the interpolated forces are from them: rms and largest, N.

    A frame that cannot be solved there keeps its interpolated wrench.
    """
    assert measured.mesh is not None
    modulus, ratio, friction = (float(value) for value in found.parameters)
    offsets = np.round(found.offsets, 9)
    plays = play_at(measured.mesh, options.mechanics, experiment.touches, ratio, friction, offsets)
    played = modulus * experiment.rows([play.wrench for play in plays])
    response = experiment.response
    between = modulus * response.at(ratio, friction).at(np.repeat(offsets, response.counts))
    apart = np.linalg.norm((played - between)[:, :3], axis=1)
    known = np.isfinite(apart)
    if not known.any():
        return between, (float("nan"), float("nan"))
    error = (float(np.sqrt(np.mean(apart[known] ** 2))), float(apart[known].max()))
    return np.where(known[:, None], played, between), error


def too_few(count: int, left_out: dict[str, int]) -> TactileDataError:
    """Nothing can be calibrated, and why."""
    reasons = "; ".join(f"{number} x {reason}" for reason, number in sorted(left_out.items())) or "the store holds none"
    return TactileDataError(
        f"{count} trajectories can be used ({reasons})",
        f"at least {FEWEST}",
        "See docs/calibration.md, What a recording must hold.",
        left_out=left_out,
    )

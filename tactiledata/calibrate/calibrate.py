"""`calibrate` in a row: read touches, simulate them, fit E, nu and mu, collect findings."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tactiledata.arrays import Array
from tactiledata.calibrate.bounds import Bounds, find_bounds
from tactiledata.calibrate.corrected_fit import corrected_fit
from tactiledata.calibrate.experiment import Experiment, assemble
from tactiledata.calibrate.fit import Fit
from tactiledata.calibrate.knowledge import KnownParameter, known_parameters, may_slide
from tactiledata.calibrate.measured import Measured, read_measured
from tactiledata.calibrate.options import FEWEST, CalibrationOptions
from tactiledata.calibrate.plan import ResponsePlan
from tactiledata.calibrate.plays.player import play_plan
from tactiledata.calibrate.remarks import remarks
from tactiledata.compute import make_scheduler
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.records import Finding
from tactiledata.contract.simulated import NOTHING_STATED, SimulatedCount
from tactiledata.contract.wording import all_left_out
from tactiledata.errors import TactileDataError
from tactiledata.replay.opened import OpenedStore
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_trajectories


@dataclass(frozen=True)
class Calibration:
    """A fit of E, nu and mu with the data, options and checks that it rests on.

    Parameters
    ----------
    options : CalibrationOptions
        What the user chose.
    bounds : Bounds
        The box that was searched.
    measured : Measured
        All usable touches of the store, and why others were left out.
    experiment : Experiment
        The frames that were fitted or held out, with their simulated response.
    fit : Fit
        Parameters, intervals and losses.
    simulated_wrenches : (n, 6) N, N m
        Wrenches of all frames at the optimum and at the fitted contact offsets (see `CorrectedFit`).
    interpolation_error : (2,) N
        Root mean square and largest difference of the interpolated forces from those simulated at the optimum, before
        the response was last corrected by it.
    findings : tuple of Finding
        What a reader should know of the fit.
    store : str
        Digest of the store.
    known : dict, name -> KnownParameter
        Whether E, nu and mu are identified, bounded or not told by the data.
    simulated : SimulatedCount
        How many of the trajectories that took part are themselves simulated.
    """

    options: CalibrationOptions
    bounds: Bounds
    measured: Measured
    experiment: Experiment
    fit: Fit
    simulated_wrenches: Array
    interpolation_error: tuple[float, float]
    findings: tuple[Finding, ...]
    store: str
    known: dict[str, KnownParameter]
    simulated: SimulatedCount = NOTHING_STATED


def calibrate(store: Store, options: CalibrationOptions, report_progress: Progress = no_progress) -> Calibration:
    """Fit E, nu and mu of the gel to a store's trajectories.

    Parameters
    ----------
    store : Store
        Its contact wrenches, poses and indenters are read.
    options : CalibrationOptions
        Which trajectories, loss, engine and bounds.
    report_progress : callable
        Called with the number of finished plays, their total and a label.

    Raises
    ------
    TactileDataError
        Fewer than two trajectories can be used; the message counts the reasons.
    UsageError
        Options that do not fit the store.
    """
    opened = OpenedStore.planned(store, options.pads, options.indenter_folder)
    measured = read_measured(opened, options)
    if measured.mesh is None or len(measured.touches) < FEWEST:
        raise too_few(len(measured.touches), measured.left_out)
    calibration = calibrate_measured(measured, options, store.digest, report_progress)
    return replace(
        calibration, simulated=simulated_trajectories(store, [touch.uid for touch in calibration.experiment.touches])
    )


def calibrate_measured(
    measured: Measured, options: CalibrationOptions, store: str, report_progress: Progress = no_progress
) -> Calibration:
    """Fit E, nu and mu to touches that were already read.

    Parameters
    ----------
    measured : Measured
        Touches with a mesh and the noise of their wrenches.
    options : CalibrationOptions
        Which loss, engine and bounds; its choice of trajectories is not applied again.
    store : str
        Digest of the store, for the provenance.
    report_progress : callable
        Called with the number of finished plays, their total and a label.

    Raises
    ------
    TactileDataError
        Fewer than two touches have enough frames that the gel could be solved for.
    """
    assert measured.mesh is not None
    bounds = find_bounds(options.bounds)
    plan = ResponsePlan.of(bounds)
    # its workers start once for all simulations
    with make_scheduler(options.workers, options.scheduler).kept_open() as runner:
        # simulate every touch at the nodes over nu, mu and offset
        plays = play_plan(measured.mesh, options.mechanics, measured.touches, plan, runner, report_progress).by_node()
        experiment = assemble(measured.touches, plan, plays)
        if isinstance(experiment, dict) or len(experiment.touches) < FEWEST:
            reasons = experiment if isinstance(experiment, dict) else experiment.left_out
            count = 0 if isinstance(experiment, dict) else len(experiment.touches)
            raise too_few(count, {**measured.left_out, **reasons})
        # fit, and correct what was interpolated by simulations at the optimum
        corrected = corrected_fit(experiment, measured, bounds, options, runner)
    optimum = corrected.fit
    left_out = {**measured.left_out, **experiment.left_out}
    is_slid = may_slide(experiment.touches)
    has_vector = options.loss == "vector"
    sensors = {touch.sensor for touch in experiment.touches}
    findings = remarks(
        optimum, bounds, options.offset_prior, left_out, has_vector, options.shape_share, is_slid, sensors
    )
    return Calibration(
        options,
        bounds,
        measured,
        corrected.experiment,
        optimum,
        corrected.simulated,
        corrected.interpolation_error,
        tuple(findings),
        store,
        known_parameters(optimum.intervals, bounds, is_slid),
    )


def too_few(count: int, left_out: dict[str, int]) -> TactileDataError:
    """Error for a store with too few usable trajectories; it counts the reasons of those left out."""
    return TactileDataError(
        f"{count} trajectories can be used ({all_left_out(left_out) or 'the store holds none'})",
        f"at least {FEWEST}",
        "See docs/calibration.md, What a recording must hold.",
        left_out=left_out,
    )

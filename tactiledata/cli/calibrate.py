"""`calibrate`: E, nu and mu of the gel from measured forces, and how well the recordings determine them."""

from __future__ import annotations

from pathlib import Path, PurePosixPath
from typing import Any

import typer

from tactiledata.cli.documents import refuse_result_of_another_store
from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import INDENTERS, listed_names, need_folder, need_seed, need_writable_folder
from tactiledata.cli.output import JSON_OPTION, emit, findings, progress, say, table
from tactiledata.cli.task_options import SCHEDULER, SIMULATION_WORKERS, workers_of
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store
from tactiledata.contract.extras import GEL, PAGE, need_packages


def register(app: typer.Typer) -> None:
    """Add the command `calibrate` to the application."""
    app.command("calibrate")(calibrate)


def calibrate(
    store: str = STORE_ARGUMENT,
    loss: str = typer.Option(
        "vector", "--loss", help="Compare forces and torques (vector), or only the norm of the force (norm)."
    ),
    engine: str = typer.Option(
        "fem", "--engine", help="Gel engine: fem, or mujoco-flex for comparison, whose forces are too high."
    ),
    fidelity: str = typer.Option(
        "finite-strain", "--fidelity", help="Strain model: finite-strain, or linear for a quick preview."
    ),
    out: Path = typer.Option(
        Path("calibration.json"), "--out", help="File for the result; a page for readers (.html) is written beside it."
    ),
    trajectories: int = typer.Option(
        25, "--trajectories", help="Number of trajectories that are drawn from the store."
    ),
    hold_out: float = typer.Option(0.2, "--hold-out", help="Share of these trajectories that is not fitted."),
    bounds: str = typer.Option(
        "paper", "--bounds", help="Limits of the fit: paper, or wide (E 200 to 4000 kPa, mu 0.2 to 1.5)."
    ),
    sensor: str = typer.Option(None, "--sensor", help="Use only trajectories of this sensor."),
    indenter: str = typer.Option(None, "--indenter", help="Use only trajectories of these indenters: ball3,ball5."),
    shore_a: float = typer.Option(24.5, "--shore-a", help="Shore A hardness of the gel, where the fit starts."),
    offset_prior: float = typer.Option(
        4e-5,
        "--offset-prior",
        help="Standard deviation, in metres, of each trajectory's contact offset; 0 fits no offsets.",
    ),
    shape_error: float = typer.Option(
        None,
        "--shape-error",
        help="Relative error of the simulated forces that an indenter's touches share; 0 for none "
        "[default: that of the engine].",
    ),
    replace: bool = typer.Option(False, "--replace", help="Replace a result of another store at the same place."),
    indenters: Path = typer.Option(None, "--indenters", help="Folder of the mesh files that recordings name."),
    seed: int = typer.Option(0, "--seed", help="Random seed for drawing trajectories."),
    workers: int = SIMULATION_WORKERS,
    scheduler: str = SCHEDULER,
    as_json: bool = JSON_OPTION,
) -> None:
    """Fit Young's modulus, Poisson's ratio and friction of the gel. A second run reuses simulations of the first.

    Example: tactiledata calibrate ds.zarr --trajectories 25
    """
    need_packages("a calibration", *GEL, *PAGE)
    from tactiledata.calibrate.calibrate import calibrate as run
    from tactiledata.calibrate.document import write_calibration
    from tactiledata.calibrate.options import CalibrationOptions
    from tactiledata.calibrate.page import calibration_page
    from tactiledata.contract.atomic import write_atomic
    from tactiledata.errors import UsageError
    from tactiledata.ingest.checks.twins import need_touches_once
    from tactiledata.store.read.reader import Store

    if out.suffix != ".json":
        raise UsageError(
            f"--out {out}", "a file name that ends in .json", "The page beside that file has the ending .html."
        )
    need_writable_folder(out.parent, out.name, out.with_suffix(".html").name)
    need_seed(seed)
    # fit
    options = CalibrationOptions(
        loss=loss,  # type: ignore[arg-type]
        engine=engine,  # type: ignore[arg-type]
        fidelity=fidelity,  # type: ignore[arg-type]
        bounds=bounds,
        trajectories=trajectories,
        hold_out=hold_out,
        seed=seed,
        shore_a=shore_a,
        offset_prior=offset_prior,
        shape_error=shape_error,
        sensor=sensor,
        indenters=() if indenter is None else tuple(listed_names(indenter, "--indenter")),
        workers=workers_of(workers, scheduler),
        scheduler=scheduler,
        indenter_folder=need_folder(indenters, "--indenters", INDENTERS),
    )
    location = working_store(store)
    with damage_explains(location), progress("trying nu and mu", quiet=as_json) as report_progress:
        opened = Store.open(location)
        refuse_result_of_another_store(out, opened, replace)
        need_touches_once(opened, sensor)
        calibration = run(opened, options, report_progress)
    # write and print
    document = write_calibration(calibration, out)
    page = out.with_suffix(".html")
    write_atomic(page, calibration_page(calibration, PurePosixPath(location).name).encode())
    if as_json:
        emit(document)
        return
    _print(calibration)
    say(f"written: {out}, {page}")


def _print(calibration: Any) -> None:
    """Print the fitted values, the losses and the findings of a calibration."""
    from tactiledata.calibrate.page import loss_rows, other_loss, result_rows

    counts = f"{len(calibration.fit.fitted)} fitted, {len(calibration.fit.held_out)} held out"
    columns = ("", "value", "95 % interval", "with simulation error", "start", "verdict")
    table(f"gel, engine {calibration.options.engine}, {counts}", columns, result_rows(calibration))
    table("", ("loss", "start", "fitted", "held out, start", "held out"), loss_rows(calibration))
    if said := other_loss(calibration):
        say(said)
    findings(("", finding) for finding in calibration.findings)
    if calibration.simulated.sentence:
        say(calibration.simulated.sentence)

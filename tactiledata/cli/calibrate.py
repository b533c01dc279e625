"""`calibrate`: E, nu and mu of the gel from measured forces, and whether they can be known."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import listed_names
from tactiledata.cli.output import JSON_OPTION, emit, findings, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command("calibrate")(calibrate)


def calibrate(
    store: str = STORE_ARGUMENT,
    loss: str = typer.Option("vector", "--loss", help="vector: forces and torques; norm: the SPLIT paper's."),
    engine: str = typer.Option("fem", "--engine", help="fem, or mujoco-flex: for comparison, its forces are too high."),
    fidelity: str = typer.Option("finite-strain", "--fidelity", help="finite-strain, or linear: a quick preview."),
    out: Path = typer.Option(
        Path("calibration.json"), "--out", help="The result; a page to read lies beside it, with the ending .html."
    ),
    trajectories: int = typer.Option(25, "--trajectories", help="So many are drawn from the store."),
    hold_out: float = typer.Option(0.2, "--hold-out", help="Share of them that is not fitted."),
    bounds: str = typer.Option("paper", "--bounds", help="paper, or wide: E 200 to 4000 kPa, mu 0.2 to 1.5."),
    sensor: str = typer.Option(None, "--sensor", help="Only trajectories of this sensor."),
    indenter: str = typer.Option(None, "--indenter", help="Only trajectories of these indenters: ball3,ball5."),
    shore_a: float = typer.Option(24.5, "--shore-a", help="The gel's Shore A hardness: where the search starts."),
    offset_prior: float = typer.Option(
        4e-5, "--offset-prior", help="Standard deviation, in metres, of each trajectory's contact offset; 0: none."
    ),
    shape_error: float = typer.Option(
        None, "--shape-error", help="Share by which each indenter's simulated forces may be off together; 0: none."
    ),
    indenters: Path = typer.Option(None, "--indenters", help="Folder of the mesh files that recordings name."),
    seed: int = typer.Option(0, "--seed", help="Another seed draws other trajectories."),
    workers: int = typer.Option(1, "--workers", min=1, help="Local processes."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Fit Young's modulus, Poisson's ratio and friction of the gel. A second run reads what the first one played.

    Example: tactiledata calibrate ds.zarr --trajectories 25 --workers 2
    """
    from tactiledata.calibrate.calibrate import calibrate as run
    from tactiledata.calibrate.document import write_calibration
    from tactiledata.calibrate.options import CalibrationOptions
    from tactiledata.calibrate.page import calibration_page
    from tactiledata.contract.atomic import write_atomic
    from tactiledata.errors import UsageError
    from tactiledata.store.read.reader import Store

    if out.suffix != ".json":
        raise UsageError(f"--out {out}", "a file that ends in .json", "The page beside it ends in .html.")
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
        workers=workers,
        indenter_folder=indenters,
    )
    location = working_store(store)
    with damage_explains(location), progress("playing", quiet=as_json) as tell:
        done = run(Store.open(location), options, tell)
    document = write_calibration(done, out)
    page = out.with_suffix(".html")
    write_atomic(page, calibration_page(done).encode())
    if as_json:
        emit(document)
        return
    _print(done)
    say(f"written: {out}, {page}")


def _print(done: Any) -> None:
    from tactiledata.calibrate.page import loss_rows, result_rows

    counts = f"{len(done.fit.fitted)} fitted, {len(done.fit.held_out)} held out"
    columns = ("", "value", "95 % interval", "with simulation error", "start")
    table(f"gel, engine {done.options.engine}, {counts}", columns, result_rows(done))
    table("", ("loss", "start", "fitted", "held out, start", "held out"), loss_rows(done))
    findings(("", finding) for finding in done.findings)
    if done.simulated.sentence:
        say(done.simulated.sentence)

"""The demo's steps with the soft gel: a calibration, and a replay with the calibrated material."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactiledata.cli.output import progress
from tactiledata.errors import TactileDataError

TOUCHES = 4
"""Number of touches that the demo's calibration plays, one of them held out; a real calibration takes 25."""


@dataclass(frozen=True)
class DemoGel:
    """The results of calibration and replay.

    Parameters
    ----------
    calibration : dict, optional
        The calibration's document; none where the world has too few touches.
    page : Path, optional
        The calibration's page.
    replay : ReplayReport
        The result of the replay.
    """

    calibration: dict[str, Any] | None
    page: Path | None
    replay: Any


def balls_of(scenario: Any) -> tuple[str, ...]:
    """Return the names of a scenario's balls."""
    return tuple(name for name, solid in scenario.indenters.items() if solid.get("shape") == "sphere")


def play_gel(
    store: Path, out: Path, scenario: Any, fidelity: Any, workers: int, report_step: Callable[[str], None], quiet: bool
) -> DemoGel:
    """Calibrate the gel on the world's balls, attach a mesh to every picture, and return both results.

    Parameters
    ----------
    store : Path
        The demo's store.
    out : Path
        The demo's folder.
    scenario : Scenario
        The world; its material serves where there is no calibration.
    fidelity : str
        Strain model, ``finite-strain`` or ``linear``.
    workers : int
        Number of local processes.
    report_step : callable
        Prints a line.
    quiet : bool
        Whether to show no progress.
    """
    from tactiledata.replay.attach import replay

    report_step(f"4. Calibrate: E, nu and mu of the gel from measured forces ({fidelity}, {TOUCHES} touches of balls)")
    document, page = None, None
    try:
        document, page = _calibrate(store, out, scenario, fidelity, workers, report_step, quiet)
    except TactileDataError as error:
        report_step(f"   left out: {error.found}; the replay takes the world's own material")
    report_step("5. Replay: every touch through the soft gel, a mesh for every picture")
    options = _replay_options(document, scenario.material, fidelity)
    with progress("replaying", quiet=quiet) as bar:
        replayed = replay(store, options, workers, progress=bar)
    for line in replayed.lines():
        report_step(f"   {line}")
    return DemoGel(document, page, replayed)


def _calibrate(
    store: Path, out: Path, scenario: Any, fidelity: Any, workers: int, report_step: Callable[[str], None], quiet: bool
) -> tuple[dict[str, Any], Path]:
    """Calibrate on the world's balls; print the values beside the true ones, and return document and page."""
    from tactiledata.calibrate.calibrate import calibrate
    from tactiledata.calibrate.document import write_calibration
    from tactiledata.calibrate.options import CalibrationOptions
    from tactiledata.calibrate.page import calibration_page, result_rows
    from tactiledata.contract.atomic import write_atomic
    from tactiledata.store.read.reader import Store

    options = CalibrationOptions(fidelity=fidelity, trajectories=TOUCHES, indenters=balls_of(scenario), workers=workers)
    with progress("trying nu and mu", quiet=quiet) as bar:
        calibration = calibrate(Store.open(store), options, bar)
    page = out / "calibration.html"
    document = write_calibration(calibration, out / "calibration.json")
    write_atomic(page, calibration_page(calibration, store.name).encode())
    # fitted values beside the true ones
    truth = scenario.material
    values = (f"{truth.youngs_modulus / 1e3:.1f} kPa", f"{truth.poisson_ratio:.3f}", f"{truth.friction:.3f}")
    for (name, value, interval, *_), true in zip(result_rows(calibration), values, strict=True):
        report_step(f"   {name} = {value}, 95 % {interval}; simulated with {true}")
    for finding in calibration.findings:
        if finding.severity != "info":
            report_step(f"   {finding.severity}: {finding.message}")
    if scenario.hidden and any(finding.severity != "info" for finding in calibration.findings):
        report_step("   The warnings are symptoms: this world has physics that the simulation lacks. Step 8 names it")
    return document, page


def _replay_options(document: dict[str, Any] | None, material: Any, fidelity: Any) -> Any:
    """Return the options of the replay: the calibrated material, else the world's own."""
    from tactiledata.gel.elasticity.material import GelMaterial
    from tactiledata.replay.options import ReplayOptions

    if document is None:
        own = GelMaterial(material.youngs_modulus, material.poisson_ratio, material.friction)
        return ReplayOptions(own, fidelity=fidelity)
    calibrated = GelMaterial(document["youngs_modulus"], document["poisson_ratio"], document["friction"])
    return ReplayOptions(calibrated, fidelity=fidelity, offsets=document["offsets"])

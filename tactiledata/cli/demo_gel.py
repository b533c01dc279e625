"""The demo's steps through the soft gel: a calibration, and the replay with what it found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactiledata.cli.output import progress
from tactiledata.errors import TactileDataError

TOUCHES = 4
"""That the demo's calibration plays, one of them held out; a real one takes 25."""


@dataclass(frozen=True)
class DemoGel:
    """What came out of both steps.

    Parameters
    ----------
    calibration : dict, optional
        The document; none where the world's touches are too few.
    page : Path, optional
    replay : ReplayReport
    """

    calibration: dict[str, Any] | None
    page: Path | None
    replay: Any


def balls_of(scenario: Any) -> tuple[str, ...]:
    """Names of the scenario's balls."""
    return tuple(name for name, solid in scenario.indenters.items() if solid.get("shape") == "sphere")


def play_gel(
    store: Path, out: Path, scenario: Any, fidelity: Any, workers: int, tell: Callable[[str], None], quiet: bool
) -> DemoGel:
    """Calibrate the gel on the world's balls, and attach a mesh to every picture."""
    from tactiledata.replay.attach import replay

    tell(f"4. Calibrate: E, nu and mu of the gel from measured forces ({fidelity}, {TOUCHES} touches of balls)")
    document, page = None, None
    try:
        document, page = _calibrate(store, out, scenario, fidelity, workers, tell, quiet)
    except TactileDataError as error:
        tell(f"   left out: {error.found}; the replay takes the world's own material")
    tell("5. Replay: every touch through the soft gel, a mesh for every picture")
    options = _replay_options(document, scenario.material, fidelity)
    with progress("replaying", quiet=quiet) as bar:
        replayed = replay(store, options, workers, progress=bar)
    for line in replayed.lines():
        tell(f"   {line}")
    return DemoGel(document, page, replayed)


def _calibrate(
    store: Path, out: Path, scenario: Any, fidelity: Any, workers: int, tell: Callable[[str], None], quiet: bool
) -> tuple[dict[str, Any], Path]:
    from tactiledata.calibrate.calibrate import calibrate
    from tactiledata.calibrate.document import write_calibration
    from tactiledata.calibrate.options import CalibrationOptions
    from tactiledata.calibrate.page import calibration_page, result_rows
    from tactiledata.contract.atomic import write_atomic
    from tactiledata.store.read.reader import Store

    options = CalibrationOptions(fidelity=fidelity, trajectories=TOUCHES, indenters=balls_of(scenario), workers=workers)
    with progress("playing", quiet=quiet) as bar:
        found = calibrate(Store.open(store), options, bar)
    page = out / "calibration.html"
    document = write_calibration(found, out / "calibration.json")
    write_atomic(page, calibration_page(found).encode())
    truth = scenario.material
    values = (f"{truth.youngs_modulus / 1e3:.1f} kPa", f"{truth.poisson_ratio:.3f}", f"{truth.friction:.3f}")
    for (name, value, interval, *_), true in zip(result_rows(found), values, strict=True):
        tell(f"   {name} = {value}, 95 % {interval}; simulated with {true}")
    for finding in found.findings:
        if finding.severity != "info":
            tell(f"   {finding.severity}: {finding.message}")
    if scenario.hidden and any(finding.severity != "info" for finding in found.findings):
        tell("   Such warnings are symptoms: this world conceals physics from the simulation; step 8 asks which")
    return document, page


def _replay_options(document: dict[str, Any] | None, material: Any, fidelity: Any) -> Any:
    from tactiledata.gel.elasticity.material import GelMaterial
    from tactiledata.replay.options import ReplayOptions

    if document is None:
        own = GelMaterial(material.youngs_modulus, material.poisson_ratio, material.friction)
        return ReplayOptions(own, fidelity=fidelity)
    found = GelMaterial(document["youngs_modulus"], document["poisson_ratio"], document["friction"])
    return ReplayOptions(found, fidelity=fidelity, offsets=document["offsets"])

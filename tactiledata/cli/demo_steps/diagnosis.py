"""The demo's last step: a diagnosis of the physics that the simulation of its touches lacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tactiledata.rig.scenario.scenario import Scenario

from tactiledata.cli.demo_steps.gel import balls_of
from tactiledata.cli.output import progress
from tactiledata.errors import TactileDataError

TOUCHES = 14
"""Largest number of touches that the demo plays, at small strain; a real diagnosis takes 60 at finite strain."""


def diagnose_touches(
    store: Path, out: Path, scenario: Scenario, workers: int, report_step: Callable[[str], None], quiet: bool
) -> tuple[dict[str, Any] | None, Path | None]:
    """Diagnose the touches of balls in the demo's store; return the document and the path of its page.

    Both are None where the world has no balls, or too few touches of them.

    Parameters
    ----------
    store : Path
        The demo's store.
    out : Path
        The demo's folder.
    scenario : Scenario
        The world, whose hidden effects are named at the end.
    workers : int
        Number of local processes.
    report_step : callable
        Prints a line.
    quiet : bool
        Whether to show no progress.
    """
    from tactiledata.diagnose.answer.documents import store_document, write_store_diagnosis
    from tactiledata.diagnose.answer.other_steps import StatedMaterial
    from tactiledata.diagnose.options import DiagnosisOptions
    from tactiledata.diagnose.store import diagnose_store
    from tactiledata.gel.elasticity.material import GelMaterial
    from tactiledata.store.read.reader import Store

    report_step(
        f"8. Diagnose: what physics does the simulation lack? (balls, at most {TOUCHES} touches, linear preview)"
    )
    balls = balls_of(scenario)
    if not balls:
        report_step("   left out: this world has no balls")
        return None, None
    options = DiagnosisOptions(trajectories=TOUCHES, indenters=balls, fidelity="linear", pairs=False, workers=workers)
    try:
        with progress("diagnosing", quiet=quiet) as bar:
            diagnosis = diagnose_store(Store.open(store), options, bar, lambda what: bar(1, 1, what))
    except TactileDataError as error:
        report_step(f"   left out: {error.found}")
        return None, None
    # the world's own numbers, beside those that were fitted
    own = scenario.material
    world = StatedMaterial(
        "the recorded world",
        GelMaterial(own.youngs_modulus, own.poisson_ratio, own.friction),
        "the truth, which only a simulated world states",
    )
    diagnosis = replace(diagnosis, stated=(world, *diagnosis.stated))
    document = store_document(diagnosis)
    written = write_store_diagnosis(out / "diagnosis", "the demo's world", diagnosis, document)
    report_step(f"   {document['source']['groups']} touches took part")
    for sentence in document["sentences"]:
        report_step(f"   {sentence}")
    truth = out / "recordings" / "truth"
    report_step(f"   The simulated recordings were made with {_concealed(scenario)}; only {truth} states this")
    return document, written[0]


def _concealed(scenario: Scenario) -> str:
    """Return the hidden effects of a scenario in words, by their titles in the catalogue where it has them."""
    from tactiledata.diagnose.residuals.residuals import joined_names
    from tactiledata.effects import EFFECTS
    from tactiledata.rig.hidden.effects import name_of

    names = [name_of(effect) for effect in scenario.hidden]
    titles = [EFFECTS[name].title if name in EFFECTS else name.replace("_", " ") for name in names]
    return joined_names(titles or ["nothing else"])

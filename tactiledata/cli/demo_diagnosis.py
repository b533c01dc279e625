"""The demo's last step: what the simulation of its touches lacks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tactiledata.rig.scenario.scenario import Scenario

from tactiledata.cli.demo_gel import balls_of
from tactiledata.cli.output import progress
from tactiledata.errors import TactileDataError

TOUCHES = 14
"""That are played, linearly; a real diagnosis takes 60 at finite strain."""


def diagnose_touches(
    store: Path, out: Path, scenario: Scenario, workers: int, tell: Callable[[str], None], quiet: bool
) -> tuple[dict[str, Any] | None, Path | None]:
    """Document and page; neither where the world's touches are too few, or of no balls."""
    from tactiledata.diagnose.answer.documents import store_document, write_store_diagnosis
    from tactiledata.diagnose.options import DiagnosisOptions
    from tactiledata.diagnose.store import diagnose_store
    from tactiledata.store.read.reader import Store

    tell(f"8. Diagnose: what physics does the simulation lack? (balls, at most {TOUCHES} touches, linear preview)")
    balls = balls_of(scenario)
    if not balls:
        tell("   left out: this world has no balls")
        return None, None
    options = DiagnosisOptions(trajectories=TOUCHES, indenters=balls, fidelity="linear", pairs=False, workers=workers)
    try:
        with progress("diagnosing", quiet=quiet) as bar:
            done = diagnose_store(Store.open(store), options, bar, lambda what: bar(1, 1, what))
    except TactileDataError as error:
        tell(f"   left out: {error.found}")
        return None, None
    document = store_document(done)
    written = write_store_diagnosis(out / "diagnosis", "the demo's world", done, document)
    tell(f"   {document['source']['groups']} touches took part")
    for sentence in document["sentences"]:
        tell(f"   {sentence}")
    truth = out / "recordings" / "truth"
    tell(f"   The simulated recordings were made with {_concealed(scenario)}, which only {truth} tells")
    return document, written[0]


def _concealed(scenario: Scenario) -> str:
    from tactiledata.diagnose.residuals.residuals import joined_names
    from tactiledata.effects import EFFECTS
    from tactiledata.rig.hidden.effects import name_of

    names = [name_of(effect) for effect in scenario.hidden]
    titles = [EFFECTS[name].title if name in EFFECTS else name.replace("_", " ") for name in names]
    return joined_names(titles or ["nothing else"])

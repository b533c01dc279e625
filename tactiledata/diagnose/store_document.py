"""The diagnosis of a store as a document and a page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.contract.provenance import provenance
from tactiledata.contract.schema import check_document
from tactiledata.diagnose.case_residuals import COMPONENTS, TO_UNIT, UNITS
from tactiledata.diagnose.diagnosis import StoreDiagnosis
from tactiledata.diagnose.naming_document import naming_document
from tactiledata.diagnose.naming_page import naming_page, naming_sentences
from tactiledata.diagnose.next_trial_words import next_trial_sentences, next_trials_document
from tactiledata.diagnose.table_document import FORMAT, form_document
from tactiledata.effects import EFFECTS

MOST_TRIALS = 3


def sentences_of(done: StoreDiagnosis) -> list[str]:
    """For people, the plainest first."""
    said = [*_of_zeros(done), *naming_sentences(done.naming, done.shown.located, done.shown), *_further(done)]
    return [*said, *filter(None, [done.simulated.sentence])]


def _of_zeros(done: StoreDiagnosis) -> list[str]:
    return [cause.words for cause in done.zeros]


def _further(done: StoreDiagnosis) -> list[str]:
    form = None if done.formula is None else done.formula.form
    said = [f"A formula for it: {form.words}."] if form is not None and form.terms else []
    return [*said, *done.limits, *next_trial_sentences(done.proposals, _is_more_left(done))[:MOST_TRIALS]]


def _is_more_left(done: StoreDiagnosis) -> bool:
    left_over = done.shown.left_over
    return done.naming.decision.is_more_left or (left_over is not None and left_over.is_structured)


def notes_of(done: StoreDiagnosis) -> list[str]:
    """What was left out, and why."""
    played = done.played
    noted = [f"{count} x {reason}" for reason, count in sorted(played.left_out.items())]
    if played.frames_lost:
        noted.append(f"{played.frames_lost} frames without pose or wrench, or too deep for the gel, take no part")
    by_reason: dict[str, list[str]] = {}
    asked = done.options.effects
    for name, reason in played.not_played.items():
        if asked and name not in asked:
            continue
        by_reason.setdefault(reason, []).append(EFFECTS[name]().title)
    for name in done.naming.not_tried:
        needed = " and ".join(_TOLD.get(each, each) for each in EFFECTS[name].needs)
        by_reason.setdefault(f"the recordings do not tell {needed}", []).append(EFFECTS[name]().title)
    return noted + [f"not tried: {', '.join(names)}: {reason}" for reason, names in by_reason.items()]


_TOLD = {
    "joints": "the joints' angles",
    "gravity": "how the sensor is turned",
    "powered": "when the sensor was switched on (power_on_ns in log.yaml)",
    "selection": "a range of forces to which they were cut",
    "earlier_depth": "what was done to the gel before",
    "earlier_contacts": "what was done to the gel before",
}


def store_document(done: StoreDiagnosis) -> dict[str, Any]:
    """``diagnosis.json`` (schemas/diagnosis.json); the same for the same store, options and seed."""
    white = done.naming.cases
    noise = done.played.cases.cases[0].noise.deviations * TO_UNIT
    formula = done.formula
    document = {
        "format": FORMAT,
        "source": {
            "kind": "store",
            "groups": len(white.starts),
            "rows": len(white.measured),
            "components": [
                {"name": name, "unit": unit, "noise": float(size)}
                for name, unit, size in zip(COMPONENTS, UNITS, noise, strict=True)
            ],
        },
        "answer": done.verdict,
        "sentences": sentences_of(done),
        "open_form": None if formula is None else form_document(formula),
        "ceiling": {"explained": done.shown.ceiling.explained},
        "next_trials": next_trials_document(done.proposals, is_more_left=_is_more_left(done)),
        "zeros": [cause.document for cause in done.zeros],
        "simulated_recordings": done.simulated.document(),
        "notes": notes_of(done),
        "provenance": provenance("diagnose", {"store": done.store}, done.options.document()),
        **naming_document(done.naming, done.shown.located, done.shown),
    }
    check_document(document, "diagnosis", "the diagnosis")
    return document


def effects_file(done: StoreDiagnosis, document: dict[str, Any]) -> dict[str, Any] | None:
    """``effects.json`` (schemas/effect.json), for a replay with what is claimed; ``None`` where nothing is."""
    best = done.naming.decision.best
    if document["naming"]["effects"] is None or best is None:
        return None
    offsets = zip(done.played.uids, best.fit.model.offsets.tolist(), strict=True)
    effects = {**document["naming"]["effects"], "offsets": dict(offsets), "provenance": document["provenance"]}
    check_document(effects, "effect", "the effects")
    return effects


def write_store_diagnosis(folder: Path, name: str, done: StoreDiagnosis, document: dict[str, Any]) -> list[Path]:
    """``report.html``, ``diagnosis.json``, ``effects.json`` where any is claimed, and the scenarios of next trials."""
    folder.mkdir(parents=True, exist_ok=True)
    written = [folder / "report.html", folder / "diagnosis.json"]
    effects = effects_file(done, document)
    if effects is not None:
        written.append(folder / "effects.json")
        write_json_atomic(written[-1], effects)
    trials = []
    for proposal in document["next_trials"]["proposals"]:
        path = folder / "next" / f"{proposal['trial']}.yaml"
        path.parent.mkdir(exist_ok=True)
        write_atomic(path, yaml.safe_dump(proposal["scenario"], sort_keys=False).encode())
        written.append(path)
        trials.append((proposal["title"], f"next/{path.name}"))
    footer = f"{document['source']['groups']} trajectories, {document['source']['rows']} frames"
    title = f"Diagnosis of {name}"
    shown = done.shown
    page = naming_page(
        title, done.naming, shown.located, shown, trials, document["notes"], footer, _further(done), _of_zeros(done),
        done.simulated,
    )  # fmt: skip
    write_atomic(written[0], page.encode())
    write_json_atomic(written[1], document)
    return written

"""The diagnoses of tables and stores as documents (schemas/diagnosis.json), and the files that are written."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.contract.own_files import marked_yaml
from tactiledata.contract.provenance import provenance
from tactiledata.contract.schema import check_document
from tactiledata.diagnose.answer.diagnosis import StoreDiagnosis
from tactiledata.diagnose.answer.earlier_files import EFFECTS, NEXT, remove_earlier
from tactiledata.diagnose.answer.locator_rows import change_document, located_document
from tactiledata.diagnose.answer.naming_page import naming_page, naming_sentences
from tactiledata.diagnose.answer.next_trial_words import next_trial_sentences, next_trials_document
from tactiledata.diagnose.answer.notes import notes_of
from tactiledata.diagnose.answer.other_steps import other_steps_section
from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.answer.unseen_page import shown_sentences
from tactiledata.diagnose.formula.explain import Explanation
from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.locate import LocatorResults
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.residuals.gap import Gap
from tactiledata.diagnose.table_input.residuals_of import Table
from tactiledata.diagnose.unseen.compare import HeldOutComparison
from tactiledata.diagnose.unseen.errors import HeldOutErrors
from tactiledata.diagnose.unseen.touch_residuals import COMPONENTS, TO_UNIT, UNITS

FORMAT = "tactiledata-diagnosis/1"


def table_document(table: Table, explanation: Explanation, digest: str, seed: int) -> dict[str, Any]:
    """Return the diagnosis of a table as `diagnosis.json`, checked against its schema.

    It holds the verdict and its sentences, what each locator found before and after the formula, the formula with its
    errors on unseen groups, and where all of this comes from. The same table and seed give the same document.

    Parameters
    ----------
    table : Table
        The table as it was read.
    explanation : Explanation
        Its diagnosis.
    digest : str
        Digest of the table's file, for provenance.
    seed : int
        The seed of the diagnosis, for provenance.
    """
    residuals = table.residuals
    deviations = np.ones(len(residuals.components)) if residuals.deviations is None else residuals.deviations
    document = {
        "format": FORMAT,
        "source": {
            "kind": "table",
            "groups": residuals.unit_count,
            "rows": len(residuals.values),
            "components": [
                {"name": name, "unit": unit, "noise": float(size) if table.is_noise_known else None}
                for name, unit, size in zip(residuals.components, residuals.units, deviations, strict=True)
            ],
        },
        "answer": explanation.answer.value,
        "sentences": explanation.sentences(),
        "located": located_document(explanation.located),
        "left_over": None if explanation.left_over is None else located_document(explanation.left_over),
        "open_form": form_document(explanation),
        "gap": _gap_of_formula(explanation),
        "errors": errors(table, explanation),
        "ceiling": {"explained": explanation.ceiling.explained},
        "empirical": None
        if explanation.surface is None
        else {
            "covariates": list(explanation.surface.covariates),
            "explained": explanation.surface.explained,
            "words": explanation.surface.words,
        },
        "notes": list(table.notes),
        "provenance": provenance("diagnose", {"table": digest}, {"seed": seed}),
    }
    check_document(document, "diagnosis", "the diagnosis")
    return document


def errors(table: Table, explanation: Explanation) -> list[dict[str, Any]]:
    """Return the errors of a table's predictions without and with the formula, as the part ``errors`` of a document.

    There is one row for each component: its name, its unit, and the root mean square of its residual ``before`` (with
    no formula) and ``after``, in that unit, on groups that had no part in choosing or fitting the formula. The list is
    empty where there is no formula, or the size of the noise is not known.
    """
    held, residuals = explanation.held, table.residuals
    if held is None or residuals.deviations is None:
        return []
    listed = []
    for place, name in enumerate(residuals.components):
        before, after = (
            float(residuals.deviations[place] * np.sqrt(np.mean(left[:, place] ** 2)))
            for left in (held.before, held.after)
        )
        listed.append({"component": name, "unit": residuals.units[place], "before": before, "after": after})
    return listed


def form_document(explanation: Explanation) -> dict[str, Any] | None:
    """Return the part ``open_form``; ``None`` where the locators find no structure."""
    form = explanation.form
    if form is None:
        return None
    return {
        "words": form.words,
        "definitions": list(form.definitions),
        "candidates": form.candidates,
        "false_terms_bound": form.false_terms,
        "terms": [{**vars(term), "alike": list(term.alike)} for term in form.terms],
        "behaves_like": [vars(effect) for effect in form.behaves_like],
        "beside": [{"parameter": change.parameter.name, "change": change_document(change)} for change in form.beside],
    }


def _gap_of_formula(explanation: Explanation) -> dict[str, Any] | None:
    """Return the part ``gap``; ``None`` without a formula."""
    gap = explanation.gap
    if gap is None:
        return None
    return {
        "before": gap.before,
        "after": gap.after,
        "floor": _number(gap.floor),
        "closed": _number(gap.closed),
        "interval": [_number(end) for end in gap.interval],
        "floor_is": explanation.floor_is,
    }


def _number(value: float) -> float | None:
    """Return a number as JSON can hold it: ``None`` where it is not finite."""
    return float(value) if math.isfinite(value) else None


def naming_document(naming: NamingResult, located: LocatorResults, shown: HeldOutComparison) -> dict[str, Any]:
    """Return the parts ``located``, ``left_over``, ``naming`` and ``shown``.

    Parameters
    ----------
    naming : NamingResult
    located : LocatorResults
        Results of the locators on the plain simulation.
    shown : HeldOutComparison
        Errors on held-out data.
    """
    return {
        "located": located_document(located),
        "left_over": None if shown.left_over is None else located_document(shown.left_over),
        "naming": Answer(naming).document,
        "shown": shown_document(naming, shown),
    }


def shown_document(naming: NamingResult, shown: HeldOutComparison) -> dict[str, Any]:
    """Return the part ``shown``: how much better the simulation is on held-out data."""
    cases = naming.whitened.touch_set.touches
    return {
        "effects": list(shown.names),
        "tried": list(shown.tried),
        "sentences": shown_sentences(shown),
        "held_out": [_held_out(errors, bool(shown.names)) for errors in shown.errors],
        "dependence": None if shown.flattened is None else _dependence(*shown.flattened),
        "black_box": {"explained": shown.ceiling.explained, "force": shown.ceiling_force},
        "worst": [cases[number].name for number in shown.worst()],
        "stretched": [{"words": words, "deviations": size} for words, size in shown.stretched.items()],
    }


def _held_out(errors: HeldOutErrors, is_claimed: bool) -> dict[str, Any]:
    """Return the errors on one kind of held-out data as schemas/diagnosis.json has them (``shown.held_out``)."""
    before, after, floor = errors.paper
    return {
        "unseen": errors.unseen,
        "groups": errors.groups,
        "force": _gap(errors.force, "N", is_claimed and errors.has_gap),
        "torque": _gap(errors.torque, "N mm", is_claimed and errors.has_torque_gap),
        "paper_loss": {"unit": "N", "before": before, "after": after, "floor": floor},
    }


def _gap(gap: Gap, unit: str, has_gap: bool) -> dict[str, Any]:
    """Return an error before and after as schemas/diagnosis.json has it (``error``)."""
    is_known = has_gap and math.isfinite(gap.closed)
    return {
        "unit": unit,
        "before": gap.before,
        "after": gap.after,
        "floor": gap.floor,
        "closed": gap.closed if is_known else None,
        "interval": list(gap.interval) if is_known else None,
    }


def _dependence(before: Drift, after: Drift) -> dict[str, Any]:
    """Return the part ``shown.dependence``: a drift before and after."""
    return {
        "parameter": before.parameter,
        "covariate": before.covariate,
        "before": {"p": before.p, "change": change_document(before.change)},
        "after": {"p": after.p, "change": change_document(after.change)},
    }


MOST_TRIALS = 3
"""Most sentences about trials to record next."""


def sentences_of(done: StoreDiagnosis) -> list[str]:
    """Return the sentences of a store's diagnosis, the answer first."""
    sentences = [*_sensor_sentences(done), *naming_sentences(done.naming, done.shown.located, done.shown)]
    return [*sentences, *_further(done), *filter(None, [done.simulated.sentence])]


def _sensor_sentences(done: StoreDiagnosis) -> list[str]:
    """Return sentences on what the force sensor's readings show, and on each cause of its zeros that matters."""
    return [*(shown.words for shown in done.readings), *(cause.words for cause in done.zeros if cause.matters)]


def _further(done: StoreDiagnosis) -> list[str]:
    """Return sentences on a formula, on a drift that does not matter, on limits of the recordings, and on trials to
    record next.
    """
    form = None if done.formula is None else done.formula.form
    formula = [f"A formula for what is missing: {form.words}."] if form is not None and form.terms else []
    harmless = [cause.words for cause in done.zeros if not cause.matters]
    return [*formula, *harmless, *done.limits, *next_trial_sentences(done.proposals, _is_more_left(done))[:MOST_TRIALS]]


def _is_more_left(done: StoreDiagnosis) -> bool:
    """Return whether the best explanation leaves structure, by the decision or by the locators."""
    left_over = done.shown.left_over
    return done.naming.decision.is_more_left or (left_over is not None and left_over.is_structured)


def store_document(done: StoreDiagnosis) -> dict[str, Any]:
    """Return the diagnosis of a store as a document; the same store, options and seed give the same document."""
    white = done.naming.whitened
    noise = done.played.touch_set.touches[0].noise.deviations * TO_UNIT
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
        "answer": done.verdict.value,
        "sentences": sentences_of(done),
        "open_form": None if formula is None else form_document(formula),
        "ceiling": {"explained": done.shown.ceiling.explained},
        "next_trials": next_trials_document(done.proposals, is_more_left=_is_more_left(done)),
        "zeros": [cause.document for cause in done.zeros],
        "readings": [shown.document for shown in done.readings],
        "simulated_recordings": done.simulated.document(),
        "trajectories": list(done.played.uids),
        "frames": asdict(done.played.frames),
        "full_plays": [
            {name: _number(value) if name != "effect" else value for name, value in asdict(one).items()}
            for one in done.full_plays
        ],
        "notes": notes_of(done),
        "provenance": provenance("diagnose", {"store": done.store}, done.options.document()),
        **naming_document(done.naming, done.shown.located, done.shown),
    }
    check_document(document, "diagnosis", "the diagnosis")
    return document


def effects_file(done: StoreDiagnosis, document: dict[str, Any]) -> dict[str, Any] | None:
    """Return ``effects.json`` (schemas/effect.json) for a replay with the claimed effects; ``None`` without a claim."""
    best = done.naming.decision.best
    if document["naming"]["effects"] is None or best is None:
        return None
    offsets = zip(done.played.uids, best.fit.model.offsets.tolist(), strict=True)
    effects = {**document["naming"]["effects"], "offsets": dict(offsets), "provenance": document["provenance"]}
    check_document(effects, "effect", "the effects")
    return effects


def write_store_diagnosis(folder: Path, name: str, done: StoreDiagnosis, document: dict[str, Any]) -> list[Path]:
    """Write page, document, claimed effects and the scenarios of next trials into a folder, and return their paths.

    What an earlier diagnosis wrote there, and this one does not, is removed first.

    Parameters
    ----------
    folder : Path
        Is made where it does not exist. It receives ``report.html``, ``diagnosis.json``, ``effects.json`` where an
        effect is claimed, and ``next/*.yaml``.
    name : str
        Name of the store, for the title of the page.
    done : StoreDiagnosis
    document : dict
        As `store_document` returns it.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = [folder / "report.html", folder / "diagnosis.json"]
    effects, proposals = effects_file(done, document), document["next_trials"]["proposals"]
    trials = {folder / NEXT / f"{proposal['trial']}.yaml": proposal for proposal in proposals}
    claimed = [] if effects is None else [folder / EFFECTS]
    remove_earlier(folder, [*claimed, *trials])
    for path in claimed:
        write_json_atomic(path, effects)
    for path, proposal in trials.items():
        write_atomic(path, marked_yaml(yaml.safe_dump(proposal["scenario"], sort_keys=False), "diagnose"))
    written += [*claimed, *trials]
    rows = [(proposal["title"], f"{NEXT}/{path.name}") for path, proposal in trials.items()]
    # page and document last: where they are, everything is
    footer = f"{document['source']['groups']} trajectories, {document['source']['rows']} frames"
    title = f"Diagnosis of {name}"
    shown = done.shown
    page = naming_page(
        title, done.naming, shown.located, shown, rows, document["notes"], footer,
        further=_further(done), first=_sensor_sentences(done), simulated=done.simulated,
        other_steps=other_steps_section(done.naming, done.played.start, done.stated),
    )  # fmt: skip
    write_atomic(written[0], page.encode())
    write_json_atomic(written[1], document)
    return written

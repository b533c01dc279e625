"""The diagnosis of a table as a document: ``diagnosis.json`` (schemas/diagnosis.json)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tactiledata.contract.provenance import provenance
from tactiledata.contract.schema import check_document
from tactiledata.diagnose.explain import Explanation
from tactiledata.diagnose.findings import change_document, located_document
from tactiledata.diagnose.table import Table

FORMAT = "tactiledata-diagnosis/1"


def table_document(table: Table, explanation: Explanation, digest: str, seed: int) -> dict[str, Any]:
    """The same for the same table and seed."""
    residuals = table.residuals
    deviations = np.ones(len(residuals.components)) if residuals.deviations is None else residuals.deviations
    document = {
        "format": FORMAT,
        "source": {
            "kind": "table",
            "groups": residuals.unit_count,
            "rows": len(residuals.values),
            "components": [
                {"name": name, "unit": unit, "noise": float(each) if table.is_noise_known else None}
                for name, unit, each in zip(residuals.components, residuals.units, deviations, strict=True)
            ],
        },
        "answer": explanation.answer,
        "sentences": explanation.sentences(),
        "located": located_document(explanation.located),
        "left_over": None if explanation.left_over is None else located_document(explanation.left_over),
        "open_form": form_document(explanation),
        "gap": _gap(explanation),
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
    """Root mean squares of each component in its unit, on groups that had no part in the formula."""
    held, residuals = explanation.held, table.residuals
    if held is None or residuals.deviations is None:
        return []
    listed = []
    for place, name in enumerate(residuals.components):
        before, after = (
            float(residuals.deviations[place] * np.sqrt(np.mean(one[:, place] ** 2)))
            for one in (held.before, held.after)
        )
        listed.append({"component": name, "unit": residuals.units[place], "before": before, "after": after})
    return listed


def form_document(explanation: Explanation) -> dict[str, Any] | None:
    """The part ``open_form``; ``None`` where nothing was found to be explained."""
    form = explanation.form
    if form is None:
        return None
    return {
        "words": form.words,
        "definitions": list(form.definitions),
        "candidates": form.candidates,
        "false_terms_bound": form.false_terms,
        "terms": [{**vars(term), "alike": list(term.alike)} for term in form.terms],
        "behaves_like": [vars(one) for one in form.behaves_like],
        "beside": [{"parameter": one.parameter.name, "change": change_document(one)} for one in form.beside],
    }


def _gap(explanation: Explanation) -> dict[str, Any] | None:
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
    return float(value) if math.isfinite(value) else None

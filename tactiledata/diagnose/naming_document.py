"""The diagnosis of recordings as parts of a document (schemas/diagnosis.json)."""

from __future__ import annotations

import math
from typing import Any

from tactiledata.diagnose.answer import Answer
from tactiledata.diagnose.findings import change_document, located_document
from tactiledata.diagnose.gap import Gap
from tactiledata.diagnose.held_out_errors import HeldOutErrors
from tactiledata.diagnose.instability import Drift
from tactiledata.diagnose.locate import Located
from tactiledata.diagnose.name_effects import Naming
from tactiledata.diagnose.show import Shown
from tactiledata.diagnose.shown_words import shown_sentences


def naming_document(naming: Naming, located: Located, shown: Shown) -> dict[str, Any]:
    """The parts ``located``, ``left_over``, ``naming`` and ``shown``.

    Parameters
    ----------
    located : Located
        Of the plain simulation.
    """
    return {
        "located": located_document(located),
        "left_over": None if shown.left_over is None else located_document(shown.left_over),
        "naming": Answer(naming).document,
        "shown": shown_document(naming, shown),
    }


def shown_document(naming: Naming, shown: Shown) -> dict[str, Any]:
    """How much better the simulation is on what it has not seen."""
    cases = naming.cases.cases.cases
    return {
        "effects": list(shown.names),
        "tried": list(shown.tried),
        "sentences": shown_sentences(shown),
        "held_out": [_errors(one, bool(shown.names)) for one in shown.errors],
        "dependence": None if shown.flattened is None else _dependence(*shown.flattened),
        "black_box": {"explained": shown.ceiling.explained, "force": shown.ceiling_force},
        "worst": [cases[number].name for number in shown.worst()],
        "stretched": [{"words": words, "deviations": size} for words, size in shown.stretched.items()],
    }


def _errors(one: HeldOutErrors, is_claimed: bool) -> dict[str, Any]:
    before, after, floor = one.paper
    return {
        "unseen": one.unseen,
        "groups": one.groups,
        "force": _gap(one.force, "N", is_claimed and one.has_gap),
        "torque": _gap(one.torque, "N mm", is_claimed and one.has_torque_gap),
        "paper_loss": {"unit": "N", "before": before, "after": after, "floor": floor},
    }


def _gap(gap: Gap, unit: str, has_gap: bool) -> dict[str, Any]:
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
    return {
        "parameter": before.parameter,
        "covariate": before.covariate,
        "before": {"p": before.p, "change": change_document(before.change)},
        "after": {"p": after.p, "change": change_document(after.change)},
    }

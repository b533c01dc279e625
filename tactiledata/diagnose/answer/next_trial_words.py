"""Proposed trials in plain words, and as a document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tactiledata.diagnose.naming.rivals import NOTHING
from tactiledata.diagnose.next_trial.bench import closed_form
from tactiledata.diagnose.next_trial.cases import duration
from tactiledata.diagnose.next_trial.propose import SEPARATED, Proposal, Separation
from tactiledata.diagnose.next_trial.scenario import Entries, trial_scenario
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import rounded
from tactiledata.effects import EFFECTS

LEAST_CHANCE = 1e-3
"""No smaller chance is said: no rig is as well known as that."""
FARTHEST = 10.0
"""Standard deviations; larger distances are not told apart in words."""
MOST = 5
WORTH = 0.01
"""Fall of a chance below which a trial is not worth a word."""


def next_trial_sentences(proposals: Sequence[Proposal], is_more_left: bool = False) -> list[str]:
    """What to record next, and what no trial would tell; the most telling first.

    Parameters
    ----------
    is_more_left : bool
        Whether the best explanation leaves structure, which no trial between explanations is about.
    """
    if not proposals:
        return ["No two explanations are left that a further trial could tell apart."]
    found: dict[str, list[str]] = {}
    hopeless = []
    for place, first in enumerate(proposals[0].separations):
        if first.error_before < SEPARATED:
            continue
        best = min(proposals, key=lambda one: one.separations[place].error_after)
        if best.separations[place].error_after < SEPARATED:
            # the first of the list serves where it serves as well
            serving = next(one for one in proposals if one.separations[place].error_after < SEPARATED)
            found.setdefault(serving.trial.title, []).append(_apart(serving.separations[place]))
        else:
            hopeless.append(_hopeless(best.separations[place], best.trial.title))
    said = [f"{title}: {'; '.join(parts)}." for title, parts in found.items()] + hopeless
    if not said and is_more_left:
        return ["What was recorded tells the explanations that were tried apart; what is left is none of them."]
    if not said:
        return ["What was recorded tells the explanations that are left apart; no further trial is needed for that."]
    if proposals[0].bench.base is closed_form:
        said.append("These are estimates in closed form, made before anything is recorded.")
    return said


def next_trials_document(
    proposals: Sequence[Proposal],
    sensors: Entries | None = None,
    indenters: Entries | None = None,
    is_more_left: bool = False,
) -> dict[str, Any]:
    """The part ``next_trials`` of ``schemas/diagnosis.json``; what changes nothing is left out.

    Parameters
    ----------
    sensors, indenters : entries of a scenario, optional
        As `trial_scenario` takes them.
    is_more_left : bool
        As in `next_trial_sentences`.
    """
    worth = [one for one in proposals if one.gain >= WORTH or one.separates][:MOST]
    return {
        "sentences": next_trial_sentences(proposals, is_more_left),
        "in_closed_form": bool(proposals) and proposals[0].bench.base is closed_form,
        "proposals": [_document(one, sensors, indenters) for one in worth],
    }


def _document(one: Proposal, sensors: Entries | None, indenters: Entries | None) -> dict[str, Any]:
    used = dict.fromkeys(touch.indenter for touch in one.trial.touches)
    return {
        "trial": one.trial.name,
        "title": one.trial.title,
        "minutes": round(duration(one.trial) / 60.0, 2),
        "gain": one.gain,
        "pairs": [
            {
                "first": each.first,
                "second": each.second,
                "apart": [each.before, each.after],
                "error": [each.error_before, each.error_after],
            }
            for each in one.separations
        ],
        "new_indenters": [name for name in used if name not in one.bench.indenters],
        "caveat": one.trial.caveat,
        "scenario": trial_scenario(one.trial, one.bench, sensors, indenters),
    }


def _title(name: str) -> str:
    return joined_names([EFFECTS[part]().title for part in name.split(" + ")])


def _apart(one: Separation) -> str:
    size = f"more than {FARTHEST:g}" if one.after > FARTHEST else rounded(one.after)
    if one.second == NOTHING:
        return (
            f"{_title(one.first)} as strong as it may be would stand out by {size} standard deviations"
            f" (so far {rounded(one.before)})"
        )
    return (
        f"{_title(one.first)} and {_title(one.second)} then differ by {size} standard deviations (so far"
        f" {rounded(one.before)}); the chance to take one for the other falls from {_chance(one.error_before)} to"
        f" {_chance(one.error_after)}"
    )


def _hopeless(one: Separation, title: str) -> str:
    stays = f"at best ({title}) the chance of a wrong answer is {_chance(one.error_after)}"
    if one.second == NOTHING:
        return f"None of the trials would show {_title(one.first)}: {stays}."
    return f"None of the trials tells {_title(one.first)} from {_title(one.second)}: {stays}."


def _chance(value: float) -> str:
    return "less than 0.1 %" if value < LEAST_CHANCE else f"{rounded(100 * value)} %"

"""Proposed trials in sentences, and as a document."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tactiledata.diagnose.next_trial.bench import closed_form
from tactiledata.diagnose.next_trial.cases import duration
from tactiledata.diagnose.next_trial.propose import SEPARATED, Proposal, Separation
from tactiledata.diagnose.next_trial.rivals import NO_CLAIM, NOTHING
from tactiledata.diagnose.next_trial.scenario import Entries, trial_scenario
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import rounded
from tactiledata.effects import EFFECTS

LEAST_CHANCE = 1e-3
"""Smallest probability that is stated: no rig is known better."""
FARTHEST = 10.0
"""Largest distance that is stated as a number, in standard deviations."""
MOST = 5
"""Most trials in a document."""
WORTH = 0.01
"""Smallest fall of a probability for which a trial is proposed."""


def next_trial_sentences(proposals: Sequence[Proposal], is_more_left: bool = False) -> list[str]:
    """Return sentences on what to record next, the best trial first, and on pairs that no trial would separate.

    Parameters
    ----------
    proposals : sequence of Proposal
        The best first.
    is_more_left : bool
        Whether the best explanation leaves structure, which a trial that compares explanations is not about.
    """
    if not proposals:
        return ["No two explanations are left that a further trial could tell apart."]
    # each pair that is not separated yet, with the first trial that would separate it
    by_trial: dict[str, list[str]] = {}
    hopeless = []
    for place, first in enumerate(proposals[0].separations):
        if first.error_before < SEPARATED:
            continue
        best = min(proposals, key=lambda proposal: proposal.separations[place].error_after)
        if best.separations[place].error_after < SEPARATED:
            # an earlier trial is preferred: it separates other pairs better
            chosen = next(trial for trial in proposals if trial.separations[place].error_after < SEPARATED)
            by_trial.setdefault(chosen.trial.title, []).append(_apart(chosen.separations[place]))
        else:
            hopeless.append(_hopeless(best.separations[place], best.trial.title))
    sentences = [f"{title}: {'; '.join(parts)}." for title, parts in by_trial.items()] + hopeless
    if not sentences:
        return [_told_apart(worth_recording(proposals), is_more_left)]
    if proposals[0].bench.base is closed_form:
        sentences.append("These are estimates in closed form, made before anything is recorded.")
    return sentences


def next_trials_document(
    proposals: Sequence[Proposal],
    sensors: Entries | None = None,
    indenters: Entries | None = None,
    is_more_left: bool = False,
) -> dict[str, Any]:
    """Return the part ``next_trials`` of ``schemas/diagnosis.json``: sentences, and the trials with their scenarios.

    Parameters
    ----------
    proposals : sequence of Proposal
        The best first; those of `worth_recording` are listed.
    sensors, indenters : dict, name -> entry of a scenario, optional
        Entries of one's own for the scenarios, as `trial_scenario` takes them.
    is_more_left : bool
        Whether the best explanation leaves structure; where nothing is to be separated, a sentence then says so.
    """
    return {
        "sentences": next_trial_sentences(proposals, is_more_left),
        "in_closed_form": bool(proposals) and proposals[0].bench.base is closed_form,
        "proposals": [_proposal_document(proposal, sensors, indenters) for proposal in worth_recording(proposals)],
    }


def worth_recording(proposals: Sequence[Proposal]) -> list[Proposal]:
    """Return the trials that are worth their time, at most `MOST`.

    A trial is left out where it separates no pair of explanations and lowers the probability of taking one for the
    other by less than `WORTH` on average.
    """
    return [proposal for proposal in proposals if proposal.separates or proposal.gain >= WORTH][:MOST]


def _told_apart(worth: Sequence[Proposal], is_more_left: bool) -> str:
    """Return that the recordings separate all pairs already, and which trials would do so more surely."""
    titles = " or ".join(proposal.trial.title for proposal in worth)
    surer = f" They would be told apart more surely with a further trial: {titles}." if worth else ""
    if is_more_left:
        told = "The recordings separate the explanations that were tried, and none of these explains what is left."
    else:
        told = "These recordings tell the explanations that were tried apart" + (
            "." if worth else ": no trial is proposed."
        )
    return told + surer


def _proposal_document(proposal: Proposal, sensors: Entries | None, indenters: Entries | None) -> dict[str, Any]:
    """Return a proposal as schemas/diagnosis.json has it (``next_trials.proposals``)."""
    used = dict.fromkeys(touch.indenter for touch in proposal.trial.touches)
    return {
        "trial": proposal.trial.name,
        "title": proposal.trial.title,
        "minutes": round(duration(proposal.trial) / 60.0, 2),
        "gain": proposal.gain,
        "pairs": [
            {
                "first": pair.first,
                "second": pair.second,
                "apart": [pair.before, pair.after],
                "error": [pair.error_before, pair.error_after],
            }
            for pair in proposal.separations
        ],
        "new_indenters": [name for name in used if name not in proposal.bench.indenters],
        "caveat": proposal.trial.caveat,
        "scenario": trial_scenario(proposal.trial, proposal.bench, sensors, indenters),
    }


def _title(name: str) -> str:
    """Return the titles of an explanation's effects in words."""
    return joined_names([EFFECTS[part]().title for part in name.split(" + ")])


def _apart(pair: Separation) -> str:
    """Return how far a trial separates two explanations."""
    size = f"more than {FARTHEST:g}" if pair.after > FARTHEST else rounded(pair.after)
    if pair.second == NOTHING:
        return (
            f"{_title(pair.first)} at its strongest would stand out by {size} standard deviations"
            f" (so far {rounded(pair.before)})"
        )
    if pair.second == NO_CLAIM:
        return (
            f"{_title(pair.first)} as it was fitted would stand out by {size} standard deviations; so far it has the"
            " evidence that it needs, and another rule keeps it from being claimed"
        )
    return (
        f"{_title(pair.first)} and {_title(pair.second)} then differ by {size} standard deviations (so far"
        f" {rounded(pair.before)}); the probability of taking one for the other falls from"
        f" {_chance(pair.error_before)} to {_chance(pair.error_after)}"
    )


def _hopeless(pair: Separation, title: str) -> str:
    """Return that no trial separates two explanations, with the best trial."""
    stays = f"at best ({title}) the probability of a wrong answer is {_chance(pair.error_after)}"
    if pair.second in (NOTHING, NO_CLAIM):
        return f"None of the trials would show {_title(pair.first)}: {stays}."
    return f"None of the trials tells {_title(pair.first)} from {_title(pair.second)}: {stays}."


def _chance(value: float) -> str:
    """Return a probability in per cent; nothing smaller than `LEAST_CHANCE` is stated."""
    return "less than 0.1 %" if value < LEAST_CHANCE else f"{rounded(100 * value)} %"

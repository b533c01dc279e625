"""What an effect adds beside another one: whether two are needed, one suffices, or one stands whatever the other is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactiledata.diagnose.naming.evidence import MOST_INFLUENTIAL, ScoredCandidate
from tactiledata.diagnose.naming.metric import RandomEffects, best_imitation
from tactiledata.diagnose.naming.thresholds import DecisionThresholds
from tactiledata.diagnose.naming.ties import is_lead_confirmed
from tactiledata.effects import EFFECTS


def needed_of(
    pair: ScoredCandidate, singles: Sequence[ScoredCandidate], thresholds: DecisionThresholds
) -> ScoredCandidate:
    """Return a pair, or the one of its two effects that suffices where the other adds too little.

    An effect suffices where there are objections to the other one beside it (`objections_beside`). One with an
    implausible strength suffices only as the whole cause. Where either effect suffices, the one with more evidence is
    returned.

    Parameters
    ----------
    pair : ScoredCandidate
        Candidate with two effects.
    singles : sequence of ScoredCandidate
        Candidates with one effect, both effects of the pair among them.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    first, second = (next(single for single in singles if single.names == (name,)) for name in pair.names)
    sufficient = [
        one
        for one, other in ((first, second), (second, first))
        if (not one.implausible or one.is_whole_cause(thresholds)) and objections_beside(pair, one, other, thresholds)
    ]
    return max(sufficient, key=lambda one: one.evidence, default=pair)


def objections_to(
    candidate: ScoredCandidate, singles: Sequence[ScoredCandidate], thresholds: DecisionThresholds
) -> tuple[str, ...]:
    """Return sentences that say why a candidate is not claimed: of a pair, also why one of its effects suffices.

    Parameters
    ----------
    candidate : ScoredCandidate
        Candidate with one effect or two.
    singles : sequence of ScoredCandidate
        Candidates with one effect; both effects of a pair are among them.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    objections = candidate.objections(thresholds)
    if objections or len(candidate.names) < 2:
        return objections
    needed = needed_of(candidate, singles, thresholds)
    if needed is candidate:
        return ()
    other = next(one for one in singles if set(one.names) == set(candidate.names) - set(needed.names))
    return objections_beside(candidate, needed, other, thresholds)


def objections_beside(
    pair: ScoredCandidate, first: ScoredCandidate, second: ScoredCandidate, thresholds: DecisionThresholds
) -> tuple[str, ...]:
    """Return sentences on why the second effect of a pair adds too little beside the first; empty where it adds enough.

    What it adds is the evidence of the pair less that of the first effect alone. There are four objections. Errors of
    the simulation can bring as much: it is below the evidence that a claim of the second effect needs. A first effect
    whose form is a little off can leave as much: it is below ``second_share`` times the evidence of the first effect,
    or below ``remainder_share`` times that of either effect alone. Errors of the simulation resemble the second effect,
    and trajectories do not agree on it beside the first by ``signature_threshold``: such errors differ from touch to
    touch, but bring evidence and gains. Trajectories that were held out do not confirm it (`_confirms_second`).

    Parameters
    ----------
    pair : ScoredCandidate
        Candidate with two effects.
    first, second : ScoredCandidate
        Candidates with one of these effects each.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    name = second.names[0]
    beside = f"beside {EFFECTS[first.names[0]]().title}, {EFFECTS[name]().title}"
    adds, needs = pair.evidence - first.evidence, thresholds.with_errors(pair.error_size).claim(name)
    reasons = []
    if adds < needs:
        reasons.append(
            f"{beside} adds an evidence of {adds:.1f}, and errors of the simulation alone can bring up to {needs:.0f}"
        )
    elif adds < max(
        thresholds.second_share * first.evidence, thresholds.remainder_share * min(first.evidence, second.evidence)
    ):
        reasons.append(f"{beside} adds an evidence of {adds:.1f} only, which the first can bring if its form is off")
    agrees = pair.agreement_beside.get(name, np.inf)
    if agrees < thresholds.signature_threshold and thresholds.is_resembled((name,)):
        reasons.append(f"{beside} is not what the trajectories agree on ({agrees:.1f} standard errors)")
    if not _confirms_second(pair, first, needs, thresholds):
        reasons.append(f"{beside} is not confirmed by held-out trajectories")
    return tuple(reasons)


def _confirms_second(
    pair: ScoredCandidate, single: ScoredCandidate, needs: float, thresholds: DecisionThresholds
) -> bool:
    """Return whether held-out trajectories are predicted better with the second effect than with the other one alone.

    The gain of the pair less that of the single is positive, and has ``gain_sigmas`` standard errors; or the evidence
    that a claim of the second needs is added without the two trajectories that add most.
    """
    added = np.sort(pair.evidence_per_trajectory - single.evidence_per_trajectory)[:-MOST_INFLUENTIAL]
    is_positive = (pair.gains - single.gains).sum() > 0
    return bool(is_positive and (is_lead_confirmed(pair, single, thresholds) or added.sum() >= needs))


def is_far_ahead(one: ScoredCandidate, best: ScoredCandidate, thresholds: DecisionThresholds) -> bool:
    """Return whether an effect has more evidence beyond its need than another, by more than the margin of a tie.

    Parameters
    ----------
    one, best : ScoredCandidate
        The effect, and the other one.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    margin = thresholds.tie_margin(one.evidence, (*one.names, *best.names))
    return one.beyond(thresholds) - best.beyond(thresholds) > margin


def stands_beside(
    best: ScoredCandidate, other: ScoredCandidate, pairs: Sequence[ScoredCandidate], thresholds: DecisionThresholds
) -> bool:
    """Return whether an effect is there whatever another one is that only looks like errors of the simulation.

    Such errors can bring all the evidence of the other effect, and do not resemble the first one. Beside the other, in
    a refit of both, the first one keeps ``remainder_share`` of its evidence, and the evidence that it needs.

    Parameters
    ----------
    best, other : ScoredCandidate
        The effect, and the other one.
    pairs : sequence of ScoredCandidate
        Candidates with two effects; without the one of these two nothing is known.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    pair = next((pair for pair in pairs if set(pair.names) == {*best.names, *other.names}), None)
    if pair is None or not _may_be_errors(other, best, thresholds):
        return False
    needed = thresholds.with_errors(pair.error_size).needed(best.names)
    return pair.evidence - other.evidence >= max(needed, thresholds.remainder_share * best.evidence)


def _may_be_errors(other: ScoredCandidate, best: ScoredCandidate, thresholds: DecisionThresholds) -> bool:
    """Return whether errors of the simulation can bring all evidence of an effect, and do not resemble another one."""
    is_like_errors = thresholds.is_resembled(other.names) and not thresholds.is_resembled(best.names)
    return is_like_errors and other.evidence < other.needed(thresholds)


def is_wider_by_errors(
    wider: ScoredCandidate, best: ScoredCandidate, metric: RandomEffects, thresholds: DecisionThresholds
) -> bool:
    """Return whether an effect contains another one, and has no more evidence beyond it than errors can bring.

    It has more numbers, could change what the other one changes (cosine above ``tie``), and errors of the simulation
    resemble it: they speak for the wider effect, whatever of it is there. Held-out trajectories do not confirm that it
    explains more (`ties.is_lead_confirmed`).

    Parameters
    ----------
    wider, best : ScoredCandidate
        The wider effect, and the other one.
    metric : RandomEffects
        Metric of the plain fit.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    brought = thresholds.with_errors(wider.error_size).needed(wider.names)
    return (
        thresholds.is_resembled(wider.names)
        and len(wider.fit.model.coordinates) > len(best.fit.model.coordinates)
        and wider.evidence - best.evidence < brought
        and not is_lead_confirmed(wider, best, thresholds)
        and best_imitation(metric, best.fit.effect_change, wider.fit.effect_fields) > thresholds.tie
    )


def stands_beside_larger(
    best: ScoredCandidate,
    ranked: Sequence[ScoredCandidate],
    pairs: Sequence[ScoredCandidate],
    thresholds: DecisionThresholds,
) -> bool:
    """Return whether an effect is there whatever the larger ones are that only look like errors of the simulation.

    Parameters
    ----------
    best : ScoredCandidate
        The effect.
    ranked, pairs : sequences of ScoredCandidate
        Candidates with one effect and with two.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    larger = [one for one in ranked if one.evidence > best.evidence]
    return bool(larger) and all(stands_beside(best, one, pairs, thresholds) for one in larger)


def pairs_in_question(
    singles: Sequence[ScoredCandidate], pairs: Sequence[ScoredCandidate], thresholds: DecisionThresholds
) -> list[tuple[ScoredCandidate, ScoredCandidate]]:
    """Return the pairs of effects whose refit decides on a name, and is not among ``pairs``: larger and smaller effect.

    The smaller one could be claimed, and errors of the simulation do not resemble it. They do resemble the larger one,
    and can bring all its evidence (`stands_beside`).

    Parameters
    ----------
    singles, pairs : sequences of ScoredCandidate
        Candidates with one effect and with two.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    known = {frozenset(pair.names) for pair in pairs}
    claimable = [one for one in singles if not one.objections(thresholds)]
    return [
        (larger, one)
        for one in claimable
        for larger in singles
        if larger.evidence > one.evidence
        and _may_be_errors(larger, one, thresholds)
        and frozenset((*larger.names, *one.names)) not in known
    ]

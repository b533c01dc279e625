"""From scored candidates to the answer: an effect, a set of them, or that nothing can be named.

`tactiledata.diagnose.naming.evidence` defines gain, evidence, signature statistic, excess, objection and trace. Here:

claim
    The effect, or the pair, that the answer names: the candidate with most evidence among those without objections.
tie
    Another effect that explains the data about as well as the claim, so that these data cannot decide between the two.
    A claim and its ties are a set.
structure
    What the best fit leaves where that is more than noise in most trajectories (`RemainingStructure`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.evidence import MOST_INFLUENTIAL, ScoredCandidate, error_of_sum
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.thresholds import DecisionThresholds
from tactiledata.diagnose.naming.ties import Tie, special_case_of, ties_of_one
from tactiledata.diagnose.verdict import Verdict
from tactiledata.effects import EFFECTS

NONE, OTHER = "none", "other"


@dataclass(frozen=True)
class Decision:
    """The answer, with the candidate that it is about and what speaks for and against it.

    Parameters
    ----------
    verdict : Verdict
        "explained" and "partly explained" are claims; "below detection" is a trace; "not explained" and "nothing found"
        name no effect.
    best : ScoredCandidate, optional
        The claim; the trace where the verdict is "below detection"; otherwise the nearest candidate. ``None`` where
        nothing was refitted.
    ties : tuple of Tie
        Effects that these data cannot tell from ``best``.
    probabilities : dict, label -> probability
        Of each candidate, of ``NONE`` (nothing is missing) and of ``OTHER`` (an effect outside the catalogue).
    objections : tuple of str
        Why ``best`` is not named; empty where it is.
    left : RemainingStructure
        What the best fit leaves of held-out trajectories.
    is_more_left : bool
        Whether the best fit leaves structure, or more than noise beside a candidate that is rejected for it.
    """

    verdict: Verdict
    best: ScoredCandidate | None
    ties: tuple[Tie, ...]
    probabilities: dict[str, float]
    objections: tuple[str, ...]
    left: RemainingStructure
    is_more_left: bool

    @property
    def claimed(self) -> tuple[str, ...]:
        """Names of the effects that are claimed; empty where none is."""
        is_claim = self.verdict in (Verdict.EXPLAINED, Verdict.PARTLY_EXPLAINED)
        return self.best.names if is_claim and self.best is not None else ()


def claim_verdict(is_more_left: bool, left: RemainingStructure, thresholds: DecisionThresholds) -> Verdict:
    """Return the verdict of a claim: partly explained where structure is left, be it in two trajectories only.

    Parameters
    ----------
    is_more_left : bool
        Whether the best fit leaves structure in most trajectories.
    left : RemainingStructure
        What the best fit leaves of held-out trajectories.
    thresholds : DecisionThresholds
        What counts as structure.
    """
    return Verdict.PARTLY_EXPLAINED if is_more_left or left.is_in_few(thresholds) else Verdict.EXPLAINED


def decide(
    singles: Sequence[ScoredCandidate],
    pairs: Sequence[ScoredCandidate],
    gains: dict[str, Array],
    metric: RandomEffects,
    left: RemainingStructure,
    thresholds: DecisionThresholds,
) -> Decision:
    """Return the answer to which effect the simulation lacks, with probabilities.

    Parameters
    ----------
    singles, pairs : sequences of ScoredCandidate
        Refits with one effect and with two. Each effect of a pair is also among the singles.
    gains : dict, label -> (t,)
        Gain of each candidate in each trajectory.
    metric : RandomEffects
        Metric of the plain fit: what its refit could imitate counts for nothing.
    left : RemainingStructure
        What the best of all fits leaves of held-out trajectories.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    decision = _decided(singles, pairs, gains, metric, left, thresholds)
    candidates = [*singles, *pairs]
    in_set = {decision.claimed, *((tie.name,) for tie in decision.ties)} if decision.claimed else set()
    shares = thresholds.shares(
        np.array([one.share_of_need(thresholds) for one in candidates]),
        np.array([one.names in in_set for one in candidates], dtype=bool),
        left.is_structure(thresholds),
    )
    labels = [*(candidate.label for candidate in candidates), NONE, OTHER]
    return replace(decision, probabilities=dict(zip(labels, shares.tolist(), strict=True)))


def _decided(
    singles: Sequence[ScoredCandidate],
    pairs: Sequence[ScoredCandidate],
    gains: dict[str, Array],
    metric: RandomEffects,
    left: RemainingStructure,
    thresholds: DecisionThresholds,
) -> Decision:
    """Answer without probabilities; the parameters are those of `decide`."""
    is_left = left.is_structure(thresholds)
    # candidates in the order of their evidence beyond what errors of the simulation can bring
    ranked = sorted(singles, key=lambda single: -single.beyond(thresholds))
    # the first single without objections, unless one that is objected to has far more beyond, and explains it as well
    best = next((single for single in ranked if not single.objections(thresholds)), None)
    if best is not None:
        before = [one for one in ranked[: ranked.index(best)] if _is_far_ahead(one, best, thresholds)]
        is_behind = any(not _stands_beside(best, one, pairs, thresholds) for one in before)
        best = None if is_behind else special_case_of(best, ranked, metric, thresholds)
    # a pair replaces it where both of its effects are needed
    needed = [needed_of(pair, singles, thresholds) for pair in pairs if not pair.objections(thresholds)]
    best = max((*([best] if best is not None else []), *needed), key=_evidence, default=None)
    # an effect that removes the smaller part of what is beyond the noise may stand in for something else, above all
    # one that resembles errors of the simulation
    is_more_than_noise = left.without_worst_two > thresholds.noise_dispersion and not left.is_in_few(thresholds)
    is_small = best is not None and best.excess_share < thresholds.cause_share(best.names)
    if best is not None and is_more_than_noise and is_small and not best.is_decisive(thresholds):
        return Decision(
            Verdict.NOT_EXPLAINED, best, (), {},
            (
                f"only {100 * best.excess_share:.0f} % of the excess over the noise is gone, and more than the noise"
                " is left",
            ),
            left, True,
        )  # fmt: skip
    # no name where errors of the simulation resemble the best effect and several others explain about as much
    crowd = [] if best is None or len(best.names) > 1 else _crowd(best, ranked, thresholds)
    if best is not None and crowd:
        reason = f"{len(crowd)} other effects explain nearly as much: these data do not say which it is"
        return Decision(Verdict.NOT_EXPLAINED, best, (), {}, (reason,), left, True)
    # no name where the data show more of an effect that cannot be claimed
    outweighing = None if best is None else _outweighing(best, ranked, thresholds)
    if best is not None and outweighing is not None:
        reason = (
            f"the evidence of {outweighing.label} is {outweighing.evidence:.0f}, that of {best.label}"
            f" {best.evidence:.0f}, and {outweighing.label} cannot be claimed"
        )
        return Decision(Verdict.NOT_EXPLAINED, best, (), {}, (reason,), left, True)
    # a claim; ties of a pair need further refits and follow in `ties.ties_of_two`
    if best is not None:
        ties = ties_of_one(best, ranked, gains, metric, thresholds) if len(best.names) == 1 else ()
        return Decision(claim_verdict(is_left, left, thresholds), best, ties, {}, (), left, is_left)
    # no claim: structure, a trace, or nothing
    hint = ranked[0] if ranked else None
    objections = hint.objections(thresholds) if hint is not None else ()
    if is_left or any(single.is_structure(thresholds) for single in singles):
        return Decision(Verdict.NOT_EXPLAINED, hint, (), {}, objections, left, is_left)
    trace = next((single for single in ranked if single.is_trace(thresholds)), None)
    if trace is not None:
        ties = ties_of_one(trace, ranked, gains, metric, thresholds)
        objections = trace.objections(thresholds)
        return Decision(Verdict.BELOW_DETECTION, trace, ties, {}, objections, left, is_left)
    return Decision(Verdict.NOTHING_FOUND, hint, (), {}, objections, left, is_left)


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
    return max(sufficient, key=_evidence, default=pair)


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
    gains = pair.gains - single.gains
    added = np.sort(pair.evidence_per_trajectory - single.evidence_per_trajectory)[:-MOST_INFLUENTIAL]
    is_more = gains.sum() >= thresholds.gain_sigmas * error_of_sum(gains)
    return bool(gains.sum() > 0 and (is_more or added.sum() >= needs))


def _is_far_ahead(one: ScoredCandidate, best: ScoredCandidate, thresholds: DecisionThresholds) -> bool:
    """Return whether an effect has more evidence beyond its need than another, by more than the margin of a tie."""
    margin = thresholds.tie_margin(one.evidence, (*one.names, *best.names))
    return one.beyond(thresholds) - best.beyond(thresholds) > margin


def _stands_beside(
    best: ScoredCandidate, other: ScoredCandidate, pairs: Sequence[ScoredCandidate], thresholds: DecisionThresholds
) -> bool:
    """Return whether an effect is there whatever another one is that only looks like errors of the simulation.

    Such errors can bring all the evidence of the other effect, and do not resemble the first one. Beside the other, in
    a refit of both, the first one keeps ``remainder_share`` of its evidence, and the evidence that it needs.
    """
    if thresholds.is_resembled(best.names) or not thresholds.is_resembled(other.names):
        return False
    pair = next((pair for pair in pairs if set(pair.names) == {*best.names, *other.names}), None)
    if pair is None or other.evidence >= other.needed(thresholds):
        return False
    needed = thresholds.with_errors(pair.error_size).needed(best.names)
    return pair.evidence - other.evidence >= max(needed, thresholds.remainder_share * best.evidence)


def _evidence(candidate: ScoredCandidate) -> float:
    """Return the evidence of a candidate, by which candidates are compared."""
    return candidate.evidence


def _crowd(
    best: ScoredCandidate, ranked: Sequence[ScoredCandidate], thresholds: DecisionThresholds
) -> list[ScoredCandidate]:
    """Return the other single effects with nearly the evidence of the best, where they are too many for a name."""
    if not thresholds.is_resembled(best.names):
        return []
    near = [one for one in ranked if one is not best and one.evidence >= thresholds.crowd_share * best.evidence]
    return near if len(near) >= thresholds.crowd else []


def _outweighing(
    best: ScoredCandidate, ranked: Sequence[ScoredCandidate], thresholds: DecisionThresholds
) -> ScoredCandidate | None:
    """Return the single effect that takes the name of the best one, or of two, away, if any.

    It has ``outweighed`` times the evidence, cannot be claimed, and acts in the same slot; or it is any such effect
    where errors of the simulation resemble the best one, and agreement does not tell it from them (`is_confirmed`). Of
    several, the one with most evidence is returned.
    """
    slots = {str(EFFECTS[name].slot) for name in best.names}
    is_like_errors = thresholds.is_resembled(best.names) and not best.is_confirmed(thresholds)
    more = [
        one
        for one in ranked
        if one.evidence > thresholds.outweighed * best.evidence
        and one.objections(thresholds)
        and not set(one.names) & set(best.names)
        and (is_like_errors or EFFECTS[one.names[0]].slot in slots)
    ]
    return max(more, key=_evidence, default=None)

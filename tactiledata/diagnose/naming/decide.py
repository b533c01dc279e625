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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.beside import (
    is_far_ahead,
    is_wider_by_errors,
    needed_of,
    stands_beside,
    stands_beside_larger,
)
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.thresholds import DecisionThresholds
from tactiledata.diagnose.naming.ties import Tie, special_case_of, ties_of_one
from tactiledata.diagnose.verdict import Verdict
from tactiledata.effects import EFFECTS

BESIDE, NONE, OTHER = "beside", "none", "other"
"""Labels of the probabilities that belong to no candidate: of another effect beside one, of nothing, of an effect that
the catalogue does not have."""


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
        Of each candidate alone, of ``BESIDE`` (a candidate and another effect, which no refit tells), of ``NONE``
        (nothing is missing) and of ``OTHER`` (an effect outside the catalogue).
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


def probability_of(names: Sequence[str], probabilities: Mapping[str, float]) -> float:
    """Return the probability that effects are missing, alone or with another effect.

    Parameters
    ----------
    names : sequence of str
        Effects of a candidate.
    probabilities : dict, label -> probability
        See `Decision`.
    """
    shares = {label: share for label, share in probabilities.items() if label not in (BESIDE, NONE, OTHER)}
    own = sum(share for label, share in shares.items() if set(names) <= set(label.split(" + ")))
    # the other effect may be beside each candidate
    return own * (1.0 + probabilities.get(BESIDE, 0.0) / sum(shares.values())) if own else 0.0


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
        [one.names for one in candidates],
        left.is_structure(thresholds),
    )
    labels = [*(candidate.label for candidate in candidates), BESIDE, NONE, OTHER]
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
        before = [one for one in ranked[: ranked.index(best)] if is_far_ahead(one, best, thresholds)]
        is_behind = any(
            not stands_beside(best, one, pairs, thresholds) and not is_wider_by_errors(one, best, metric, thresholds)
            for one in before
        )
        best = None if is_behind else special_case_of(best, ranked, metric, thresholds)
    # a pair replaces it where both of its effects are needed
    needed = [needed_of(pair, singles, thresholds) for pair in pairs if not pair.objections(thresholds)]
    best = max((*([best] if best is not None else []), *needed), key=_evidence, default=None)
    # an effect that removes the smaller part of what is beyond the noise may stand in for something else, above all
    # one that resembles errors of the simulation; unless these explain the larger part, and it keeps its own beside it
    is_more_than_noise = left.without_worst_two > thresholds.noise_dispersion and not left.is_in_few(thresholds)
    is_small = (
        best is not None
        and best.excess_share < thresholds.cause_share(best.names)
        and not best.is_decisive(thresholds)
        and not stands_beside_larger(best, ranked, pairs, thresholds)
    )
    if best is not None and is_more_than_noise and is_small:
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
    outweighing = None if best is None else _outweighing(best, ranked, metric, thresholds)
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
    best: ScoredCandidate, ranked: Sequence[ScoredCandidate], metric: RandomEffects, thresholds: DecisionThresholds
) -> ScoredCandidate | None:
    """Return the single effect that takes the name of the best one, or of two, away, if any.

    It has ``outweighed`` times the evidence, cannot be claimed, and acts in the same slot; or it is any such effect
    where errors of the simulation resemble the best one, and agreement does not tell it from them (`is_confirmed`). One
    that contains the best one, and has no more beyond it than errors can bring, takes no name (`is_wider_by_errors`).
    Of several, the one with most evidence is returned.
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
        and not is_wider_by_errors(one, best, metric, thresholds)
    ]
    return max(more, key=_evidence, default=None)

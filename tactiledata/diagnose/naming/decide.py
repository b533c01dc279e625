"""From what refits have gained to an answer: an effect, a set of them, or that there is none to be named."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.evidence import ScoredCandidate, error_of_sum
from tactiledata.diagnose.naming.metric import RandomEffects, best_imitation, cosines
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.thresholds import DecisionThresholds

Verdict = Literal["nothing is missing", "below detection", "named", "one of a set", "none of the known effects"]
NONE, OTHER = "none", "other"


@dataclass(frozen=True)
class Tie:
    """An effect that cannot be told from the one that was named.

    Parameters
    ----------
    name : str
    instead_of : str
        The one that was named; one of the two where two are.
    label : str
        Of the refit with it.
    cosine : float
        Of what the named one changes, beyond what a refit imitates, with the nearest that this one can change.
    gain_apart, error : float
        How much more the named one gains where it was not fitted, and its standard error over trajectories.
    """

    name: str
    instead_of: str
    label: str
    cosine: float
    gain_apart: float
    error: float


@dataclass(frozen=True)
class Decision:
    """What is said.

    Parameters
    ----------
    verdict : Verdict
    best : ScoredCandidate, optional
        What is named, or would be if the evidence sufficed.
    ties : tuple of Tie
    probabilities : dict, label -> probability
        Of each candidate, of "none" and of "other".
    objections : tuple of str
        Why ``best`` is not named; empty where it is.
    left : RemainingStructure
        What the best fit leaves of trajectories held out.
    is_more_left : bool
        Whether that is structure still.
    """

    verdict: Verdict
    best: ScoredCandidate | None
    ties: tuple[Tie, ...]
    probabilities: dict[str, float]
    objections: tuple[str, ...]
    left: RemainingStructure
    is_more_left: bool


def decide(
    singles: Sequence[ScoredCandidate],
    pairs: Sequence[ScoredCandidate],
    gains: dict[str, Array],
    metric: RandomEffects,
    left: RemainingStructure,
    scale: DecisionThresholds,
) -> Decision:
    """The answer.

    Parameters
    ----------
    gains : label -> (t,)
        Held-out gain of each candidate by trajectory.
    metric : RandomEffects
        What a refit of the plain simulation could imitate.
    left : RemainingStructure
        What the best fit leaves.
    """
    is_left = left.is_structure(scale)
    chances = _probabilities(singles, pairs, scale, is_left)
    ranked = sorted(singles, key=lambda one: -one.gain_lower_bound(scale))
    best = max((one for one in singles if not one.objections(scale)), key=_evidence, default=None)
    if best is not None and _exceeds(gains[ranked[0].label] - gains[best.label], scale):
        # another explains far more, and yet cannot be believed: what is there is not what could be
        best = None
    # of the pairs that surely gain more: the one with most evidence may gain it from few touches
    gaining = [one for one in pairs if best is None or _exceeds(gains[one.label] - gains[best.label], scale)]
    pair = max((one for one in gaining if not one.objections(scale)), key=_evidence, default=None)
    if pair is not None:
        best = needed_of(pair, singles, scale)
    is_much = left.without_worst_two > scale.noise and not left.is_in_few(scale)
    if best is not None and is_much and best.excess_share < scale.explains:
        # it takes off the smaller part of what is there: something else is, and takes this one's place
        return Decision(
            "none of the known effects", best, (), chances,
            (f"{100 * best.excess_share:.0f} % of the excess gone, and more than the noise is left",), left, True,
        )  # fmt: skip
    if best is not None:
        ties = _ties(best, ranked, gains, metric, scale) if len(best.names) == 1 else ()
        verdict: Verdict = "one of a set" if ties else "named"
        return Decision(verdict, best, ties, chances, (), left, is_left)
    hint = ranked[0] if ranked else None
    objections = hint.objections(scale) if hint is not None else ()
    if is_left or (hint is not None and hint.is_structure(scale)):
        return Decision("none of the known effects", hint, (), chances, objections, left, is_left)
    trace = max((one for one in singles if one.is_trace(scale)), key=_evidence, default=None)
    if trace is not None:
        ties = _ties(trace, ranked, gains, metric, scale)
        return Decision("below detection", trace, ties, chances, trace.objections(scale), left, is_left)
    return Decision("nothing is missing", hint, (), chances, objections, left, is_left)


def needed_of(pair: ScoredCandidate, singles: Sequence[ScoredCandidate], scale: DecisionThresholds) -> ScoredCandidate:
    """The pair, or one of its two where the other adds nothing of its own beside it.

    Nothing of its own is what errors of the simulation bring, too; or what the other would have explained in its place,
    had it been alone: an effect whose form is a little off leaves what looks like its look-alikes.
    """
    alone = {one.names[0]: one for one in singles}
    found = []
    for name, other in (pair.names, pair.names[::-1]):
        adds = pair.evidence - alone[name].evidence
        is_remainder = adds < scale.remainder * alone[other].evidence and adds < scale.remainder * alone[name].evidence
        if (adds < scale.claim_gain or is_remainder) and not alone[name].implausible:
            found.append(alone[name])
    return max(found, key=_evidence, default=pair)


def _evidence(one: ScoredCandidate) -> float:
    return one.evidence


def _exceeds(difference: Array, scale: DecisionThresholds) -> bool:
    return float(difference.sum()) > max(scale.claim_gain, scale.standard_errors * error_of_sum(difference))


def _ties(
    best: ScoredCandidate,
    ranked: Sequence[ScoredCandidate],
    gains: dict[str, Array],
    metric: RandomEffects,
    scale: DecisionThresholds,
) -> tuple[Tie, ...]:
    others = [
        one
        for one in ranked
        if one.label != best.label and not one.implausible and (one.gain > 0 or _rivals(one, best, scale))
    ]
    if not others:
        return ()
    alike = cosines(metric, [best.fit.effect_change, *(one.fit.effect_change for one in others)])[0, 1:]
    found = []
    for one, fitted in zip(others, alike, strict=True):
        # two fits to one noise differ by it: what the other could do counts, not only what it did
        could = best_imitation(metric, best.fit.effect_change, one.fit.of_effects)
        cosine, apart = max(float(fitted), could), gains[best.label] - gains[one.label]
        is_tied = _explains(one, best, cosine, apart, scale) and not _is_needless(one, best, could, scale)
        if is_tied or _rivals(one, best, scale):
            found.append(Tie(one.label, best.label, one.label, cosine, float(apart.sum()), error_of_sum(apart)))
    return tuple(found)


def _explains(
    one: ScoredCandidate, best: ScoredCandidate, cosine: float, apart: Array, scale: DecisionThresholds
) -> bool:
    """Whether another does for the data what the best does.

    Parameters
    ----------
    cosine : float
        Of what both change.
    apart : (t,)
        By how much more the best gains in each trajectory.
    """
    explains_as_much = not one.objections(scale) and one.gain >= scale.as_good * best.gain
    is_rival = one.gain >= scale.claim_gain and float(apart.sum()) <= scale.rival * error_of_sum(apart)
    # of few touches it can be only where the best is, too
    has_broad_support = one.evidence_without_best_two >= min(
        scale.evidence_without_best_two, best.evidence_without_best_two
    )
    # what simulators that differ bring is no proof of one against the other
    is_as_good = not _exceeds(apart, scale) and best.evidence - one.evidence <= scale.claim_gain
    return (cosine > scale.tie or explains_as_much or is_rival) and has_broad_support and is_as_good


def _rivals(one: ScoredCandidate, best: ScoredCandidate, scale: DecisionThresholds) -> bool:
    """Whether all frames together speak for another, though its gain where it was not fitted is uncertain."""
    return one.evidence >= max(best.evidence, scale.claim_gain) and one.gain + one.gain_error >= scale.claim_gain


def _is_needless(one: ScoredCandidate, best: ScoredCandidate, could: float, scale: DecisionThresholds) -> bool:
    """Whether one holds the best as a special case, with numbers more than needed: the special case is said then.

    Parameters
    ----------
    could : float
        Cosine of what the best changes with the nearest that the other can.
    """
    is_wider = could > scale.tie and len(one.fit.model.coordinates) > len(best.fit.model.coordinates)
    return is_wider and best.evidence - one.evidence > scale.needless


def ties_of_two(
    best: ScoredCandidate, twins: Sequence[tuple[ScoredCandidate, ScoredCandidate]], scale: DecisionThresholds
) -> tuple[Tie, ...]:
    """Effects that could as well stand for one of two that are named.

    Parameters
    ----------
    twins : of (the one that stays by itself, it and another)
        What the other adds to the one that stays is held against what the named one adds.
    """
    found = []
    for stays, twin in twins:
        apart = best.gains - twin.gains
        adds_as_much = twin.gain - stays.gain >= scale.as_good * (best.gain - stays.gain)
        is_beaten = _exceeds(apart, scale) or best.evidence - twin.evidence > scale.claim_gain
        could = best_imitation(stays.fit.metric, best.fit.effect_change, twin.fit.of_effects)
        is_needless = _is_needless(twin, best, could, scale)
        if twin.objections(scale) or not adds_as_much or is_beaten or is_needless:
            continue
        (named,), (other,) = ([name for name in one.names if name not in stays.names] for one in (best, twin))
        cosine = float(cosines(stays.fit.metric, [best.fit.effect_change, twin.fit.effect_change])[0, 1])
        found.append(Tie(other, named, twin.label, cosine, float(apart.sum()), error_of_sum(apart)))
    return tuple(found)


def _probabilities(
    singles: Sequence[ScoredCandidate], pairs: Sequence[ScoredCandidate], scale: DecisionThresholds, is_left: bool
) -> dict[str, float]:
    """Of what was refitted, of nothing, and of what the catalogue does not hold."""
    objected = [bool(one.objections(scale)) for one in singles]
    objected += [bool(one.objections(scale)) or needed_of(one, singles, scale) is not one for one in pairs]
    judged = [*singles, *pairs]
    shares = scale.shares(np.array([one.evidence for one in judged]), np.array(objected, dtype=bool), is_left)
    return dict(zip([*(one.label for one in judged), NONE, OTHER], shares.tolist(), strict=True))

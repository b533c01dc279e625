"""Effects that these data cannot tell from a named one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.evidence import ScoredCandidate, error_of_sum
from tactiledata.diagnose.naming.metric import RandomEffects, best_imitation, cosines
from tactiledata.diagnose.naming.thresholds import DecisionThresholds


@dataclass(frozen=True)
class Tie:
    """An effect that these data cannot tell from a named one.

    Parameters
    ----------
    name : str
        The other effect.
    instead_of : str
        The named effect for which it could stand; one of the two where two are named.
    label : str
        Label of the refit with the other effect: a pair where two are named.
    cosine : float
        Cosine, beyond what a refit imitates, of what the named effect changes with what the other one changes or, if
        that is larger, with the nearest change that the other one could make. Where two effects are named: of what
        the two pairs change, beyond what a refit with the kept effect imitates.
    gain_apart, error : float
        How much more the named candidate gains, and the standard error of that difference over trajectories.
    """

    name: str
    instead_of: str
    label: str
    cosine: float
    gain_apart: float
    error: float


def special_case_of(
    best: ScoredCandidate, ranked: Sequence[ScoredCandidate], metric: RandomEffects, thresholds: DecisionThresholds
) -> ScoredCandidate:
    """Return the special case of the best single effect that explains the data about as well; else the best one.

    A special case has fewer numbers, and what it changes the best effect could change as well (cosine above ``tie``).
    Errors of the simulation only ever speak for the wider effect. It is named where it leads by more than
    ``tie_margin``, and by more than ``wider_lead`` times the evidence that it needs by itself. Where such errors
    resemble the wider effect and not the special case, held-out trajectories must confirm the lead
    (`is_lead_confirmed`).

    Parameters
    ----------
    best : ScoredCandidate
        The single effect without objections that has most evidence beyond what it needs.
    ranked : sequence of ScoredCandidate
        All single effects, in the order of their evidence beyond what they need.
    metric : RandomEffects
        Metric of the plain fit.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    for one in ranked:
        margin = max(
            thresholds.tie_margin(best.evidence, (*best.names, *one.names)),
            thresholds.wider_lead * thresholds.needed(best.names),
        )
        # a lead that errors of the simulation can bring the wider effect alone is one if held-out data confirm it
        is_doubted = thresholds.is_resembled(best.names) and not thresholds.is_resembled(one.names)
        leads = best.beyond(thresholds) - one.beyond(thresholds) > margin
        is_wider_needed = leads and (not is_doubted or is_lead_confirmed(best, one, thresholds))
        if is_wider_needed or one.objections(thresholds):
            continue
        is_narrower = len(one.fit.model.coordinates) < len(best.fit.model.coordinates)
        if is_narrower and best_imitation(metric, one.fit.effect_change, best.fit.effect_fields) > thresholds.tie:
            return one
    return best


def is_lead_confirmed(wider: ScoredCandidate, special: ScoredCandidate, thresholds: DecisionThresholds) -> bool:
    """Return whether a wider effect gains more on held-out trajectories than a special case, by ``gain_sigmas`` errors.

    Parameters
    ----------
    wider, special : ScoredCandidate
        The two effects.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    apart = wider.gains - special.gains
    return bool(apart.sum() >= thresholds.gain_sigmas * error_of_sum(apart))


def ties_of_one(
    best: ScoredCandidate,
    ranked: Sequence[ScoredCandidate],
    gains: dict[str, Array],
    metric: RandomEffects,
    thresholds: DecisionThresholds,
) -> tuple[Tie, ...]:
    """Return the single effects that these data cannot tell from the best one, in the order of ``ranked``.

    A plausible effect is a tie where its evidence beyond what it needs is within ``tie_margin`` of the best one's, and
    where it could be claimed itself or changes what the best one changes (cosine above ``tie``). An effect that could
    be claimed itself is one as well where that holds of what both need beside errors of the simulation of the size
    found. So is one of which the best is a special case and that has more evidence, even if errors of the simulation
    could bring the lead. An effect that is needlessly wide is none.

    Parameters
    ----------
    best : ScoredCandidate
        The named effect.
    ranked : sequence of ScoredCandidate
        All single effects, in the order of their evidence beyond what they need.
    gains : dict, label -> (t,)
        Gain of each effect in each trajectory.
    metric : RandomEffects
        Metric of the plain fit.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    others = [
        other
        for other in ranked
        if other.label != best.label
        and not other.implausible
        and (other.evidence > best.evidence or _is_near(other, best, thresholds))
    ]
    if not others:
        return ()
    alike = cosines(metric, [best.fit.effect_change, *(other.fit.effect_change for other in others)])[0, 1:]
    ties = []
    for other, cosine_fitted in zip(others, alike, strict=True):
        # two fits differ by noise: what the other effect could change counts, not only what it was fitted to change
        cosine_possible = best_imitation(metric, best.fit.effect_change, other.fit.effect_fields)
        cosine, apart = max(float(cosine_fitted), cosine_possible), gains[best.label] - gains[other.label]
        contains_best = cosine_possible > thresholds.tie
        is_rival = contains_best or (
            _is_near(other, best, thresholds) and (cosine > thresholds.tie or not other.objections(thresholds))
        )
        if is_rival and not _is_needlessly_wide(other, best, cosine_possible, thresholds):
            ties.append(Tie(other.label, best.label, other.label, cosine, float(apart.sum()), error_of_sum(apart)))
    return tuple(ties)


def ties_of_two(
    best: ScoredCandidate,
    substitutes: Sequence[tuple[ScoredCandidate, ScoredCandidate]],
    thresholds: DecisionThresholds,
) -> tuple[Tie, ...]:
    """Return effects that could stand for one of two named effects.

    A substitute is a tie where it has no objections, is not beaten by evidence of ``tie_margin``, and is not needlessly
    wide.

    Parameters
    ----------
    best : ScoredCandidate
        The named pair.
    substitutes : sequence of (kept, substitute)
        The effect of the pair that is kept, scored by itself, and the pair of it with another effect.
    thresholds : DecisionThresholds
        What a claim needs.
    """
    ties = []
    for kept, substitute in substitutes:
        apart = best.gains - substitute.gains
        margin = thresholds.tie_margin(best.evidence - kept.evidence, (*best.names, *substitute.names))
        is_beaten = best.evidence - substitute.evidence > margin
        cosine_possible = best_imitation(kept.fit.metric, best.fit.effect_change, substitute.fit.effect_fields)
        is_needless = _is_needlessly_wide(substitute, best, cosine_possible, thresholds)
        if substitute.objections(thresholds) or is_beaten or is_needless:
            continue
        (named,), (other,) = ([name for name in pair.names if name not in kept.names] for pair in (best, substitute))
        cosine = float(cosines(kept.fit.metric, [best.fit.effect_change, substitute.fit.effect_change])[0, 1])
        ties.append(Tie(other, named, substitute.label, cosine, float(apart.sum()), error_of_sum(apart)))
    return tuple(ties)


def _is_near(other: ScoredCandidate, best: ScoredCandidate, thresholds: DecisionThresholds) -> bool:
    """Whether the evidence of another effect beyond what it needs is within the margin of a tie of the best one's."""
    margin = thresholds.tie_margin(best.evidence, (*best.names, *other.names))
    if best.beyond(thresholds) - other.beyond(thresholds) <= margin:
        return True
    leads = best.evidence - best.needed(thresholds) - (other.evidence - other.needed(thresholds))
    return leads <= margin and not other.objections(thresholds)


def _is_needlessly_wide(
    other: ScoredCandidate, best: ScoredCandidate, cosine_possible: float, thresholds: DecisionThresholds
) -> bool:
    """Whether the other contains the best as a special case, has more numbers and clearly less evidence.

    Parameters
    ----------
    cosine_possible : float
        Cosine of what the best changes with the nearest change that the other could make.
    """
    is_wider = cosine_possible > thresholds.tie and len(other.fit.model.coordinates) > len(best.fit.model.coordinates)
    least = thresholds.special_case_evidence * thresholds.growth((*best.names, *other.names))
    return is_wider and best.evidence - other.evidence > least

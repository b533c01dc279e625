"""Sentences on what a simulation lacks: the effect, what these data cannot tell from it, and its numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tactiledata.contract.wording import counted
from tactiledata.diagnose.naming.decide import probability_of
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.intervals import ProfiledInterval
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.own_error_sizes import OddTouch
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.simulator_share import simulator_share, simulator_share_words
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS, DecisionThresholds
from tactiledata.diagnose.naming.ties import Tie
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import rounded, with_interval
from tactiledata.diagnose.verdict import Verdict
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting, effects_document

MOST_NUMBERS = 6
"""Most numbers of a fit that are all stated; of more, only those that differ from 0."""
MOST_PROBABLE = 0.99
"""Largest probability that is stated."""
NEAR_BOUND = 0.01
"""Share of an interval within which a value counts as at its bound."""
# from SI into the units of sentences
_SCALES = {"E": (1e-3, "kPa"), "nu": (1.0, "1"), "mu": (1.0, "1")}


def preview_words(naming: NamingResult, drawn: int) -> str:
    """Return what a few of the drawn trajectories show: E, nu and mu of the plain fit, and the answer.

    Parameters
    ----------
    naming : NamingResult
        The answer to these trajectories.
    drawn : int
        Number of all trajectories that were drawn.
    """
    gel = naming.base.model.material
    told = []
    for (name, (scale, unit)), value in zip(
        _SCALES.items(), (gel.youngs_modulus, gel.poisson_ratio, gel.friction), strict=True
    ):
        told.append(f"{name} {rounded(value * scale, 3)}{'' if unit == '1' else ' ' + unit}")
    few = len(naming.whitened.touch_set.touches)
    return f"Preview, from {few} of {counted(drawn, 'trajectory')}: {joined_names(told)}. {Answer(naming).what[0]}"


def effect_numbers(intervals: Sequence[ProfiledInterval]) -> list[str]:
    """Return the numbers of the effects in a sentence, or nothing; E, nu and mu come first in ``intervals``."""
    fitted = intervals[3:]
    is_many = len(fitted) > MOST_NUMBERS
    shown = [number for number in fitted if not number.low <= 0.0 <= number.high] if is_many else fitted
    shown = shown or fitted
    numbers = [
        f"{number.name} = {rounded(number.value)} ({rounded(number.low)} to {rounded(number.high)}"
        f"){'' if number.unit == '1' else ' ' + number.unit}"
        for number in shown
    ]
    left = len(fitted) - len(shown)
    others = f" The other {left} numbers may be 0." if left else ""
    return [f"Fitted values, with 95 % intervals, are {joined_names(numbers)}.{others}"] if numbers else []


def material_moved(before: Sequence[ProfiledInterval], after: Sequence[ProfiledInterval]) -> list[str]:
    """Return in a sentence how E, nu and mu move from the plain fit to the fit with effects."""
    moves = []
    for old, new in zip(before, after[:3], strict=True):
        scale, unit = _SCALES[old.name]
        pinned = [" (at its bound)" if _is_at_bound(number) else "" for number in (old, new)]
        ends = f"{rounded(new.low * scale, 3)} to {rounded(new.high * scale, 3)}"
        shown = "" if unit == "1" else f" {unit}"
        values = [f"{rounded(number.value * scale, 3)}{note}" for number, note in zip((old, new), pinned, strict=True)]
        moves.append(f"{old.name} {values[0]} → {values[1]}{shown} ({ends})")
    return [f"Without and with the effect: {'; '.join(moves)}."]


def material_is_of(settings: Sequence[EffectSetting]) -> list[str]:
    """Return sentences on the state that E, nu and mu belong to, where an effect makes them depend on something."""
    states: dict[str, list[str]] = {}
    for setting in settings:
        values = setting.member.complete(setting.values)
        for name, state in setting.member.material_of(values).items():
            if state not in states.setdefault(name, []):
                states[name].append(state)
    # numbers that belong to the same state share a sentence
    shared = {
        tuple(state): joined_names([name for name in states if states[name] == state]) for state in states.values()
    }
    return [
        f"{names} {'are then those' if ' and ' in names else 'is then that'} of {joined_names(state)}."
        for state, names in shared.items()
    ]


def _is_at_bound(number: ProfiledInterval) -> bool:
    """Return whether a number lies at an end of its interval that is a bound of the fit."""
    near = NEAR_BOUND * (number.high - number.low)
    is_low = number.low_is_bound and number.value - number.low <= near
    return is_low or (number.high_is_bound and number.high - number.value <= near)


@dataclass(frozen=True)
class Answer:
    """The answer to which known effect a simulation lacks.

    Parameters
    ----------
    naming : NamingResult
        Fits, candidates and the decision.
    """

    naming: NamingResult

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects that are claimed; empty where none is."""
        return self.naming.decision.claimed

    @property
    def candidates(self) -> tuple[str, ...]:
        """Names of the effects that are claimed, and of those that these data cannot tell from them."""
        ties = self.naming.decision.ties if self.names else ()
        return (*self.names, *(tie.name for tie in ties))

    @property
    def verdict(self) -> Verdict:
        """The verdict by the known effects alone."""
        return self.naming.decision.verdict

    @property
    def is_missing(self) -> bool:
        """Whether physics is missing, named or not."""
        return self.verdict not in (Verdict.NOTHING_FOUND, Verdict.BELOW_DETECTION)

    @property
    def sentences(self) -> list[str]:
        """The answer in sentences: what is missing; for a claim, its fitted numbers and what E, nu and mu become."""
        return [*self.what, *self.how]

    @property
    def how(self) -> list[str]:
        """Sentences on the numbers of the simulation with the claimed effects; empty where none is claimed."""
        decision = self.naming.decision
        if decision.best is None or not self.names:
            return []
        numbers = [
            *effect_numbers(self.naming.intervals),
            *material_moved(self.naming.intervals_before, self.naming.intervals),
        ]
        errors = simulator_share_words(simulator_share(self.naming.whitened, decision.best.fit))
        return [*numbers, *material_is_of(decision.best.fit.model.settings), *_alarms(decision.best), *errors]

    @property
    def what(self) -> list[str]:
        """Sentences on what is missing, what these data cannot tell from it, and what they cannot show at all."""
        decision = self.naming.decision
        best = decision.best
        # a claim, the effects that these data cannot tell from it, and what it leaves
        if best is not None and self.names:
            sentences = [
                _claim(best, probability_of(best.names, decision.probabilities)),
                *(_tie(tie) for tie in decision.ties),
            ]
            if decision.is_more_left:
                sentences.append("The residual still has structure that no effect of the catalogue explains.")
            sentences += [*_worst_two(decision.left, "More missing"), *_odd(self.naming.odd)]
            return [*sentences, _of_the_known(best, self.naming)]
        # no claim: the verdict
        if self.verdict is Verdict.NOT_EXPLAINED:
            sentences = ["Not explained: the residual has structure, and no effect of the catalogue explains it."]
        elif self.verdict is Verdict.BELOW_DETECTION and best is not None:
            sentences = [
                f"Below detection: the differences look like {_titles(best.names)}, but they are too small, or rest on"
                " too few touches, to be told from an error of the simulation.",
                *(_tie(tie) for tie in decision.ties),
            ]
        else:
            sentences = [
                "Nothing found: noise, contact offsets and known errors of the simulation account for all differences."
            ]
        sentences += [*_worst_two(decision.left, "Missing"), *_odd(self.naming.odd)]
        # why the nearest candidate is not claimed, and what could not have been seen
        if best is not None and decision.objections:
            objections = "; ".join(decision.objections)
            sentences.append(f"The nearest candidate is {_titles(best.names)}. Against it: {objections}.")
        undetectable = self.naming.identifiable.undetectable
        if undetectable:
            sentences.append(f"Not detectable in these recordings: {_titles(undetectable)}.")
        numbers = self.naming.identifiable.undetectable_numbers
        if numbers:
            listed = joined_names([f"{number.name} ({EFFECTS[number.effect]().title})" for number in numbers])
            sentences.append(f"Of the other effects, these numbers are not detectable in these recordings: {listed}.")
        return sentences

    @property
    def document(self) -> dict[str, Any]:
        """The part ``naming`` of ``schemas/diagnosis.json``."""
        decision, naming = self.naming.decision, self.naming
        best = decision.best
        return {
            "verdict": self.verdict.value,
            "names": list(self.names),
            "sentences": self.sentences,
            "probabilities": decision.probabilities,
            "ties": [
                {
                    "name": tie.name,
                    "instead_of": tie.instead_of,
                    "cosine": tie.cosine,
                    "gain_apart": tie.gain_apart,
                    "error": tie.error,
                }
                for tie in decision.ties
            ],
            "objections": list(decision.objections),
            "dispersion": decision.left.dispersion,
            "at_large": decision.left.without_worst_two,
            "before": [_interval(number) for number in naming.intervals_before],
            "after": [_interval(number) for number in naming.intervals],
            "effects": effects_document(best.fit.model.settings, best.fit.model.material)
            if best is not None and self.names
            else None,
            "simulation_errors": [
                {"of": error.what, "deviations": error.deviations, "share": error.share}
                for error in simulator_share(
                    naming.whitened, best.fit if best is not None and self.names else naming.base
                )
            ],
            "screen": [
                {"effect": effect.effect, "score": effect.score, "evidence": effect.evidence}
                for effect in naming.screened
            ],
            "candidates": [
                _candidate_row(candidate, naming.thresholds)
                for candidate in sorted(naming.scored, key=lambda scored: -scored.gain)
            ],
            "identifiability": naming.identifiable.document,
            "undetectable": list(naming.identifiable.undetectable),
            "not_tried": list(naming.not_tried),
        }


def _titles(names: Sequence[str]) -> str:
    """Return the titles of effects in words, with "and" before the last."""
    return joined_names([EFFECTS[name]().title for name in names])


def _claim(best: ScoredCandidate, probability: float) -> str:
    """Return the claim; no probability above `MOST_PROBABLE` is stated."""
    return f"The simulation lacks {_titles(best.names)} (probability {rounded(min(probability, MOST_PROBABLE))})."


def _tie(tie: Tie) -> str:
    """Return why these data cannot tell two effects apart, and the trial that would."""
    first, second = EFFECTS[tie.instead_of](), EFFECTS[tie.name]()
    alike = (
        "the second can change what the first changes"
        if tie.cosine > DEFAULT_THRESHOLDS.tie
        else "they change different things, yet each explains the data as well"
    )
    gains = f"their held-out gains differ by {with_interval(tie.gain_apart, tie.error, '1')}"
    return (
        f"These data cannot tell {first.title} from {second.title}: {alike} (cosine {rounded(tie.cosine)}), and"
        f" {gains}. {first.distinguishing_trial}"
    )


def _worst_two(left: RemainingStructure, missing: str) -> list[str]:
    """Return a sentence on two touches that keep nearly all of what is left; nothing where others keep it, too."""
    if not left.is_in_few(DEFAULT_THRESHOLDS):
        return []
    return [
        f"What the best fit leaves beyond the noise is nearly all in {joined_names(left.worst_two)}: look at these two"
        " touches, which the page draws among its single trajectories."
        f" {missing} physics would show in the others, too."
    ]


def _odd(touches: Sequence[OddTouch]) -> list[str]:
    """Return a sentence on each touch whose forces do not belong to the others."""
    return [
        f"Look at {touch.name}: the {touch.unknown} is {rounded(touch.factor)} there, and in other touches of its"
        f" indenter it is 1 with a standard deviation of {rounded(touch.deviation)}."
        for touch in touches
    ]


def _alarms(best: ScoredCandidate) -> list[str]:
    """Return a warning where numbers of the best candidate end at a bound of the fit."""
    if not best.at_bounds:
        return []
    verb = "stands" if len(best.at_bounds) == 1 else "stand"
    return [f"{joined_names(best.at_bounds)} {verb} at an end of the range that was tried: more may be missing."]


def _of_the_known(best: ScoredCandidate, naming: NamingResult) -> str:
    """Return the warning that an effect outside the catalogue may be given the name of its nearest one."""
    tried = {*naming.identifiable.effects, *naming.identifiable.without_trace}
    nearest = "this is the nearest" if len(best.names) == 1 else "these two are the nearest"
    alike = "; ".join(filter(None, (EFFECTS[name].unlisted_look_alike for name in best.names)))
    example = f": {alike}" if alike else ""
    return (
        f"Of {len(tried)} effects that were tried, {nearest}. An effect outside the catalogue that acts alike would be"
        f" given the same name{example}."
    )


def _interval(number: ProfiledInterval) -> dict[str, Any]:
    """Return a number with its interval as schemas/diagnosis.json has it (``estimate``)."""
    return {
        "name": number.name,
        "unit": number.unit,
        "value": number.value,
        "interval": [number.low, number.high],
        "at_bound": [number.low_is_bound, number.high_is_bound],
    }


def _candidate_row(candidate: ScoredCandidate, thresholds: DecisionThresholds) -> dict[str, Any]:
    """Return a candidate as schemas/diagnosis.json has it (``naming.candidates``)."""
    # NaN where there is one indenter only: nothing could be held out
    is_alone = candidate.indenter_gain != candidate.indenter_gain
    return {
        "effects": list(candidate.names),
        "gain": candidate.gain,
        "gain_error": candidate.gain_error,
        "needed": candidate.needed(thresholds),
        "error_size": candidate.error_size,
        "evidence": candidate.evidence,
        "evidence_of_others": candidate.evidence_without_best_two,
        "indenter_gain": None if is_alone else candidate.indenter_gain,
        "indenter_error": None if is_alone else candidate.indenter_error,
        "excess_share": candidate.excess_share,
        "signature": [candidate.signature_before, candidate.signature_after],
        "trend": None if candidate.trend is None else [candidate.trend.share, candidate.trend.error],
        "implausible": list(candidate.implausible),
        "at_bounds": list(candidate.at_bounds),
    }

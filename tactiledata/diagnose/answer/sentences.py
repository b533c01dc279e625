"""The numbers of an answer in sentences: those of effects, where E, nu and mu move to, and of what they then are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tactiledata.diagnose.naming.decide import Tie
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.intervals import ProfiledInterval
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.simulator_share import simulator_share, simulator_share_words
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import rounded, with_interval
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting, effects_document

MOST_NUMBERS = 6
"""Of a fit, that are all told; of more only those that are not nothing."""
NEAR_BOUND = 0.01
"""Of the interval, within which a value at its end is at the bound."""
_SCALES = {"E": (1e-3, "kPa"), "nu": (1.0, "1"), "mu": (1.0, "1")}


def numbers_told(found: Sequence[ProfiledInterval]) -> list[str]:
    """Of the effects, after E, nu and mu; of many only those that are not nothing."""
    fitted = found[3:]
    shown = [one for one in fitted if not one.low <= 0.0 <= one.high] if len(fitted) > MOST_NUMBERS else fitted
    shown = shown or fitted
    numbers = [
        f"{one.name} = {rounded(one.value)} ({rounded(one.low)} to {rounded(one.high)}"
        f"){'' if one.unit == '1' else ' ' + one.unit}"
        for one in shown
    ]
    left = len(fitted) - len(shown)
    others = f"; the other {left} numbers may be nothing." if left else "."
    return [f"{joined_names(numbers)}, as fitted, with 95 % intervals{others}"] if numbers else []


def material_moved(before: Sequence[ProfiledInterval], after: Sequence[ProfiledInterval]) -> list[str]:
    """E, nu and mu without effects and with them."""
    said = []
    for old, new in zip(before, after[:3], strict=True):
        scale, unit = _SCALES[old.name]
        pinned = [" (at its bound)" if _is_at_bound(one) else "" for one in (old, new)]
        ends = f"{rounded(new.low * scale, 3)} to {rounded(new.high * scale, 3)}"
        shown = "" if unit == "1" else f" {unit}"
        values = [f"{rounded(one.value * scale, 3)}{note}" for one, note in zip((old, new), pinned, strict=True)]
        said.append(f"{old.name} {values[0]} → {values[1]}{shown} ({ends})")
    return [f"With it, {'; '.join(said)}."]


def material_is_of(settings: Sequence[EffectSetting]) -> list[str]:
    """Of what E, nu and mu are with these effects, where they depend on something."""
    told: dict[str, list[str]] = {}
    for setting in settings:
        values = setting.member.complete(setting.values)
        for name, what in setting.member.material_of(values).items():
            if what not in told.setdefault(name, []):
                told[name].append(what)
    shared = {tuple(what): joined_names([name for name in told if told[name] == what]) for what in told.values()}
    return [
        f"{names} {'are then those' if ' and ' in names else 'is then that'} of {joined_names(what)}."
        for what, names in shared.items()
    ]


def _is_at_bound(one: ProfiledInterval) -> bool:
    near = NEAR_BOUND * (one.high - one.low)
    return (one.low_is_bound and one.value - one.low <= near) or (one.high_is_bound and one.high - one.value <= near)


@dataclass(frozen=True)
class Answer:
    """What a simulation lacks.

    Parameters
    ----------
    naming : NamingResult
    """

    naming: NamingResult

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects that are claimed; empty where none is."""
        decision = self.naming.decision
        return (
            decision.best.names if decision.best is not None and decision.verdict in ("named", "one of a set") else ()
        )

    @property
    def candidates(self) -> tuple[str, ...]:
        """The same, and whatever cannot be told from them."""
        ties = self.naming.decision.ties if self.names else ()
        return (*self.names, *(tie.name for tie in ties))

    @property
    def is_missing(self) -> bool:
        """Whether physics is missing, named or not."""
        return self.naming.decision.verdict not in ("nothing is missing", "below detection")

    @property
    def sentences(self) -> list[str]:
        """For people, the plainest first."""
        return [*self.what, *self.how]

    @property
    def how(self) -> list[str]:
        """How the simulation behaves with what is claimed; empty where nothing is."""
        decision = self.naming.decision
        if decision.best is None or not self.names:
            return []
        said = [
            *numbers_told(self.naming.intervals),
            *material_moved(self.naming.intervals_before, self.naming.intervals),
        ]
        blamed = simulator_share_words(simulator_share(self.naming.whitened, decision.best.fit))
        return [*said, *material_is_of(decision.best.fit.model.settings), *_alarms(decision.best), *blamed]

    @property
    def what(self) -> list[str]:
        """What is missing, and what cannot be told from it."""
        decision = self.naming.decision
        best = decision.best
        if best is not None and self.names:
            said = [_claim(best, self._probability_of(best)), *(_tie(best, tie) for tie in decision.ties)]
            if decision.is_more_left:
                said.append("What it leaves still has structure: more is missing than the catalogue can say.")
            return [*said, *_odd(decision.left), _of_the_known(best, self.naming)]
        if decision.verdict == "none of the known effects":
            said = ["What is left has structure, and none of the known effects explains it."]
        elif decision.verdict == "below detection" and best is not None:
            said = [
                f"There is a trace that looks like {_titles(best.names)}, too faint, or of too few touches, to be more"
                " than errors of the simulation: below what such data can tell.",
                *(_tie(best, tie) for tie in decision.ties),
            ]
        else:
            said = ["Nothing is missing: noise, contact offsets and errors of the simulation explain what is left."]
        said += _odd(decision.left)
        if best is not None and decision.objections:
            said.append(f"Nearest was {_titles(best.names)}; against it: {'; '.join(decision.objections)}.")
        unseen = self.naming.identifiable.undetectable
        if unseen:
            said.append(f"These could be there and not show in these trajectories: {_titles(unseen)}.")
        numbers = self.naming.identifiable.undetectable_numbers
        if numbers:
            listed = joined_names([f"{one.name} ({EFFECTS[one.effect]().title})" for one in numbers])
            said.append(f"Of effects that would show, these numbers could still be off, and not show: {listed}.")
        return said

    def _probability_of(self, best: ScoredCandidate) -> float:
        """That what is named is missing, alone or with another effect."""
        chances = self.naming.decision.probabilities
        return sum(chances.get(one.label, 0.0) for one in self.naming.scored if set(best.names) <= set(one.names))

    @property
    def document(self) -> dict[str, Any]:
        """The ``naming`` part of ``schemas/diagnosis.json``."""
        decision, naming = self.naming.decision, self.naming
        best = decision.best
        return {
            "verdict": decision.verdict,
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
            "before": [_interval(one) for one in naming.intervals_before],
            "after": [_interval(one) for one in naming.intervals],
            "effects": effects_document(best.fit.model.settings, best.fit.model.material)
            if best is not None and self.names
            else None,
            "simulation_errors": [
                {"of": one.what, "deviations": one.deviations, "share": one.share}
                for one in simulator_share(
                    naming.whitened, best.fit if best is not None and self.names else naming.base
                )
            ],
            "screen": [{"effect": one.effect, "score": one.score, "evidence": one.evidence} for one in naming.screened],
            "candidates": [_judged(one) for one in sorted(naming.scored, key=lambda each: -each.gain)],
            "identifiability": naming.identifiable.document,
            "undetectable": list(naming.identifiable.undetectable),
            "not_tried": list(naming.not_tried),
        }


def _titles(names: Sequence[str]) -> str:
    return joined_names([EFFECTS[name]().title for name in names])


def _claim(best: ScoredCandidate, probability: float) -> str:
    return f"The simulation lacks {_titles(best.names)} (probability {rounded(min(probability, 0.99))})."


def _tie(best: ScoredCandidate, tie: Tie) -> str:
    first, second = EFFECTS[tie.instead_of](), EFFECTS[tie.name]()
    alike = (
        "what it changes the other can change, too"
        if tie.cosine > DEFAULT_THRESHOLDS.tie
        else "what they change differs, yet each explains the data as well"
    )
    this = "It" if len(best.names) == 1 else f"Of the two, {first.title}"
    said = f"{this} cannot be told from {second.title} in these data: {alike} (cosine {rounded(tie.cosine)})"
    said += f", and held-out gains differ by {with_interval(tie.gain_apart, tie.error, '1')}."
    return f"{said} {first.distinguishing_trial}"


def _odd(left: RemainingStructure) -> list[str]:
    if not left.is_in_few(DEFAULT_THRESHOLDS):
        return []
    return [
        f"What is left beyond the noise is nearly all in {joined_names(left.worst_two)}: look at these two touches."
        " Missing physics would show in the others, too."
    ]


def _alarms(best: ScoredCandidate) -> list[str]:
    if not best.at_bounds:
        return []
    return [
        f"At the end of what was tried with it: {joined_names(best.at_bounds)}. Something else may still be absorbed."
    ]


def _of_the_known(best: ScoredCandidate, naming: NamingResult) -> str:
    tried = {*naming.identifiable.effects, *naming.identifiable.without_trace}
    said = "this is" if len(best.names) == 1 else "these two are"
    said = f"Of {len(tried)} effects that were tried, {said} the nearest: what acts alike and is not among them"
    return f"{said} would go by the same name."


def _interval(one: ProfiledInterval) -> dict[str, Any]:
    return {
        "name": one.name,
        "unit": one.unit,
        "value": one.value,
        "interval": [one.low, one.high],
        "at_bound": [one.low_is_bound, one.high_is_bound],
    }


def _judged(one: ScoredCandidate) -> dict[str, Any]:
    alone = one.indenter_gain != one.indenter_gain
    return {
        "effects": list(one.names),
        "gain": one.gain,
        "gain_error": one.gain_error,
        "gain_of_others": one.gain_without_best_two,
        "evidence": one.evidence,
        "evidence_of_others": one.evidence_without_best_two,
        "indenter_gain": None if alone else one.indenter_gain,
        "indenter_error": None if alone else one.indenter_error,
        "excess_share": one.excess_share,
        "signature": [one.signature_before, one.signature_after],
        "implausible": list(one.implausible),
        "at_bounds": list(one.at_bounds),
    }

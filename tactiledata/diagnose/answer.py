"""The answer in plain sentences, and as a document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from tactiledata.diagnose.answer_numbers import material_is_of, material_moved, numbers_told
from tactiledata.diagnose.blamed_simulation import blamed_simulation, blamed_words
from tactiledata.diagnose.decide import Tie
from tactiledata.diagnose.evidence_scale import ESTIMATED
from tactiledata.diagnose.judge import Judged
from tactiledata.diagnose.left_over import LeftOver
from tactiledata.diagnose.name_effects import Naming
from tactiledata.diagnose.profiled_interval import Interval
from tactiledata.diagnose.residuals import joined_names
from tactiledata.diagnose.wording import rounded, with_interval
from tactiledata.effects import EFFECTS
from tactiledata.effects.setting import effects_document


@dataclass(frozen=True)
class Answer:
    """What a simulation lacks.

    Parameters
    ----------
    naming : Naming
    """

    naming: Naming

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
        blamed = blamed_words(blamed_simulation(self.naming.cases, decision.best.fit))
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

    def _probability_of(self, best: Judged) -> float:
        """That what is named is missing, alone or with another effect."""
        chances = self.naming.decision.probabilities
        return sum(chances.get(one.label, 0.0) for one in self.naming.judged if set(best.names) <= set(one.names))

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
            "at_large": decision.left.at_large,
            "before": [_interval(one) for one in naming.intervals_before],
            "after": [_interval(one) for one in naming.intervals],
            "effects": effects_document(best.fit.model.settings, best.fit.model.material)
            if best is not None and self.names
            else None,
            "simulation_errors": [
                {"of": one.what, "deviations": one.deviations, "share": one.share}
                for one in blamed_simulation(naming.cases, best.fit if best is not None and self.names else naming.base)
            ],
            "screen": [{"effect": one.effect, "score": one.score, "evidence": one.evidence} for one in naming.screened],
            "candidates": [_judged(one) for one in sorted(naming.judged, key=lambda each: -each.gain)],
            "identifiability": naming.identifiable.document,
            "undetectable": list(naming.identifiable.undetectable),
            "not_tried": list(naming.not_tried),
        }


def _titles(names: Sequence[str]) -> str:
    return joined_names([EFFECTS[name]().title for name in names])


def _claim(best: Judged, probability: float) -> str:
    return f"The simulation lacks {_titles(best.names)} (probability {rounded(min(probability, 0.99))})."


def _tie(best: Judged, tie: Tie) -> str:
    first, second = EFFECTS[tie.instead_of](), EFFECTS[tie.name]()
    alike = (
        "what it changes the other can change, too"
        if tie.cosine > ESTIMATED.tie
        else "what they change differs, yet each explains the data as well"
    )
    this = "It" if len(best.names) == 1 else f"Of the two, {first.title}"
    said = f"{this} cannot be told from {second.title} in these data: {alike} (cosine {rounded(tie.cosine)})"
    said += f", and held-out gains differ by {with_interval(tie.gain_apart, tie.error, '1')}."
    return f"{said} {first.told_apart_by}"


def _odd(left: LeftOver) -> list[str]:
    if not left.is_in_few(ESTIMATED):
        return []
    return [
        f"What is left beyond the noise is nearly all in {joined_names(left.odd)}: look at these two touches. Missing"
        " physics would show in the others, too."
    ]


def _alarms(best: Judged) -> list[str]:
    if not best.at_bounds:
        return []
    return [
        f"At the end of what was tried with it: {joined_names(best.at_bounds)}. Something else may still be absorbed."
    ]


def _of_the_known(best: Judged, naming: Naming) -> str:
    tried = {*naming.identifiable.effects, *naming.identifiable.without_trace}
    said = "this is" if len(best.names) == 1 else "these two are"
    said = f"Of {len(tried)} effects that were tried, {said} the nearest: what acts alike and is not among them"
    return f"{said} would go by the same name."


def _interval(one: Interval) -> dict[str, Any]:
    return {
        "name": one.name,
        "unit": one.unit,
        "value": one.value,
        "interval": [one.low, one.high],
        "at_bound": [one.low_is_bound, one.high_is_bound],
    }


def _judged(one: Judged) -> dict[str, Any]:
    alone = one.indenter_gain != one.indenter_gain
    return {
        "effects": list(one.names),
        "gain": one.gain,
        "gain_error": one.gain_error,
        "gain_of_others": one.gain_of_others,
        "evidence": one.evidence,
        "evidence_of_others": one.evidence_of_others,
        "indenter_gain": None if alone else one.indenter_gain,
        "indenter_error": None if alone else one.indenter_error,
        "excess_share": one.excess_share,
        "signature": [one.signature_before, one.signature_after],
        "implausible": list(one.implausible),
        "at_bounds": list(one.at_bounds),
    }

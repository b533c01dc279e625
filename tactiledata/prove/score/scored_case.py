"""A case beside its answer, as a score sees it: label and last answer in one record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tactiledata.prove.cases.kinds import AMBIGUOUS, DRAWN, LEAST_SIGNAL, NULLS, OUTSIDE, PAIRS
from tactiledata.prove.score.outcome import (
    CLAIMS,
    FAILED,
    FALSE_ALARM,
    IN_SET,
    NAMED,
    ONE_OF_TWO,
    QUIET,
    STRUCTURE,
    WRONG,
    outcome,
    outcome_of_null,
)
from tactiledata.prove.score.wilson import Z

BESIDE, NONE, OTHER = "beside", "none", "other"
"""Labels, among an answer's probabilities, of another effect beside a candidate, of nothing, and of an effect outside
the catalogue."""


@dataclass(frozen=True)
class ScoredCase:
    """A case and the answer to it.

    Parameters
    ----------
    name : str
        Random name of the case.
    label : dict
        What was sealed.
    answer : dict
        What the diagnosis said.
    seconds : float
        Time that the diagnosis took.
    """

    name: str
    label: Mapping[str, Any]
    answer: Mapping[str, Any]
    seconds: float

    @property
    def kind(self) -> str:
        """Kind of the case."""
        return str(self.label["kind"])

    @property
    def configuration(self) -> str:
        """Configuration in a few words."""
        one = self.label["configuration"]
        return f"{one['generator']} {one['plan']} mismatch {one['mismatch']:g} noise {one['noise']:g}"

    @property
    def hidden(self) -> str:
        """What is hidden, by the rig's names."""
        return " + ".join(one["effect"] for one in self.label["hidden"]) or "nothing"

    @property
    def signal(self) -> float:
        """Signal of what is hidden; 0 where nothing is."""
        return float(self.label["sight"].get("signal", 0.0))

    @property
    def truth(self) -> frozenset[str]:
        """Names of what is hidden, in the catalogue."""
        return frozenset(self.label["truth"])

    @property
    def said(self) -> tuple[str, ...]:
        """All names that the answer gives: claimed, tied with a claim, and shown by readings alone."""
        return tuple(dict.fromkeys([*self.answer["set"], *self.answer["zeros"]]))

    @property
    def is_claim(self) -> bool:
        """Whether the answer names anything."""
        return self.answer["verdict"] in CLAIMS or bool(self.answer["zeros"])

    @cached_property
    def outcome(self) -> str:
        """What the answer is worth."""
        case = {**self.answer, "truth": list(self.label["truth"]), "signal": self.signal}
        if self.kind == NULLS:
            return outcome_of_null(case)
        if self.kind == OUTSIDE:
            return (
                WRONG
                if self.is_claim
                else {STRUCTURE: "abstained", FAILED: FAILED}.get(outcome_of_null(case), "not noticed")
            )
        found = outcome(case)
        if self.kind == AMBIGUOUS and found == NAMED:
            # one name where the data cannot tell: only the set is right
            return IN_SET if len(self.answer["set"]) > 1 else "one name of several"
        return found

    @property
    def is_right(self) -> bool:
        """Whether the answer is right: named, in the set, nothing where nothing is, or no name for what has none."""
        if self.kind == NULLS:
            return self.outcome not in (FALSE_ALARM, FAILED)
        if self.kind == OUTSIDE:
            return self.outcome not in (WRONG, FAILED)
        # of what cannot be seen nothing should be said
        return self.outcome in (NAMED, IN_SET, "too weak", "undetectable")

    @property
    def is_wrong_name(self) -> bool:
        """Whether the answer names something that is not there, and nothing that is."""
        return self.outcome in (WRONG, FALSE_ALARM)

    @property
    def is_detected(self) -> bool:
        """Whether the answer says that something is missing, with a name or without."""
        return self.is_claim or self.answer["verdict"] not in (*QUIET, FAILED)

    @property
    def probability(self) -> tuple[float, bool]:
        """Probability of the likeliest statement, and whether that is right.

        A statement is that a candidate is missing, or that no known effect is: nothing, or one outside the catalogue.
        """
        shares: Mapping[str, float] = self.answer["probabilities"]
        unknown = shares.get(NONE, 0.0) + shares.get(OTHER, 0.0) if shares else 1.0
        label = max(shares.keys() - {BESIDE, NONE, OTHER}, key=lambda key: shares[key], default="")
        if not label or unknown >= shares[label]:
            # weaker than what can be seen counts as nothing, and what readings show needs no fit
            weak = self.kind == DRAWN and self.signal < LEAST_SIGNAL
            return float(unknown), weak or self.truth <= set(self.answer["zeros"])
        return float(shares[label]), frozenset(label.split(" + ")) == self.truth

    @property
    def claimed(self) -> Mapping[str, Any] | None:
        """The candidate that the answer claims, with its gains; ``None`` where fits had no part in it."""
        if self.answer["verdict"] not in CLAIMS:
            return None
        names = set(self.answer["names"])
        return next((one for one in self.answer.get("candidates", ()) if set(one["effects"]) == names), None)

    @property
    def is_named_by_fits(self) -> bool:
        """Whether what is hidden is named, or in the set, by a fit."""
        return self.outcome in (NAMED, IN_SET) and self.claimed is not None

    @property
    def closes_gap(self) -> bool:
        """Whether trajectories that were held out are predicted better with what is claimed than without.

        The gain is the rise of their log-likelihood, summed over trajectories; its whole 95 % interval has to lie
        above 0.
        """
        if self.claimed is None:
            return False
        from tactiledata.diagnose.naming.evidence import error_of_sum

        gains = np.array(self.claimed["gains"], dtype=float)
        return bool(gains.sum() > Z * error_of_sum(gains))

    @property
    def material_errors(self) -> tuple[list[float], list[float]] | None:
        """Errors of E, nu and mu, in %, of the plain fit and of the answer's fit; ``None`` without a right claim."""
        if self.outcome not in (NAMED, IN_SET) or self.answer["verdict"] not in CLAIMS or self.kind == PAIRS:
            return None
        truth = [
            self.label["material"][0] * self.label["modulus_left"],
            self.label["material"][1],
            self.label["material"][2] * self.label["friction_left"],
        ]
        off = [
            [100.0 * (value / true - 1.0) for value, true in zip(self.answer[when][:3], truth, strict=True)]
            for when in ("before", "after")
        ]
        return off[0], off[1]

    @property
    def sentence(self) -> str:
        """The case in a sentence, for the list of misses."""
        said = ", ".join(self.said) or "no name"
        nearest = " + ".join(self.answer["nearest"]) or "nothing"
        against = "; ".join(self.answer["objections"][:2])
        return (
            f"{self.name} ({self.kind}; {self.configuration}): {self.hidden} with a signal of {self.signal:.1f} was"
            f" answered with {self.answer['verdict']!r}, {said}: {self.outcome}. Nearest: {nearest}."
            + (f" Against it: {against}." if against else "")
        )


def partly_right(case: ScoredCase) -> bool:
    """Return whether at least one of the hidden effects is named."""
    return case.outcome in (NAMED, IN_SET, ONE_OF_TWO)

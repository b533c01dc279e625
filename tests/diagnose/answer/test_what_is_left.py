"""What an answer says of touches that keep nearly all of what the best fit leaves, and of its probabilities."""

from types import SimpleNamespace

import pytest

from tactiledata.diagnose.answer.naming_page import _probabilities
from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.naming.decide import Decision
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.verdict import Verdict

IN_TWO = RemainingStructure(DEFAULT_THRESHOLDS.structure_dispersion + 0.2, 1.0, ("t3", "t9"))


def naming(claimed, left):
    """The part of a naming that the sentences read; with a claim of relaxation, or without any."""
    best = SimpleNamespace(names=("relaxation",), label="relaxation", at_bounds=()) if claimed else None
    verdict = Verdict.PARTLY_EXPLAINED if claimed else Verdict.NOTHING_FOUND
    decision = Decision(verdict, best, (), {"relaxation": 0.9999, "none": 0.0001}, (), left, False)
    nothing = SimpleNamespace(undetectable=(), undetectable_numbers=(), effects=(), without_trace=())
    scored = [best] if claimed else []
    return SimpleNamespace(decision=decision, scored=scored, odd=(), identifiable=nothing)


@pytest.mark.parametrize(("claimed", "missing"), [(True, "More missing physics"), (False, "Missing physics")])
def test_two_touches_are_said_to_keep_what_the_fit_leaves(claimed, missing):
    """The sentence is of what the best fit leaves, which is not what the plain simulation misses."""
    said = Answer(naming(claimed, IN_TWO)).what
    assert (
        "What the best fit leaves beyond the noise is nearly all in t3 and t9: look at these two touches."
        f" {missing} would show in the others, too."
    ) in said
    none = Answer(naming(claimed, RemainingStructure(1.0, 1.0, ("t3", "t9")))).what
    assert not any("t3" in sentence for sentence in none)


def test_no_probability_above_that_of_a_claim_is_stated():
    """The claim and the list of all candidates state the same probability."""
    found = naming(True, IN_TWO)
    assert Answer(found).what[0].endswith("(probability 0.99).")
    assert _probabilities(found) == "Probabilities: viscoelastic relaxation 99 %."

"""What an answer says of touches that keep nearly all of what the best fit leaves, and of its probabilities."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tactiledata.diagnose.answer.naming_page import _probabilities
from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.naming.decide import BESIDE, Decision
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.verdict import Verdict
from tactiledata.effects import EFFECTS

IN_TWO = RemainingStructure(DEFAULT_THRESHOLDS.structure_dispersion + 0.2, 1.0, ("t3", "t9"))


def naming(claimed, left, effect="relaxation"):
    """The part of a naming that the sentences read; with a claim of the effect, or without any."""
    best = SimpleNamespace(names=(effect,), label=effect, at_bounds=()) if claimed else None
    verdict = Verdict.PARTLY_EXPLAINED if claimed else Verdict.NOTHING_FOUND
    decision = Decision(verdict, best, (), {effect: 0.9999, "none": 0.0001}, (), left, False)
    nothing = SimpleNamespace(undetectable=(), undetectable_numbers=(), effects=(), without_trace=())
    scored = [best] if claimed else []
    return SimpleNamespace(decision=decision, scored=scored, odd=(), identifiable=nothing)


@pytest.mark.parametrize(("claimed", "missing"), [(True, "More missing physics"), (False, "Missing physics")])
def test_two_touches_are_said_to_keep_what_the_fit_leaves(claimed, missing):
    """The sentence is of what the best fit leaves, which is not what the plain simulation misses."""
    said = Answer(naming(claimed, IN_TWO)).what
    assert (
        "What the best fit leaves beyond the noise is nearly all in t3 and t9: look at these two touches, which the"
        f" page draws among its single trajectories. {missing} would show in the others, too."
    ) in said
    none = Answer(naming(claimed, RemainingStructure(1.0, 1.0, ("t3", "t9")))).what
    assert not any("t3" in sentence for sentence in none)


def test_no_probability_above_that_of_a_claim_is_stated():
    """The claim and the list of all candidates state the same probability."""
    found = naming(True, IN_TWO)
    assert Answer(found).what[0].endswith("(probability 0.99).")
    assert _probabilities(found) == "Probabilities: viscoelastic relaxation 99 %."


def test_the_claim_states_the_probability_of_an_effect_alone_or_with_another_one():
    """What may be beside a candidate counts for each in proportion; the page lists it by itself."""
    found = naming(True, IN_TWO)
    lag = SimpleNamespace(names=("lag",), label="lag", at_bounds=())
    chances = {"relaxation": 0.6, "lag": 0.2, BESIDE: 0.08, "none": 0.12}
    decision = replace(found.decision, probabilities=chances)
    found = SimpleNamespace(**{**vars(found), "decision": decision, "scored": [*found.scored, lag]})
    assert Answer(found).what[0].endswith("(probability 0.66).")  # 0.6 and three quarters of 0.08
    assert _probabilities(found) == (
        "Probabilities: viscoelastic relaxation 60 %, lag and filter of the force sensor 20 %, nothing 12 %, one of"
        " these and another effect beside it 8 %."
    )


@pytest.mark.parametrize("effect", ["relaxation", "lag"])
def test_what_was_given_the_same_name_is_said_with_the_trial_that_tells(effect):
    """The warning of effects outside the catalogue ends with one that is known, where there is one."""
    (warning,) = [text for text in Answer(naming(True, IN_TWO, effect)).what if "outside the catalogue" in text]
    known = EFFECTS[effect].unlisted_look_alike
    assert bool(known) == (effect == "relaxation")
    assert warning.endswith(f"given the same name: {known}." if known else "given the same name.")

"""What an answer is worth, and whether its likeliest probability was right, kind by kind."""

import pytest

from tactiledata.prove.score.scored_case import ScoredCase

NOTHING, UNKNOWN = {"none": 0.9, "other": 0.1}, {"none": 0.1, "other": 0.9}


def scored(kind, truth=(), verdict="nothing found", said=(), probabilities=None, signal=12.0, zeros=(), ties=()):
    """A case with what it hides, and an answer."""
    label = {"kind": kind, "truth": list(truth), "hidden": [], "sight": {"signal": signal} if truth else {}}
    answer = {
        "verdict": verdict,
        "names": list(said),
        "set": [*said, *ties],
        "zeros": list(zeros),
        "probabilities": NOTHING if probabilities is None else probabilities,
        "undetectable": [],
    }
    return ScoredCase("a1", label, answer, 1.0)


@pytest.mark.parametrize(
    ("case", "outcome", "is_right", "is_wrong"),
    [
        (scored("nulls"), "nothing found", True, False),
        (scored("nulls", verdict="not explained"), "structure only", True, False),
        (scored("nulls", verdict="explained", said=["lag"]), "false alarm", False, True),
        (scored("nulls", zeros=["inertia"]), "false alarm", False, True),
        (scored("nulls", zeros=["sensor_drift"]), "nothing found", True, False),
        (scored("visible", ["lag"], "explained", ["lag"]), "named", True, False),
        (scored("visible", ["lag"], "explained", ["clock_skew"], ties=["lag"]), "in the set", True, False),
        (scored("visible", ["lag"], "explained", ["wear"]), "wrong", False, True),
        (scored("visible", ["lag"]), "missed", False, False),
        (scored("visible", ["lag"], "not explained"), "unnamed", False, False),
        (scored("drawn", ["lag"], signal=3.0), "too weak", True, False),
        (scored("outside", verdict="not explained"), "abstained", True, False),
        (scored("outside", verdict="explained", said=["lag"]), "wrong", False, True),
        (scored("pairs", ["lag", "wear"], "explained", ["lag", "wear"]), "named", True, False),
        (scored("pairs", ["lag", "wear"], "explained", ["lag"]), "one of two", False, False),
    ],
)
def test_what_an_answer_is_worth(case, outcome, is_right, is_wrong):
    """Names that are not there are wrong; of what cannot be seen nothing should be said."""
    assert (case.outcome, case.is_right, case.is_wrong_name) == (outcome, is_right, is_wrong)


@pytest.mark.parametrize(
    ("case", "is_right"),
    [
        (scored("nulls"), True),
        (scored("nulls", probabilities=UNKNOWN), True),
        (scored("nulls", probabilities={"lag": 0.9, "none": 0.1}), False),
        (scored("outside", probabilities=UNKNOWN), True),
        (scored("outside"), False),
        (scored("visible", ["lag"], probabilities={"lag": 0.9, "none": 0.1}), True),
        (scored("visible", ["lag"], probabilities=UNKNOWN), False),
        (scored("visible", ["lag"]), False),
        (scored("drawn", ["lag"], signal=3.0), True),
        (scored("pairs", ["wear", "lag"], probabilities={"wear + lag": 0.9, "none": 0.1}), True),
    ],
)
def test_whether_the_likeliest_answer_is_right(case, is_right):
    """Errors of a solver are in no catalogue: where nothing is hidden, "other" is as right as "none"."""
    assert case.probability == (0.9, is_right)

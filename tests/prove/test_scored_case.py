"""What an answer is worth, and whether its likeliest probability was right, kind by kind."""

import pytest

from tactiledata.prove.score.score import TARGETS, gap_closed
from tactiledata.prove.score.scored_case import ScoredCase

NOTHING, UNKNOWN = {"none": 0.9, "other": 0.1}, {"none": 0.1, "other": 0.9}


def scored(kind, truth=(), verdict="nothing found", said=(), probabilities=None, signal=12.0, zeros=(), ties=()):
    """A case with what it hides, and an answer."""
    configuration = {"generator": "layer", "plan": "wedge-2", "mismatch": 1.0, "noise": 1.0}
    label = {
        "kind": kind,
        "configuration": configuration,
        "truth": list(truth),
        "hidden": [],
        "sight": {"signal": signal} if truth else {},
    }
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
        (scored("visible", ["lag"], "explained", ["lag"]), "named", True, False),
        (scored("visible", ["lag"], "explained", ["clock_skew"], ties=["lag"]), "in the set", True, False),
        (scored("visible", ["lag"], "explained", ["wear"]), "wrong", False, True),
        (scored("visible", ["lag"]), "missed", False, False),
        (scored("visible", ["lag"], "not explained"), "unnamed", False, False),
        (scored("visible", ["inertia"], "not explained", zeros=["inertia"]), "named", True, False),
        (scored("pairs", ["lag", "inertia"], "explained", ["lag"], zeros=["inertia"]), "named", True, False),
        (scored("pairs", ["lag", "wear"], "not explained", zeros=["inertia"]), "wrong", False, True),
        (scored("drawn", ["lag"], signal=3.0), "too weak", True, False),
        (scored("outside", verdict="not explained"), "abstained", True, False),
        (scored("outside", verdict="explained", said=["lag"]), "wrong", False, True),
        (scored("pairs", ["lag", "wear"], "explained", ["lag", "wear"]), "named", True, False),
        (scored("pairs", ["lag", "wear"], "explained", ["lag"]), "one of two", False, False),
        (scored("nulls", verdict="failed"), "failed", False, False),
        (scored("outside", verdict="failed"), "failed", False, False),
        (scored("visible", ["lag"], "failed"), "failed", False, False),
        (scored("drawn", ["lag"], "failed", signal=3.0), "failed", False, False),
    ],
)
def test_what_an_answer_is_worth(case, outcome, is_right, is_wrong):
    """Names that are not there are wrong; of what cannot be seen nothing should be said."""
    assert (case.outcome, case.is_right, case.is_wrong_name) == (outcome, is_right, is_wrong)


@pytest.mark.parametrize(
    ("case", "chance", "is_right"),
    [
        (scored("nulls"), 1.0, True),
        (scored("nulls", probabilities={"lag": 0.45, "none": 0.3, "other": 0.25}), 0.55, True),
        (scored("nulls", probabilities={"lag": 0.9, "none": 0.1}), 0.9, False),
        # another effect beside a candidate is no statement of its own
        (scored("visible", ["lag"], probabilities={"lag": 0.4, "beside": 0.5, "none": 0.1}), 0.4, True),
        (scored("outside", probabilities=UNKNOWN), 1.0, True),
        (scored("outside"), 1.0, True),
        (scored("visible", ["lag"], probabilities={"lag": 0.9, "none": 0.1}), 0.9, True),
        (scored("visible", ["lag"], probabilities=UNKNOWN), 1.0, False),
        (scored("visible", ["lag"]), 1.0, False),
        (scored("visible", ["lag"], probabilities={}), 1.0, False),
        (scored("visible", ["inertia"], zeros=["inertia"]), 1.0, True),
        (scored("drawn", ["lag"], signal=3.0), 1.0, True),
        (scored("pairs", ["wear", "lag"], probabilities={"wear + lag": 0.9, "none": 0.1}), 0.9, True),
    ],
)
def test_whether_the_likeliest_statement_is_right(case, chance, is_right):
    """That no known effect is missing is one statement: errors of a solver are in no catalogue."""
    assert case.probability == (pytest.approx(chance), is_right)


def named_with_gains(gains, said=("lag",), candidates=("lag",), verdict="explained"):
    """A hidden lag, and an answer whose candidate has these gains on held-out trajectories."""
    case = scored("visible", ["lag"], verdict, said)
    case.answer["candidates"] = [
        {"effects": ["wear"], "gains": [9.0, 9.0], "excess_share": 1.0},
        {"effects": list(candidates), "gains": gains, "excess_share": 0.6},
    ]
    return case


def test_a_gap_is_closed_where_the_whole_interval_of_the_gain_is_above_zero():
    """Four trajectories that gain 1, 2, 3 and 4: 10 with 5.06 = 1.96 * 2 * 1.291; a loss of 8 in one undoes it."""
    assert named_with_gains([1.0, 2.0, 3.0, 4.0]).closes_gap
    assert not named_with_gains([1.0, 2.0, 3.0, -8.0]).closes_gap
    assert not named_with_gains([0.0, 0.0, 0.0, 9.0]).closes_gap


def test_a_gap_is_asked_of_rightly_named_fits_alone():
    """Neither of names by readings alone, nor of wrong or missing names."""
    cases = [
        named_with_gains([1.0, 2.0, 3.0, 4.0]),
        named_with_gains([0.0, 0.0, 0.0, 9.0]),
        named_with_gains([1.0, 2.0, 3.0, 4.0], candidates=["dome"]),
        named_with_gains([9.0, 9.0, 9.0, 9.0], said=["wear"]),
        named_with_gains([9.0, 9.0, 9.0, 9.0], verdict="not explained"),
    ]
    target = next(target for target in TARGETS if target.what.startswith("gap closed"))
    found = target.share(cases)
    assert (found.right, found.count) == (1, 2)
    assert gap_closed(cases) == {"count": 2, "share": 0.6}
    assert gap_closed(cases[2:]) is None

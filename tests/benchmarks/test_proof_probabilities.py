"""Tests of how often answers of proofs are right by the probability that they state, and by that of today's rules."""

import pytest
from proof_probabilities import DEFAULT_THRESHOLDS, cost, of_claims, rows_of, with_doubt

from tactiledata.prove.score.score import calibration_of
from tactiledata.prove.score.scored_case import ScoredCase

ALIKE, BESIDE = DEFAULT_THRESHOLDS.alike_share, DEFAULT_THRESHOLDS.beside_share


def answered(truth, names, probabilities, verdict="explained"):
    """A visible case with an answer of fits."""
    label = {"kind": "visible", "truth": list(truth), "sight": {"signal": 20.0}}
    answer = {"verdict": verdict, "names": list(names), "set": [], "zeros": [], "probabilities": probabilities}
    return ScoredCase("0" * 16, label, answer, 1.0)


LAG = answered(["lag"], ["lag"], {"lag": 0.8, "lag + wear": 0.1, "none": 0.07, "other": 0.03})
RELAXATION = answered(["relaxation"], ["relaxation"], {"relaxation": 0.9, "none": 0.1, "other": 0.0})
PAIR = answered(["lag", "wear"], ["lag"], {"lag": 1.0, "none": 0.0, "other": 0.0})
WRONG = answered(["wear"], ["lag"], {"lag": 0.9, "none": 0.1, "other": 0.0})
QUIET = answered(["wear"], [], {"none": 0.9, "other": 0.1}, "nothing found")


def test_a_part_is_kept_for_another_effect_and_for_what_looks_alike():
    """A fifth of a lag goes to another effect beside it; half of a relaxation goes outside the catalogue first."""
    assert with_doubt(LAG).answer["probabilities"] == {
        "lag": pytest.approx(0.8 * (1 - BESIDE)),
        "lag + wear": pytest.approx(0.1 * (1 - BESIDE)),
        "beside": pytest.approx(0.9 * BESIDE),
        "none": 0.07,
        "other": pytest.approx(0.03),
    }
    told = with_doubt(RELAXATION).answer["probabilities"]
    assert told["relaxation"] == pytest.approx(0.9 * (1 - ALIKE) * (1 - BESIDE))
    assert told["other"] == pytest.approx(0.9 * ALIKE)
    # what kept such parts is not changed again, and an answer without probabilities has none
    assert with_doubt(with_doubt(LAG)) == with_doubt(LAG)
    assert with_doubt(answered(["lag"], [], {}, "failed")).answer["probabilities"] == {}


def test_a_claim_is_right_alone_or_with_another_effect():
    """The stated probability holds pairs and what is beside; at most 0.99 is stated, and no claim states none."""
    cases = [LAG, with_doubt(LAG), PAIR, WRONG, QUIET]
    assert list(of_claims(cases)) == [
        (pytest.approx(0.9), True), (pytest.approx(0.9), True), (0.99, True), (0.9, False)
    ]  # fmt: skip
    assert rows_of(calibration_of(list(of_claims(cases)))) == [
        ("0.8 to 0.95", 3, "0.90", "0.67"),
        ("0.95 to 1", 1, "0.99", "1.00"),
    ]


def test_the_cost_is_that_of_what_is_right():
    """Two likeliest statements of 0.8 and 0.9, one right and one wrong, by hand."""
    assert cost([LAG, WRONG]) == pytest.approx((0.2231436 + 2.3025851) / 2, abs=1e-6)

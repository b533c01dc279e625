"""Effects beside larger ones that only look like errors of the simulation: what stands there keeps its name."""

import dataclasses
from types import SimpleNamespace

import numpy as np
from candidates import EASY, HARD, MORE_THAN_NOISE, NOTHING_LEFT, OTHER_EASY, along, decided, scattered, with_evidence

from tactiledata.diagnose.naming.beside import pairs_in_question
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.refit import Refits
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS

T = DEFAULT_THRESHOLDS


def beside_a_leader(share, leader="static_friction", best="lag", times=0.9, errors=3.0, **small):
    """What is claimed of an effect beside a leader that has twice its evidence and cannot be claimed.

    The leader has so many times the evidence that it needs beside large errors of the simulation. In a refit of both,
    beside errors of some size, the effect adds a share of its evidence; ``None`` where there is no such refit. Where
    the effect is said to remove a small part of the excess, more than noise is left.
    """
    large = {"error_size": 3.0, "implausible": ("x = 3 s",)}
    ahead = with_evidence(leader, times * T.with_errors(3.0).claim("static_friction"), change=along(0), **large)
    behind = with_evidence(best, ahead.evidence / 2, change=along(1), **small)
    assert ahead.objections(T)
    assert not behind.objections(T)
    pairs = []
    if share is not None:
        large["error_size"] = errors
        pairs = [with_evidence((leader, best), ahead.evidence + share * behind.evidence, change=along(2), **large)]
    return decided([ahead, behind], pairs, MORE_THAN_NOISE if small else NOTHING_LEFT).claimed


def test_what_looks_like_errors_takes_no_name_from_an_effect_that_stands_beside_it():
    """A lag is named though static friction has more evidence, if errors can bring that and the lag adds to it."""
    little, much = 0.9 * T.remainder_share, 1.1 * T.remainder_share
    assert beside_a_leader(much) == ("lag",)
    assert beside_a_leader(little) == ()
    assert beside_a_leader(None) == ()
    # errors beside the two can bring what the lag adds
    assert beside_a_leader(much, errors=60.0) == ()
    # errors do not bring the evidence of the leader
    assert beside_a_leader(much, times=1.1) == ()
    assert beside_a_leader(much, leader="relaxation") == ()
    # errors resemble the effect as well
    assert beside_a_leader(much, best="skin") == ()


def test_an_effect_that_stands_beside_all_larger_ones_may_be_a_small_part():
    """A twentieth of the excess is enough for a lag that keeps its evidence beside all that looks like errors.

    Without the refit beside one of them, or with too little beside it, a twentieth is too small a part.
    """
    little, much = 0.9 * T.remainder_share, 1.1 * T.remainder_share
    small = {"excess_share": 0.05}
    assert beside_a_leader(much, **small) == ("lag",)
    assert beside_a_leader(little, **small) == beside_a_leader(None, **small) == ()
    # so it is where no larger effect takes the other part of the excess
    alone = with_evidence(EASY, 3.0 * T.claim(EASY), **small)
    assert decided([alone], left=MORE_THAN_NOISE).claimed == ()
    assert decided([alone]).claimed == (EASY,)


def test_one_larger_effect_that_was_not_looked_at_is_enough_to_doubt_a_small_part():
    """The refit beside static friction does not speak of a soft spot with more evidence than the lag."""
    large = {"error_size": 3.0}
    ahead = [
        with_evidence(name, 0.5 * T.with_errors(3.0).claim(name), change=along(0), **large) for name in (HARD, "skin")
    ]
    lag = with_evidence("lag", 0.9 * ahead[1].evidence, change=along(1), excess_share=0.05)
    both = [with_evidence((one.label, "lag"), one.evidence + lag.evidence, **large) for one in ahead]
    assert decided([*ahead, lag], both, MORE_THAN_NOISE).claimed == ("lag",)
    for pairs in ([both[0]], [both[1]], []):
        assert decided([*ahead, lag], pairs, MORE_THAN_NOISE).claimed == ()


def test_a_wider_effect_that_errors_made_larger_takes_no_name():
    """A turned frame is named beside a cross-talk that contains it, cannot be claimed, and gains what errors bring.

    It is not beside one that changes something else, that has no more numbers, that leads by more than errors bring,
    whose lead held-out trajectories confirm, or that errors do not resemble.
    """
    turned = with_evidence("frame_rotation", 2.0 * T.claim("frame_rotation"), numbers=3)
    large = {"error_size": 2.5, "numbers": 31, "implausible": ("zz = 0.3",)}
    brought = T.with_errors(2.5).claim("gain_crosstalk")
    assert brought > 2.0 * turned.evidence

    def named(lead=0.9, name="gain_crosstalk", errors=1.9, **changed):
        more = lead * brought
        wider = {"gains": turned.gains + scattered(more, errors), **large, **changed}
        return decided([turned, with_evidence(name, turned.evidence + more, **wider)]).claimed

    assert named() == ("frame_rotation",)
    assert named(lead=1.1) == named(numbers=3) == named(change=along(0)) == named(errors=2.1) == ()
    assert named(name="clipping") == ()


def in_question(*singles, pairs=()):
    """Names of the pairs whose refit decides."""
    return [tuple(one.label for one in pair) for pair in pairs_in_question(singles, pairs, T)]


def test_refits_that_decide_on_a_name_are_asked_for():
    """Only those of a claimable effect unlike errors with a larger one that errors can bring, and only once."""
    lag = with_evidence("lag", 5.0 * T.claim("lag"))
    brought = with_evidence(HARD, 0.9 * T.claim(HARD))
    assert brought.evidence > lag.evidence
    assert in_question(lag, brought) == [(HARD, "lag")]
    assert in_question(lag, brought, pairs=[with_evidence(("lag", HARD), 2.0 * brought.evidence)]) == []
    for doubted in (
        with_evidence("lag", lag.evidence, implausible=("x = 3 s",)),
        with_evidence("lag", 0.9 * T.claim("lag")),
        with_evidence("skin", 2.0 * T.claim("skin")),
    ):
        assert in_question(doubted, brought) == []
    for harmless in (
        with_evidence(HARD, 0.9 * lag.evidence),
        with_evidence(HARD, 1.1 * T.claim(HARD)),
        with_evidence(OTHER_EASY, 2.0 * lag.evidence),
    ):
        assert in_question(lag, harmless) == []


def fit_of(name):
    """A refit of one effect, as far as a further refit beside it looks at it."""
    return SimpleNamespace(names=(name,), model=SimpleNamespace(settings=(f"{name}'s",), strengths=frozenset({name})))


def test_they_are_made_from_both_refits_and_judged(monkeypatch):
    """The refit starts at the larger effect's fit, with what the smaller had alone, and the answer is given anew."""
    singles = [fit_of("arm_compliance"), fit_of("lag")]
    evidence = (0.9 * T.claim("arm_compliance"), 2.0 * T.claim("lag"))
    told = [
        dataclasses.replace(with_evidence(fit.names, each), fit=fit)
        for fit, each in zip(singles, evidence, strict=True)
    ]
    made, judged = [], []

    def added(self, asked, to_beat):
        made.extend(asked)
        return ["both" for _ in asked]

    def judge(self, singles, pairs, base_out, outs):
        judged.append((list(pairs), list(outs)))
        return list(told), SimpleNamespace(best=None, claimed=()), None

    monkeypatch.setattr(Refits, "_with_added", added)
    monkeypatch.setattr(Refits, "_judged", judge)
    monkeypatch.setattr(Refits, "_held_out", lambda self, fits: [f"squares of {fit}" for fit in fits])
    white = SimpleNamespace(starts=np.zeros(0), precision=1.0)
    refits = Refits(white, None, NamingOptions(), lambda text: None, reference="squares of the plain fit")
    refits.score_and_decide(singles, [])
    (asked,) = made
    assert (asked.near, asked.starts) == (singles[0], (("lag's",),))
    assert asked.strengths == {"arm_compliance", "lag"}
    assert judged[1] == (["both"], [*judged[0][1], "squares of both"])

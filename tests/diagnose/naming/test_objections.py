"""Why a candidate cannot be claimed: each objection is raised by a candidate that differs in that respect alone."""

from types import SimpleNamespace

import numpy as np
import pytest
from candidates import EASY, HARD, TRAJECTORIES, candidate, scattered, with_evidence

from tactiledata.diagnose.naming.agreement import Agreement
from tactiledata.diagnose.naming.evidence import score_candidate
from tactiledata.diagnose.naming.held_out import GroupedCosts
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.gel.elasticity.material import GelMaterial

T = DEFAULT_THRESHOLDS
NEEDED = T.needed((EASY,))


def spread(*large, rest=0.0):
    """Numbers (25,) of which the first ones are given and all others alike."""
    return np.array([*large, *[rest] * (TRAJECTORIES - len(large))])


def borne_by_two(evidence, others):
    """Contributions (25,) that sum to some evidence; so much of it is not from the first two trajectories."""
    two = (evidence - others) / 2
    return spread(two, two, rest=others / (TRAJECTORIES - 2))


def test_a_sound_candidate_has_no_objection():
    """The candidate from which the others differ can be claimed."""
    assert candidate(EASY).objections(T) == ()
    assert candidate(HARD).objections(T) == ()


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"evidence": 0.99 * NEEDED}, "errors of the simulation alone can bring"),
        (
            {"evidence_per_trajectory": borne_by_two(2.0 * NEEDED, 0.9 * T.broad_share * NEEDED)},
            "without the two trajectories that contribute most",
        ),
        ({"gains": scattered(2.0 * NEEDED)}, "the gain on held-out trajectories"),
        ({"gains": np.full(TRAJECTORIES, -1.0), "signature_before": 2.0 * T.certain_signature}, "the gain on held-out"),
        ({"indenter_gain": -2.0, "indenter_error": 1.0}, "held-out indenters are predicted worse"),
        ({"excess_share": 0.9 * T.least_excess_share}, "of the excess over the noise is gone"),
        ({"signature_after": 1.1 * T.signature_threshold}, "the residual still holds the change"),
        ({"signature_after": -1.1 * T.signature_threshold}, "the residual still holds the change"),
        ({"implausible": ("lag delay = 3 s",)}, "lag delay = 3 s is not plausible"),
    ],
)
def test_one_respect_is_enough_for_an_objection(changed, words):
    """Each is raised alone, and says what it is about."""
    (said,) = candidate(EASY, **changed).objections(T)
    assert words in said


def test_a_strength_that_changes_with_time_is_an_objection():
    """The change must be certain and large, in either direction; the sentence says what the effect is like."""
    error = 0.01
    certain, large = 1.01 * T.trend_sigmas * error, 1.01 * T.trend_share
    share = max(certain, large)
    for sign in (1, -1):
        (said,) = candidate(EASY, trend=Agreement(sign * share, error)).objections(T)
        assert "something else behaves like it" in said
        assert f"to {100 * (1 + sign * share):.0f} % in the last" in said
    small = Agreement(0.99 * T.trend_share, 1e-6)
    uncertain = Agreement(0.99 * T.trend_sigmas * 0.2, 0.2)
    assert uncertain.share > T.trend_share
    for trend in (small, uncertain, None):
        assert candidate(EASY, trend=trend).objections(T) == ()


def test_trajectories_that_do_not_agree_are_an_objection():
    """Without a signature, the whole evidence must be there without the two trajectories that contribute most."""
    faint = 0.9 * T.signature_threshold
    barely, plenty = (candidate(EASY, times, signature_before=faint) for times in (1.05, 1.2))
    (said,) = barely.objections(T)
    assert "do not agree" in said
    assert plenty.objections(T) == ()
    assert candidate(EASY, 1.05).objections(T) == ()


def test_what_is_left_of_a_large_signature_may_be_large():
    """A refit that took off more than half of the signature removed what it should, whatever the rest."""
    left = 2.0 * T.signature_threshold
    assert candidate(EASY, signature_before=2.1 * left, signature_after=left).objections(T) == ()
    assert len(candidate(EASY, signature_before=1.9 * left, signature_after=left).objections(T)) == 1


@pytest.mark.parametrize(
    "clear",
    [
        {"signature_before": T.certain_signature},
        {"indenter_gain": 1.01 * T.gain_sigmas, "indenter_error": 1.0},
    ],
)
def test_a_gain_that_scatters_is_certain_by_its_signature_or_by_held_out_indenters(clear):
    """Either makes a positive gain certain; neither makes a loss one."""
    gains = scattered(2.0 * NEEDED)
    assert len(candidate(EASY, gains=gains).objections(T)) == 1
    assert candidate(EASY, gains=gains, **clear).objections(T) == ()
    assert candidate(EASY, gains=-gains, **clear).objections(T) != ()


def test_much_evidence_makes_a_gain_of_one_standard_error_certain():
    """Twice what a claim needs must be left without the best two; a gain of less than its error stays uncertain."""
    times = 1.05 * T.structure_evidence * TRAJECTORIES / (TRAJECTORIES - 2)
    gains = scattered(times * NEEDED, 1.1)
    assert candidate(EASY, times, gains=gains).objections(T) == ()
    assert len(candidate(EASY, 0.9 * times, gains=gains).objections(T)) == 1
    assert len(candidate(EASY, times, gains=scattered(times * NEEDED, 0.9)).objections(T)) == 1


@pytest.mark.parametrize(("more", "objections"), [(0.97, 1), (1.03, 0)])
def test_beside_large_errors_of_the_simulation_much_evidence_is_more(more, objections):
    """Without the best two a lag must keep what a claim needs beside errors of five times the usual size."""
    size = 2.5 * T.structure_evidence
    times = more * size * TRAJECTORIES / (TRAJECTORIES - 2)
    one = candidate(EASY, times, gains=scattered(times * NEEDED, 1.1), error_size=size)
    assert len(one.objections(T)) == objections


def test_held_out_indenters_settle_a_gain_whose_sign_is_open():
    """A loss of less than its error is no objection beside a certain gain on indenters and twice the evidence."""
    times = 1.05 * T.structure_evidence * TRAJECTORIES / (TRAJECTORIES - 2)
    sure = {"indenter_gain": 1.01 * T.gain_sigmas, "indenter_error": 1.0}
    open_sign = -scattered(times * NEEDED, 0.9)
    assert candidate(EASY, times, gains=open_sign, **sure).objections(T) == ()
    for other in (
        candidate(EASY, 0.9 * times, gains=open_sign, **sure),
        candidate(EASY, times, gains=-scattered(times * NEEDED, 1.1), **sure),
        candidate(EASY, times, gains=open_sign, indenter_gain=0.99 * T.gain_sigmas, indenter_error=1.0),
        candidate(EASY, times, gains=open_sign),
    ):
        (said,) = other.objections(T)
        assert "the gain on held-out" in said


def test_the_whole_cause_is_named_whatever_its_strength():
    """It is decisive, no error of a simulation resembles it, and it leaves next to nothing; a part is not enough."""
    odd = {"implausible": ("lag delay = 3 s",), "signature_before": T.decisive_signature}
    share = T.whole_cause_share
    assert candidate(EASY, **odd, excess_share=share).objections(T) == ()
    for other in (
        candidate(EASY, **odd, excess_share=0.99 * share),
        candidate(HARD, **odd, excess_share=share),
        candidate(EASY, **{**odd, "signature_before": 0.99 * T.decisive_signature}, excess_share=share),
    ):
        (said,) = other.objections(T)
        assert "not plausible" in said


LIKE_ERRORS = "arm_compliance"
"""An effect that errors of the simulation resemble."""
CONFIRMED = {
    "signature_before": T.decisive_signature,
    "gains": scattered(2.0 * T.needed((LIKE_ERRORS,)), 1.01 * T.gain_sigmas),
    "indenter_gain": 1.01 * T.gain_sigmas,
    "indenter_error": 1.0,
}
"""Trajectories agree decisively, and gains on held-out trajectories and indenters are certain."""


@pytest.mark.parametrize("size", [1.0, 3.0])
def test_what_all_trajectories_and_indenters_confirm_needs_less(size):
    """It needs what an effect needs that no error of the simulation resembles, and half of all without the best two."""
    of_others = T.with_errors(size).claim(EASY)
    told = {**CONFIRMED, "error_size": size}
    enough = max(of_others, T.broad_share * T.needed((LIKE_ERRORS,)))
    assert of_others < 0.5 * T.with_errors(size).claim(LIKE_ERRORS)
    assert with_evidence(LIKE_ERRORS, 1.2 * enough, **told).objections(T) == ()
    assert f"can bring up to {of_others:.0f}" in with_evidence(LIKE_ERRORS, 0.99 * of_others, **told).objections(T)[0]


@pytest.mark.parametrize(
    "less",
    [
        {"signature_before": 0.99 * T.decisive_signature},
        {"gains": scattered(2.0 * T.needed((LIKE_ERRORS,)), 0.99 * T.gain_sigmas)},
        {"gains": np.zeros(TRAJECTORIES)},
        {"indenter_gain": 0.99 * T.gain_sigmas},
        {"indenter_gain": float("nan"), "indenter_error": float("nan")},
    ],
)
def test_what_is_not_confirmed_everywhere_needs_all(less):
    """One open question, or one indenter only, and the whole evidence is needed."""
    one = with_evidence(LIKE_ERRORS, 0.99 * T.needed((LIKE_ERRORS,)), **{**CONFIRMED, **less})
    assert not one.is_confirmed(T)
    assert "can bring up to" in one.objections(T)[0]


def test_what_is_confirmed_may_be_the_whole_cause():
    """An effect that errors resemble is named whatever its strength only where it shows as none of them does."""
    odd = {"implausible": ("arm_compliance translation = 1 m/N",), "excess_share": T.whole_cause_share}
    assert candidate(LIKE_ERRORS, **CONFIRMED, **odd).objections(T) == ()
    less = {**CONFIRMED, "indenter_gain": 0.99 * T.gain_sigmas}
    (said,) = candidate(LIKE_ERRORS, **less, **odd).objections(T)
    assert "not plausible" in said


def test_cross_talk_that_touches_do_not_agree_on_may_be_an_error_of_the_simulation():
    """Cross-talk with an evidence of 176 beside errors of 2.8 times the usual size is claimed only if all confirm it.

    So it was in a world without effects: 60 touches, an agreement of 3.7, a gain of less than one standard error.
    """
    large = T.for_data(60)
    null = {"error_size": 2.75, "signature_before": 3.7, "gains": scattered(118.0, 0.82), "indenter_gain": 261.0}
    found = with_evidence("gain_crosstalk", 176.0, **null, indenter_error=62.0)
    assert "can bring up to" in found.objections(large)[0]
    assert "can bring" not in str(
        with_evidence("gain_crosstalk", 176.0, **CONFIRMED, error_size=2.75).objections(large)
    )


def test_other_effects_and_pairs_need_all_evidence_however_well_confirmed():
    """Errors of the simulation are not what an effect that they do not resemble must stand out from."""
    assert candidate(LIKE_ERRORS, **CONFIRMED).is_confirmed(T)
    assert not candidate(EASY, **CONFIRMED).is_confirmed(T)
    assert not candidate((EASY, LIKE_ERRORS), **CONFIRMED).is_confirmed(T)
    # touches agree on errors before sliding as well
    assert not candidate("static_friction", **CONFIRMED).is_confirmed(T)


def test_indenters_within_their_error_are_no_objection():
    """A loss on held-out indenters counts beyond one standard error."""
    assert candidate(EASY, indenter_gain=-0.9, indenter_error=1.0).objections(T) == ()
    assert len(candidate(EASY, indenter_gain=-1.1, indenter_error=1.0).objections(T)) == 1


def test_an_effect_of_one_place_is_agreed_on_by_three_touches():
    """Three touches of 25 that carry a clear signature are enough; two that gain as much are not."""
    three, two = (
        candidate(
            EASY, 6.0, gains=shares * 6.0 * NEEDED, evidence_per_trajectory=shares * 6.0 * NEEDED,
            signature_before=T.certain_signature,
        )
        for shares in (spread(0.4, 0.3, 0.3), spread(0.6, 0.4))
    )  # fmt: skip
    assert three.gain == pytest.approx(two.gain)
    assert three.gain < T.gain_sigmas * three.gain_error
    assert three.objections(T) == ()
    (said,) = two.objections(T)
    assert "without the two trajectories" in said


def test_what_errors_of_a_simulation_do_not_resemble_needs_less_evidence():
    """With evidence between the two needs, only the unlike effect is claimed; a pair of effects needs the sum."""
    between = 0.95 * T.needed((HARD,))
    assert between > T.needed((EASY,))
    assert with_evidence(EASY, between).objections(T) == ()
    assert len(with_evidence(HARD, between).objections(T)) == 1
    assert T.needed((EASY, HARD)) == T.needed((EASY,)) + T.needed((HARD,))
    assert T.is_resembled((EASY, HARD))
    assert not T.is_resembled((EASY,))


@pytest.mark.parametrize("name", [EASY, HARD])
def test_a_share_of_what_a_claim_needs_is_a_trace(name):
    """Evidence above the share is a trace, below it is not; what hangs on two trajectories never is."""
    above, below = (candidate(name, times * T.trace_share) for times in (1.1, 0.9))
    assert above.is_trace(T)
    assert not below.is_trace(T)
    evidence = 3.0 * T.needed((name,))
    two = candidate(name, 3.0, evidence_per_trajectory=borne_by_two(evidence, 0.0))
    assert not two.is_trace(T)


def test_far_more_evidence_than_a_claim_needs_shows_structure():
    """Such evidence is structure, even beside an objection, if the gain is certain and two touches do not bear it."""
    times = 1.2 * T.structure_evidence * TRAJECTORIES / (TRAJECTORIES - 2)
    evidence = times * NEEDED
    wide = candidate(EASY, times, implausible=("lag delay = 3 s",))
    assert wide.is_structure(T)
    assert not candidate(EASY, 0.9 * T.structure_evidence, implausible=("lag delay = 3 s",)).is_structure(T)
    assert not candidate(EASY, times, evidence_per_trajectory=borne_by_two(evidence, 0.0)).is_structure(T)
    assert not candidate(EASY, times, gains=scattered(evidence)).is_structure(T)


def fitted(cost, by_trajectory, occam, change, left):
    """A fit of which a score needs the costs, the price of its numbers, what its effect changes, and what is left."""
    material = GelMaterial(9e5, 0.47, 0.7)
    model = SimpleNamespace(
        settings=(),
        coordinates=(),
        material=material,
        box=SimpleNamespace(low=(1e5, 0.4, 0.1), high=(1e7, 0.5, 2.0)),
    )
    metric = RandomEffects(np.zeros(change.shape), np.zeros((*change.shape, 0)), np.zeros(0), np.arange(len(change)))
    return SimpleNamespace(
        names=(EASY,),
        cost=cost,
        cost_by_trajectory=by_trajectory,
        occam=occam,
        effect_change=change,
        residual_at_centre=left,
        residual_beside=left,
        metric=metric,
        beside=metric,
        model=model,
        covariance=np.eye(3),
    )


@pytest.mark.parametrize("dispersion", [1.0, 2.0])
def test_a_score_is_what_the_formulas_say(dispersion):
    """Half the fall of the cost, over the dispersion; the price of the numbers is taken whole."""
    change = np.ones((4, 6))
    # the plain fit leaves what the effect changes, by two thirds to four thirds; the refit leaves nothing of it in sum
    uneven = np.array([2.0, 3.0, 3.0, 4.0])[:, None] / 3.0 * change
    base = fitted(100.0, np.array([60.0, 40.0]), 0.0, change, uneven)
    fit = fitted(40.0, np.array([30.0, 8.0]), 3.0, change, uneven - change)
    base_out = GroupedCosts(np.array([66.0, 50.0]), np.zeros(0))
    out = GroupedCosts(np.array([36.0, 30.0]), np.zeros(0))
    scored = score_candidate(base, fit, base_out, out, 16.0, dispersion)
    assert scored.evidence == pytest.approx(30.0 / dispersion - 3.0)
    assert scored.evidence_per_trajectory == pytest.approx(np.array([15.0, 16.0]) / dispersion)
    assert scored.gains == pytest.approx(np.array([15.0, 10.0]) / dispersion)
    # 116 are left by the plain fit, of which noise is 16; 50 of the other 100 are gone
    assert scored.excess_share == pytest.approx(0.5)
    assert np.isnan(scored.indenter_gain)
    # four trajectories that deviate by a third twice, each of leverage a quarter: as a jackknife has it
    error = np.sqrt(2.0 * (1.0 / 3.0 / 0.75) ** 2) / 4.0
    assert scored.signature_before == pytest.approx(1.0 / error)
    assert scored.signature_after == pytest.approx(0.0, abs=1e-9)

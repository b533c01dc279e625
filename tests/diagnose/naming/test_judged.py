"""What scored candidates allow to be said: a claim, its ties, a trace, structure, or nothing."""

from types import SimpleNamespace

import numpy as np
import pytest
from candidates import (
    EASY,
    EVERYTHING,
    HARD,
    IN_FEW,
    MORE_THAN_NOISE,
    MUCH,
    NOTHING_LEFT,
    OTHER_EASY,
    STRUCTURE,
    along,
    candidate,
    decided,
    scattered,
    with_evidence,
)

from tactiledata.diagnose.naming import kept_fits
from tactiledata.diagnose.naming.decide import BESIDE, NONE, OTHER
from tactiledata.diagnose.naming.identifiability import Identifiability
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.refit import Refits, with_penalty
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.screen import Screened
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS, TYPICAL_OCCAM
from tactiledata.diagnose.naming.ties import ties_of_two
from tactiledata.diagnose.verdict import Verdict
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial

T = DEFAULT_THRESHOLDS


def tie_names(decision):
    """Names of the ties, in their order."""
    return [tie.name for tie in decision.ties]


@pytest.mark.parametrize("name", [EASY, HARD])
def test_more_than_enough_evidence_is_a_claim_half_of_it_a_trace_and_less_nothing(name):
    """Each effect by its own needs."""
    for times, verdict in (
        (1.5, Verdict.EXPLAINED),
        (1.2 * T.trace_share, Verdict.BELOW_DETECTION),
        (0.8 * T.trace_share, Verdict.NOTHING_FOUND),
    ):
        found = decided([candidate(name, times)])
        assert found.verdict is verdict
        assert found.claimed == ((name,) if verdict is Verdict.EXPLAINED else ())
        assert (found.objections == ()) == (verdict is Verdict.EXPLAINED)


def test_far_more_of_what_cannot_be_claimed_takes_a_claim_away():
    """Another, objected to, that leads by more than a tie speaks for something else; within a tie it does not."""
    best = with_evidence(EASY, MUCH)
    for lead, verdict in ((0.9, Verdict.EXPLAINED), (1.3, Verdict.NOT_EXPLAINED)):
        evidence = MUCH + lead * T.tie_margin(MUCH, ())
        other = with_evidence(OTHER_EASY, evidence, change=along(0), implausible=("x = 3 s",))
        assert decided([best, other]).verdict is verdict


def test_a_penalty_is_shared_by_the_trajectories():
    """Half of the evidence is taken from each trajectory; without the two best, 23 of 25 parts of the half remain."""
    one = with_evidence(EASY, 100.0)
    found = with_penalty(one, 50.0)
    assert found.evidence == pytest.approx(50.0)
    assert found.evidence_without_best_two == pytest.approx(50.0 * 23 / 25)
    assert with_penalty(one, 130.0).evidence_per_trajectory == pytest.approx(0.0)


def test_what_errors_of_the_simulation_can_bring_does_not_rank_an_effect():
    """An effect with more evidence, but less beyond its needs, takes no claim and is no tie."""
    needs = T.claim(HARD) - T.claim(EASY)
    hard = with_evidence(HARD, 5.0 * T.claim(HARD), change=along(0))
    for lead, ties in ((1.3, []), (0.9, [HARD])):
        evidence = hard.evidence - needs + lead * T.tie_margin(hard.evidence - needs, ())
        easy = with_evidence(EASY, evidence, change=along(1))
        assert hard.evidence > easy.evidence
        assert hard.objections(T) == easy.objections(T) == ()
        found = decided([hard, easy])
        assert found.claimed == (EASY,)
        assert tie_names(found) == ties


@pytest.mark.parametrize(("name", "least"), [(HARD, T.main_cause_share), (EASY, T.part_share)])
def test_a_name_that_explains_too_small_a_part_is_not_given(name, least):
    """Where more than noise is left, an effect must be the main cause, or a part; where nothing is left it need not."""
    less, more = (candidate(name, 5.0, excess_share=share * least) for share in (0.9, 1.1))
    assert less.objections(T) == ()
    doubted = decided([less], left=MORE_THAN_NOISE)
    assert (doubted.verdict, doubted.is_more_left, len(doubted.objections)) == (Verdict.NOT_EXPLAINED, True, 1)
    assert decided([more], left=MORE_THAN_NOISE).verdict is Verdict.EXPLAINED
    assert decided([less]).verdict is Verdict.EXPLAINED
    assert decided([less], left=STRUCTURE).verdict is Verdict.NOT_EXPLAINED
    assert decided([more], left=STRUCTURE).verdict is Verdict.PARTLY_EXPLAINED
    # two touches that hang on a scrap are no reason to doubt what the others agree on
    assert decided([less], left=IN_FEW).verdict is Verdict.PARTLY_EXPLAINED


@pytest.mark.parametrize("name", [EASY, HARD])
def test_an_effect_on_which_trajectories_agree_decisively_is_named_beside_what_else_is_left(name):
    """Its share of the excess no longer counts: below the signature it does, and so it does if two touches bring it."""
    certain = {"signature_before": T.decisive_signature, "excess_share": 0.0}
    decisive = candidate(name, 5.0, **certain)
    assert decided([decisive], left=MORE_THAN_NOISE).claimed == (name,)
    assert decided([decisive], left=STRUCTURE).verdict is Verdict.PARTLY_EXPLAINED
    less = candidate(name, 5.0, excess_share=0.0, signature_before=0.99 * T.decisive_signature)
    assert decided([less], left=MORE_THAN_NOISE).claimed == ()
    # nine tenths of what is needed without the two trajectories that contribute most
    each = np.full(25, 0.9 * T.needed((name,)) / 23)
    each[:2] = 0.5 * (decisive.evidence - 0.9 * T.needed((name,)))
    by_two = candidate(name, 5.0, evidence_per_trajectory=each, **certain)
    assert decided([by_two], left=MORE_THAN_NOISE).claimed == ()


def test_evidence_that_errors_of_the_simulation_can_bring_takes_no_claim_away():
    """An effect that needs much speaks for something else only as far as its evidence is beyond that."""
    best = with_evidence(EASY, 3.0 * T.needed((EASY,)))
    usual = with_evidence(HARD, 0.99 * T.needed((HARD,)))
    assert usual.evidence > best.evidence + T.tie_margin(usual.evidence, ())
    assert decided([best, usual]).claimed == (EASY,)
    beyond = best.evidence - T.needed((EASY,)) + T.needed((HARD,))
    far_more = with_evidence(HARD, beyond + 1.1 * T.tie_margin(1.2 * beyond, ()), implausible=("x = 3 s",))
    assert decided([best, far_more]).claimed == ()


def test_an_effect_that_errors_resemble_must_be_more_of_the_cause():
    """An effect with a share between the two limits is named only if no error resembles it."""
    share = 0.5 * (T.part_share + T.main_cause_share)
    assert decided([candidate(EASY, excess_share=share)], left=MORE_THAN_NOISE).claimed == (EASY,)
    assert decided([candidate(HARD, excess_share=share)], left=MORE_THAN_NOISE).claimed == ()


def test_structure_that_two_touches_bring_takes_no_name_away():
    """Ten times the noise in one touch of 25 is said and counts for nothing; twice the noise in all of them does."""
    noise, names = np.full(25, 60.0), [f"t{number}" for number in range(25)]
    odd = RemainingStructure.of(np.where(np.arange(25) == 7, 10.0, 1.0) * noise, noise, names)
    wide = RemainingStructure.of(2.0 * noise, noise, names)
    assert odd.dispersion > T.structure_dispersion
    assert odd.worst_two[0] == "t7"
    assert (odd.without_worst_two, wide.without_worst_two) == (1.0, 2.0)
    part = candidate(HARD, 5.0, excess_share=0.9 * T.main_cause_share)
    found = decided([part], left=odd)
    assert found.verdict is Verdict.PARTLY_EXPLAINED
    assert found.left.is_in_few(T)
    assert decided([part], left=wide).verdict is Verdict.NOT_EXPLAINED


def test_evidence_that_no_name_fits_is_structure():
    """Far more than a claim needs, with an objection, leaves the world unexplained even where nothing else is left."""
    times = 1.2 * T.structure_evidence
    strange = candidate(EASY, times, implausible=("lag delay = 3 s",))
    assert decided([strange]).verdict is Verdict.NOT_EXPLAINED
    # without a certain gain there is no structure either
    unsure = candidate(EASY, times, implausible=("lag delay = 3 s",), gains=scattered(times * T.needed((EASY,))))
    assert decided([unsure]).verdict is Verdict.NOTHING_FOUND
    assert decided([unsure], left=STRUCTURE).verdict is Verdict.NOT_EXPLAINED
    assert decided([]).verdict is Verdict.NOTHING_FOUND


def test_another_that_can_be_claimed_is_a_tie_within_the_margin():
    """Within the margin a claimable effect is a tie whatever it changes; beyond it, or implausible, it is none."""
    best, margin = with_evidence(EASY, MUCH, change=along(0)), T.tie_margin(MUCH, ())
    for behind, ties in ((0.9, [OTHER_EASY]), (1.1, [])):
        other = with_evidence(OTHER_EASY, MUCH - behind * margin, change=along(1))
        found = decided([other, best])
        assert (found.claimed, tie_names(found)) == ((EASY,), ties)
        # beside its evidence, it costs nothing to be in the set
        assert (found.probabilities[OTHER_EASY] > 1e-3) == bool(ties)
    odd = with_evidence(OTHER_EASY, MUCH, change=along(0), implausible=("x = 3 s",))
    assert tie_names(decided([best, odd])) == []
    # the margin of little evidence is a number, of much a share
    assert T.tie_margin(0.0, ()) == T.tie_evidence
    assert T.tie_margin(MUCH, ()) == pytest.approx(T.tie_share * MUCH)


@pytest.mark.parametrize("more", [0.9, 1.1])
def test_large_errors_of_the_simulation_leave_another_that_can_be_claimed_in_the_set(more):
    """Both are counted beyond what errors of the size found can bring, where these raise one's needs far more."""
    errors = {"error_size": 3.0}
    beside = T.with_errors(3.0)
    evidence = 1.2 * beside.claim(HARD)
    margin = T.tie_margin(evidence, (HARD, EASY))
    best = with_evidence(HARD, evidence, change=along(0), **errors)
    leads = evidence - beside.claim(HARD)
    other = with_evidence(EASY, leads + beside.claim(EASY) - more * margin, change=along(1), **errors)
    assert best.beyond(T) - other.beyond(T) > margin
    assert not other.objections(T)
    found = decided([best, other])
    assert (found.claimed, tie_names(found)) == ((HARD,), [EASY] if more < 1 else [])
    # what cannot be claimed and changes something else is none
    odd = with_evidence(EASY, other.evidence, change=along(1), implausible=("x = 3 s",), **errors)
    assert tie_names(decided([best, odd])) == []


def test_another_that_cannot_be_claimed_is_a_tie_where_it_changes_the_same():
    """An effect with an objection is a tie where it changes the same as the named one, and none where it does not."""
    best = with_evidence(EASY, MUCH, change=along(0))
    for change, ties in ((along(0), [OTHER_EASY]), (along(1), [])):
        other = with_evidence(OTHER_EASY, MUCH, change=change, excess_share=0.0)
        assert other.objections(T) != ()
        assert tie_names(decided([best, other])) == ties


def test_a_tie_says_how_far_apart_the_two_are():
    """A tie states the cosine of the two, the difference of their gains, and its error over trajectories."""
    best = with_evidence(EASY, MUCH)
    more = np.tile([0.4, -0.2], 13)[:25]
    other = with_evidence(OTHER_EASY, MUCH - 1.0, gains=best.gains - more)
    (tie,) = decided([best, other]).ties
    assert (tie.name, tie.instead_of, tie.label) == (OTHER_EASY, EASY, OTHER_EASY)
    assert tie.cosine == pytest.approx(1.0)
    assert tie.gain_apart == pytest.approx(more.sum())
    assert tie.error == pytest.approx(5.0 * more.std(ddof=1))


def test_a_special_case_is_said_in_place_of_the_wider_one():
    """A wider effect with more numbers and clearly less evidence is no tie; with as many numbers it is one."""
    clearly = 1.1 * T.special_case_evidence
    assert clearly < T.tie_margin(MUCH, ())
    special = with_evidence("frame_rotation", MUCH, numbers=3)
    for numbers, behind, ties in ((10, clearly, 0), (3, clearly, 1), (10, 0.9 * T.special_case_evidence, 1)):
        wider = with_evidence("gain_crosstalk", MUCH - behind, numbers=numbers)
        assert len(decided([special, wider]).ties) == ties


@pytest.mark.parametrize(
    ("lead", "change", "ties"),
    [(1.0, EVERYTHING, ["gain_crosstalk"]), (-1.0, EVERYTHING, []), (1.0, along(0), [])],
)
def test_a_wider_effect_with_more_evidence_is_a_tie_even_if_errors_can_bring_it(lead, change, ties):
    """Errors of the simulation can bring all of a cross-talk; it may be one that the turned frame is a part of."""
    special = candidate("frame_rotation", 1.2, numbers=3)
    wider = with_evidence("gain_crosstalk", special.evidence + lead, change=change, numbers=31)
    assert wider.objections(T)
    found = decided([special, wider])
    assert (found.claimed, tie_names(found)) == (("frame_rotation",), ties)


def test_a_special_case_is_named_where_the_wider_one_explains_hardly_more():
    """Ten numbers within the margin of a tie are no reason against three; beyond it, or of another change, they are."""
    margin = max(T.tie_margin(MUCH, ()), T.wider_lead * T.claim("gain_crosstalk"))
    # each is counted beyond what it needs itself
    less = MUCH - T.claim("gain_crosstalk") + T.claim("frame_rotation")
    wider = with_evidence("gain_crosstalk", MUCH, numbers=10)
    for behind, change, numbers, named in (
        (0.9, EVERYTHING, 3, "frame_rotation"),
        (1.1, EVERYTHING, 3, "gain_crosstalk"),
        (0.9, along(0), 3, "gain_crosstalk"),
        (0.9, EVERYTHING, 10, "gain_crosstalk"),
    ):
        special = with_evidence("frame_rotation", less - behind * margin, change=change, numbers=numbers)
        assert decided([wider, special]).claimed == (named,)
    special = with_evidence("frame_rotation", less - 0.9 * margin, numbers=3)
    assert tie_names(decided([wider, special])) == ["gain_crosstalk"]
    implausible = with_evidence("frame_rotation", less - 0.1 * margin, numbers=3, implausible=("yaw = 3 rad",))
    assert decided([wider, implausible]).claimed == ("gain_crosstalk",)


@pytest.mark.parametrize(("errors", "named"), [(1.9, "frame_rotation"), (2.1, "gain_crosstalk")])
def test_a_lead_that_errors_can_bring_must_be_confirmed_by_held_out_trajectories(errors, named):
    """Cross-talk far ahead of a turned frame is named where the difference of their gains has two standard errors."""
    turned = with_evidence("frame_rotation", MUCH, numbers=3)
    gains = turned.gains + scattered(2.0 * MUCH, errors)
    wider = with_evidence("gain_crosstalk", 3.0 * MUCH, numbers=31, gains=gains)
    assert decided([wider, turned]).claimed == (named,)
    # errors resemble both of these, or neither: evidence decides
    for narrow, wide in (("thickness", "soft_region"), ("lag", "clock_skew")):
        one = with_evidence(narrow, MUCH)
        assert decided([with_evidence(wide, 3.0 * MUCH, numbers=5, gains=gains), one]).claimed == (wide,)


def crowd(name, others, share):
    """A best candidate, and others with a share of its evidence that change something else each."""
    best = with_evidence(name, MUCH, change=along(0))
    names = [effect for effect in EFFECTS if effect not in (EASY, HARD)][:others]
    return [best, *(with_evidence(name, share * MUCH, change=along(1 + k % 5)) for k, name in enumerate(names))]


def test_one_of_many_that_errors_resemble_is_not_named():
    """A name is withheld where several others have nearly its evidence; fewer or weaker ones do not matter."""
    near, far = 1.05 * T.crowd_share, 0.95 * T.crowd_share
    found = decided(crowd(HARD, T.crowd, near))
    assert (found.verdict, found.best.label, found.ties) == (Verdict.NOT_EXPLAINED, HARD, ())
    assert found.objections[0].startswith(f"{T.crowd} other effects")
    assert decided(crowd(HARD, T.crowd - 1, near)).claimed == (HARD,)
    assert decided(crowd(HARD, T.crowd, far)).claimed == (HARD,)
    assert decided(crowd(EASY, T.crowd, near)).claimed == (EASY,)


@pytest.mark.parametrize(
    ("best", "is_taken"), [("rate_friction", True), ("stem_bending", True), ("lag", False), ("sensor_drift", False)]
)
def test_more_evidence_for_what_cannot_be_claimed_takes_a_name_away(best, is_taken):
    """Static friction takes the name from an effect of its slot, and from one that errors resemble; not from a lag."""
    outweighing = with_evidence("static_friction", 0.9 * T.claim("static_friction"), change=along(0))
    assert outweighing.objections(T)
    for share, is_named in ((1.05, True), (0.95, not is_taken)):
        named = with_evidence(best, share * outweighing.evidence / T.outweighed, change=along(1))
        found = decided([outweighing, named])
        assert found.claimed == ((best,) if is_named else ())
        assert found.verdict is (Verdict.EXPLAINED if is_named else Verdict.NOT_EXPLAINED)
    if is_taken:
        assert "static_friction" in found.objections[0]
    # what can be claimed itself is a matter of ties, not of outweighing
    able = with_evidence("static_friction", 1.1 * T.claim("static_friction"), change=along(0))
    assert decided([able, with_evidence(best, able.evidence / 2, change=along(1))]).claimed == (best,)


def test_agreement_keeps_the_name_beside_more_evidence_of_another_slot():
    """A soft edge on which trajectories and indenters agree stands beside static friction; a friction does not."""
    outweighing = with_evidence("static_friction", 0.9 * T.claim("static_friction"), change=along(0))
    agreed = {"signature_before": T.decisive_signature, "indenter_gain": 1.01 * T.gain_sigmas, "indenter_error": 1.0}
    for best, told, is_named in (
        ("pad_edge", agreed, True),
        ("pad_edge", {**agreed, "signature_before": 0.99 * T.decisive_signature}, False),
        ("area_friction", agreed, False),
    ):
        evidence = 0.95 * outweighing.evidence / T.outweighed
        named = with_evidence(best, evidence, change=along(1), **{"gains": scattered(evidence, 2.1), **told})
        assert decided([outweighing, named]).claimed == ((best,) if is_named else ())


def test_an_effect_that_errors_resemble_needs_a_plausible_gel():
    """It needs twice the evidence with nu at an end of its range; E and mu may stand there, nu beside other effects."""
    for at_bounds, is_named in ((("nu",), False), (("mu",), True), (("E",), True), ((f"{HARD} time",), True)):
        found = decided([candidate(HARD, 0.95 * T.at_bound, at_bounds=at_bounds)])
        assert found.claimed == ((HARD,) if is_named else ())
    assert "nu stands at an end" in candidate(HARD, 0.95 * T.at_bound, at_bounds=("nu",)).objections(T)[0]
    assert decided([candidate(HARD, 1.05 * T.at_bound, at_bounds=("nu",))]).claimed == (HARD,)
    assert decided([candidate(EASY, 1.1, at_bounds=("nu", "mu"))]).claimed == (EASY,)


def test_a_name_of_two_is_taken_away_as_one_is():
    """Two effects of which errors resemble one are not named beside far more of a third that cannot be claimed."""
    alone = [with_evidence(name, MUCH, change=along(k), signature_before=0.0) for k, name in enumerate((HARD, EASY))]
    pair = with_evidence((HARD, EASY), 4.0 * MUCH)
    for times, named in ((0.9, (HARD, EASY)), (1.1, ())):
        third = with_evidence(
            "stem_bending", times * T.outweighed * pair.evidence, change=along(3), implausible=("x = 1 m",)
        )
        assert set(decided([*alone, third], [pair]).claimed) == set(named)


def substitute(kept, name, evidence, **changed):
    """The pair of a kept effect and another one; the kept one's refit and the pair's."""
    return kept, with_evidence((*kept.names, name), evidence, **changed)


def test_another_may_stand_for_one_of_two_that_are_named():
    """What adds nearly as much as one of two named effects is a tie, by the margin of what that one adds."""
    kept = with_evidence(EASY, MUCH)
    best = with_evidence((EASY, "wear"), MUCH + 0.5 * MUCH)
    margin = T.tie_margin(0.5 * MUCH, ())
    near, far = (
        substitute(kept, name, best.evidence - behind * margin) for name, behind in (("heating", 0.9), ("dome", 1.1))
    )
    (tie,) = ties_of_two(best, [near, far], T)
    assert (tie.name, tie.instead_of, tie.label) == ("heating", "wear", f"{EASY} + heating")
    assert tie.cosine == pytest.approx(1.0)
    assert tie.gain_apart == pytest.approx(best.gain - near[1].gain)
    odd = substitute(kept, "heating", best.evidence, implausible=("rise = 90 K",))
    wide = substitute(kept, "soft_region", best.evidence - 1.1 * T.special_case_evidence, numbers=4)
    assert ties_of_two(best, [odd, wide], T) == ()


def test_probabilities_sum_to_one_and_grow_with_evidence():
    """The probability of nothing falls as that of the effect rises; an objection lowers the effect's at once."""
    chances = [decided([candidate(EASY, times)]).probabilities for times in (0.5, 1.1, 1.5, 3.0)]
    assert [sum(chance.values()) for chance in chances] == pytest.approx(np.ones(4))
    assert (np.diff([chance[EASY] for chance in chances]) > 0).all()
    assert (np.diff([chance[NONE] for chance in chances]) < 0).all()
    odd = decided([candidate(EASY, 3.0, implausible=("lag delay = 3 s",))]).probabilities
    assert odd[EASY] < chances[-1][EASY]
    # what is not claimed is not likelier than what is, whatever its evidence
    assert max(chances[0][EASY], odd[EASY]) < 0.5 < min(chance[EASY] for chance in chances[1:])
    # of much evidence nothing overflows, and another effect may still be beside it
    much = decided([candidate(EASY, 1e6)]).probabilities
    assert much == {
        EASY: pytest.approx(1.0 - T.beside_share),
        BESIDE: pytest.approx(T.beside_share),
        NONE: 0.0,
        OTHER: 0.0,
    }


def test_what_looks_like_something_outside_the_catalogue_shares_its_probability_with_it():
    """Half of a relaxation's probability is that of an unlisted effect; a fifth of the rest, of one beside it."""
    chances = decided([candidate("relaxation", 1e6)]).probabilities
    assert chances[OTHER] == pytest.approx(T.alike_share)
    assert chances["relaxation"] == pytest.approx((1.0 - T.alike_share) * (1.0 - T.beside_share))
    assert sum(chances.values()) == pytest.approx(1.0)


def test_structure_speaks_for_what_is_not_listed():
    """Without structure, nothing is likelier than an effect outside the catalogue; with it, less likely."""
    faint = [candidate(EASY, 0.1)]
    calm, left = (decided(faint, left=left).probabilities for left in (NOTHING_LEFT, STRUCTURE))
    assert calm[NONE] > calm[OTHER]
    assert left[NONE] < left[OTHER]


def test_what_would_not_be_claimed_is_said_with_the_size_that_would():
    """A reach of twice the claim's signal shows from half its range; half of it at no plausible strength."""
    numbers = Strength("lag", "delay"), Strength("wear", "stiffness_change")
    visible = np.array([T.visible(number.effect) for number in numbers])
    known = Identifiability(numbers, np.zeros(2), np.eye(2), visible * [2.0, 0.5], visible, ())
    assert known.undetectable == ("wear",)
    assert known.shows_from == pytest.approx(known.ends / [2.0, 0.5])


@pytest.mark.parametrize("name", [EASY, HARD])
def test_what_can_be_seen_brings_the_evidence_of_a_claim(name):
    """It is half the square of the signal, less a typical price; a claim needs more of it in more data."""
    for count, precision in ((10, 1.0), (1000, 1.0), (36, 4.0)):
        thresholds = T.for_data(count, precision)
        expected = thresholds.visible(name) ** 2 / 2 - TYPICAL_OCCAM
        assert expected == pytest.approx(thresholds.claim(name))
    assert T.for_data(1000).visible(name) > T.for_data(10).visible(name)
    assert T.visible(HARD) > T.visible(EASY)


def test_evidence_in_proportion_to_the_data_is_never_enough():
    """An error of the simulation brings evidence in proportion to trajectories and to their precision.

    What a claim needs grows as well, so that the one is at most a number times the other, whatever is recorded.
    """
    for name, most in ((HARD, T.saturation / T.claim(HARD)), (EASY, T.usual_saturation / T.claim(EASY))):
        shares = [
            count * precision / T.for_data(count, precision).claim(name)
            for count in (36, 1000, 10**6)
            for precision in (1.0, 4.0, 100.0)
        ]
        assert max(shares) < most
        assert max(shares) > 0.99 * most
        # a share of the precision counts as a share of the trajectories
        assert T.for_data(36, 4.0).claim(name) == T.for_data(144, 1.0).claim(name)
    # data raise what is needed by far less where errors of the simulation do not resemble the effect
    needed = T.for_data(200)
    assert needed.claim(EASY) / T.claim(EASY) - 1.0 < 0.5 * (needed.claim(HARD) / T.claim(HARD) - 1.0)


def test_larger_errors_of_the_simulation_forbid_a_claim_and_prefer_no_other_effect():
    """Errors of twice the size bring eight times the evidence; an imitation with less evidence is not named then."""
    assert T.with_errors(2.0 * T.usual_size).claim(HARD) == pytest.approx(8.0 * T.claim(HARD))
    assert T.with_errors(3.0).claim(EASY) == pytest.approx(3.0 * T.claim(EASY))
    assert T.with_errors(T.usual_size).claim(HARD) == T.with_errors(0.5).claim(HARD) == T.claim(HARD)
    for size, named in ((1.0, (HARD,)), (3.0, ())):
        true = with_evidence(HARD, 8.0 * T.claim(HARD), error_size=size)
        imitation = with_evidence(EASY, 4.0 * T.claim(HARD), error_size=size)
        assert imitation.objections(T) == ()
        assert (true.objections(T) == ()) == (size == 1.0)
        assert decided([true, imitation]).claimed == named


def test_a_number_that_shows_at_no_place_is_said_beside_those_of_its_effect_that_do():
    """An indenter's place shows, its radius does not; of one effect that shows nowhere, the effect is said."""
    mount = [Strength("mount_offset", name, place) for name in ("x", "radius_error") for place in ("ball3", "bar")]
    numbers = (*mount, Strength("wear", "stiffness_change"))
    visible = np.array([T.visible(number.effect) for number in numbers])
    known = Identifiability(numbers, np.zeros(5), np.eye(5), visible * [0.5, 2.0, 0.2, 0.4, 0.5], visible, ())
    assert known.undetectable_numbers == (Strength("mount_offset", "radius_error", "ball3"),)
    assert known.undetectable == ("wear",)


def test_what_cannot_be_played_is_no_candidate(monkeypatch):
    """Springs so soft that the gel finds no balance end the refit of one effect, not the diagnosis."""

    def unbalanced(*_):
        raise UsageError("no balance", "stiffer springs", "Lessen the compliances.")

    monkeypatch.setattr(kept_fits, "joint_fit", unbalanced)
    plain = SimpleNamespace(model=joint_model(GelMaterial(9e5, 0.475, 0.7), [], 1, 0))
    white = SimpleNamespace(starts=[0], errors=None, own=None, trust=None, simulated=None)
    fits = Refits(white, plain, NamingOptions(), lambda text: None)
    start = EffectSetting("arm_compliance", {"translation": 1e-4})
    asked = Screened("arm_compliance", 9.0, 5.0, [(start,)], frozenset({Strength("arm_compliance", "translation")}))
    assert fits.singles([asked]) == []


def test_a_number_is_held_against_an_effect_from_twice_its_range_on():
    """A clock that loses 150 ppm where 100 are plausible may be one; at 250 it is something else."""
    rate = next(one for one in EFFECTS["clock_skew"]().parameters if one.name == "rate")
    end = rate.plausible[1]
    assert [rate.beyond(share * end) for share in (0.5, 1.5, 2.0)] == [0.0, 0.0, 0.0]
    assert rate.beyond(2.5 * end) == pytest.approx(0.5 * end)
    assert rate.beyond(-2.5 * end) == pytest.approx(0.5 * end)
    strength = next(one for one in EFFECTS["area_friction"]().parameters if one.name == "shear_strength")
    assert strength.beyond(-1e4) == 1e4

"""Whether one of two effects suffices, or both are needed: what the second adds, and what confirms it."""

import dataclasses

import numpy as np
import pytest
from candidates import EASY, HARD, MUCH, OTHER_EASY, candidate, decided, scattered, with_evidence

from tactiledata.diagnose.naming.beside import needed_of, objections_beside, objections_to
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.effects import EFFECTS

T = DEFAULT_THRESHOLDS


def pair_beside(first, second, adds):
    """A pair whose evidence is that of the first effect and what the second one adds."""
    return with_evidence((first.label, second.label), first.evidence + adds)


@pytest.mark.parametrize("second", [OTHER_EASY, HARD])
def test_of_two_only_what_adds_its_own_is_named(second):
    """The second of two must add what a claim of it needs by itself."""
    needed = T.claim(second)
    first = with_evidence(EASY, 6.0 * needed)
    alone = with_evidence(second, 1.2 * needed)
    for adds, named in ((1.1, {EASY, second}), (0.9, {EASY})):
        pair = pair_beside(first, alone, adds * needed)
        assert set(needed_of(pair, [first, alone], T).names) == named
        assert set(decided([first, alone], [pair]).best.names) == named


def test_a_look_alike_that_repairs_the_first_is_not_named():
    """It adds a smaller part of what it brings alone; as large a part is its own, and so is that of a weak first."""
    first, second = with_evidence(EASY, MUCH), with_evidence(OTHER_EASY, 0.8 * MUCH)
    for share, both in ((0.9, False), (1.1, True)):
        pair = pair_beside(first, second, share * T.remainder_share * second.evidence)
        assert (needed_of(pair, [first, second], T) is pair) is both
    # what is added is much beside the first effect
    weak = with_evidence(EASY, T.remainder_share * second.evidence)
    pair = with_evidence((EASY, OTHER_EASY), second.evidence + weak.evidence)
    assert needed_of(pair, [weak, second], T) is pair


def test_a_second_effect_that_adds_a_small_share_of_the_first_repairs_it():
    """Below a tenth of the first one's evidence it is a remainder of it, however much it adds."""
    first, alone = with_evidence(EASY, 100.0 * MUCH), candidate(OTHER_EASY, 0.1)
    for share, both in ((0.9, False), (1.1, True)):
        pair = pair_beside(first, alone, share * T.second_share * first.evidence)
        assert (needed_of(pair, [first, alone], T) is pair) is both


def test_a_second_effect_that_held_out_trajectories_do_not_confirm_is_not_named():
    """The pair must predict them better than the first alone, beyond chance, or add much in most trajectories."""
    second = next(name for name in EFFECTS if name not in (EASY, HARD) and not T.is_resembled((name,)))
    evidence = 20.0 * T.claim(second)
    first, alone = with_evidence(EASY, evidence), with_evidence(second, 4.0 * T.claim(second))
    adds = 2.5 * T.claim(second)
    by_two = np.zeros(25)
    by_two[:2] = 0.5 * adds
    for gains, spread_over, named in (
        (scattered(adds, 1.1 * T.gain_sigmas), by_two, {EASY, second}),
        (scattered(adds, 0.9 * T.gain_sigmas), by_two, {EASY}),
        (scattered(adds, 0.9 * T.gain_sigmas), np.full(25, adds / 25), {EASY, second}),
        (-scattered(adds, 0.9), np.full(25, adds / 25), {EASY}),
    ):
        pair = with_evidence(
            (EASY, second), evidence + adds, gains=first.gains + gains,
            evidence_per_trajectory=first.evidence_per_trajectory + spread_over,
        )  # fmt: skip
        assert set(needed_of(pair, [first, alone], T).names) == named


def test_trajectories_agree_on_a_second_effect_that_errors_resemble():
    """Errors of a simulation bring evidence and gains; trajectories do not agree on them beside the first effect."""
    for second, least, named in ((HARD, 1.1, {EASY, HARD}), (HARD, 0.9, {EASY}), (OTHER_EASY, 0.9, {EASY, OTHER_EASY})):
        needed = T.claim(second)
        first, alone = with_evidence(EASY, 6.0 * needed), with_evidence(second, 1.2 * needed)
        agreement = {EASY: 9.0, second: least * T.signature_threshold}
        pair = dataclasses.replace(pair_beside(first, alone, 1.1 * needed), agreement_beside=agreement)
        assert set(needed_of(pair, [first, alone], T).names) == named


@pytest.mark.parametrize(
    ("adds", "agrees", "gains", "reason"),
    [
        (0.9, 9.0, 1.0, "errors of the simulation alone can bring up to"),
        (1.1, 0.9 * T.signature_threshold, 1.0, f"agree on ({0.9 * T.signature_threshold:.1f} standard errors)"),
        (1.1, 9.0, -1.0, "not confirmed by held-out trajectories"),
        (1.1, 9.0, 1.0, ""),
    ],
)
def test_a_pair_that_is_not_claimed_says_why_one_of_its_effects_suffices(adds, agrees, gains, reason):
    """Each objection to the second effect is told alone, with both names as a reader knows them; else there is none."""
    needed = T.claim(HARD)
    first, alone = with_evidence(EASY, 6.0 * needed), with_evidence(HARD, 1.2 * needed)
    pair = dataclasses.replace(
        pair_beside(first, alone, adds * needed), agreement_beside={EASY: 9.0, HARD: agrees},
        gains=first.gains + gains * needed / 25,
    )  # fmt: skip
    said = objections_to(pair, [first, alone], T)
    assert len(said) == bool(reason)
    assert all(reason in text and EFFECTS[EASY]().title in text and EFFECTS[HARD]().title in text for text in said)
    # the single effects need no such reason
    assert objections_to(first, [first, alone], T) == ()
    assert said == objections_beside(pair, first, alone, T)


def test_a_second_effect_that_only_repairs_the_first_says_so():
    """A tenth of a strong first effect is what a form that is a little off can leave."""
    first, alone = with_evidence(EASY, 100.0 * MUCH), candidate(OTHER_EASY, 0.1)
    pair = pair_beside(first, alone, 0.9 * T.second_share * first.evidence)
    (said,) = objections_to(pair, [first, alone], T)
    assert "if its form is off" in said


def test_a_pair_with_objections_of_its_own_tells_those():
    """What speaks against both effects together comes first."""
    first, alone = with_evidence(EASY, MUCH), with_evidence(OTHER_EASY, MUCH)
    pair = dataclasses.replace(pair_beside(first, alone, MUCH), indenter_gain=-2.0, indenter_error=1.0)
    assert objections_to(pair, [first, alone], T) == pair.objections(T) != ()


def test_an_effect_with_an_implausible_strength_does_not_suffice():
    """It needs the other one of the pair beside it, however little that adds."""
    odd = with_evidence(EASY, MUCH, implausible=("lag delay = 3 s",))
    alone = candidate(OTHER_EASY, 0.1)
    pair = pair_beside(odd, alone, 0.1)
    assert needed_of(pair, [odd, alone], T) is pair
    sound = with_evidence(EASY, MUCH)
    assert needed_of(pair, [sound, alone], T) is sound
    whole = with_evidence(EASY, MUCH, implausible=odd.implausible, signature_before=T.decisive_signature)
    assert needed_of(pair, [whole, alone], T) is whole


def test_a_pair_of_which_one_suffices_is_as_if_objected_to():
    """Its probability is less than that of the same evidence where both are needed."""
    first, alone = with_evidence(EASY, 9.0 * T.claim(OTHER_EASY)), candidate(OTHER_EASY, 1.2)
    little, enough = (pair_beside(first, alone, adds * T.claim(OTHER_EASY)) for adds in (0.99, 1.01))
    chances = [decided([first, alone], [pair]).probabilities[pair.label] for pair in (little, enough)]
    assert chances[1] > 0.5 > chances[0]

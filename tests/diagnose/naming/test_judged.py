"""What a refit's gains by trajectory allow to be said."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from tactiledata.diagnose.naming.decide import decide, ties_of_two
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.identifiability import Identifiability
from tactiledata.diagnose.naming.metric import RandomEffects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.refit import Refits
from tactiledata.diagnose.naming.remaining_structure import RemainingStructure
from tactiledata.diagnose.naming.screen import Screened
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS
from tactiledata.diagnose.verdict import Verdict
from tactiledata.effects import EFFECTS
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial

UNIT = DEFAULT_THRESHOLDS.claim_gain / 26.0


def judged(gains, signature=1.0, share=0.9, name="lag"):
    """A refit that gained so much in each trajectory."""
    fit = SimpleNamespace(names=(name,))
    return ScoredCandidate(
        fit,
        np.asarray(gains, dtype=float),
        10.0,
        1.0,
        share,
        signature,
        0.0,
        (),
        (),
        evidence=float(np.sum(gains)),
        evidence_per_trajectory=np.asarray(gains, dtype=float),
    )


def spread(*gains, count=25):
    return [*gains, *[0.0] * (count - len(gains))]


def test_an_effect_of_one_place_is_agreed_on_by_a_few_touches():
    """Three touches of 25 that gain much each are enough; two that gain as much are not."""
    few, two = judged(spread(40.0, 30.0, 30.0)), judged(spread(60.0, 40.0))
    assert few.gain == two.gain == 100.0
    assert few.gain < DEFAULT_THRESHOLDS.gain_sigmas * few.gain_error
    assert few.gain_without_best_two == 30.0
    assert few.objections(DEFAULT_THRESHOLDS) == ()
    assert len(two.objections(DEFAULT_THRESHOLDS)) == 2


def test_a_name_that_explains_the_smaller_part_is_not_given():
    """With structure left, what takes off a third of the excess is not what is there; without, it is named."""
    third = judged([20.0] * 25, signature=9.0, share=0.33)
    much, none = (
        RemainingStructure(
            DEFAULT_THRESHOLDS.structure_dispersion + 0.2, DEFAULT_THRESHOLDS.structure_dispersion + 0.1
        ),
        RemainingStructure(1.0, 0.9),
    )
    asked = [third], [], {"lag": third.gains}, None
    assert decide(*asked, much, DEFAULT_THRESHOLDS).verdict is Verdict.NOT_EXPLAINED
    assert decide(*asked, none, DEFAULT_THRESHOLDS).verdict is Verdict.EXPLAINED
    most = dataclasses.replace(third, excess_share=0.8)
    assert decide([most], [], {"lag": most.gains}, None, much, DEFAULT_THRESHOLDS).claimed == ("lag",)
    few = RemainingStructure(DEFAULT_THRESHOLDS.structure_dispersion + 0.1, DEFAULT_THRESHOLDS.noise_dispersion + 0.01)
    # two touches that hang on a scrap are no reason to keep what the others agree on
    assert decide(*asked, few, DEFAULT_THRESHOLDS).verdict is Verdict.PARTLY_EXPLAINED


def believed(name, gains, falls, occam=0.0, numbers=1, change=None):
    """A refit with gains held out and falls of the cost where all was fitted; less what its numbers cost.

    All three are in units of which a claim needs 26.
    """
    change = np.ones((2, 6)) if change is None else change
    model = SimpleNamespace(coordinates=(None,) * numbers)
    names = name if isinstance(name, tuple) else (name,)
    fit = SimpleNamespace(names=names, effect_change=change, effect_fields=change[:, :, None], model=model)
    gains, falls, occam = UNIT * np.asarray(gains, dtype=float), UNIT * np.asarray(falls, dtype=float), UNIT * occam
    return ScoredCandidate(fit, gains, 10.0, 1.0, 0.9, 1.0, 0.0, (), (), float(falls.sum()) - occam, falls)


def decided(singles, pairs=()):
    """The answer where nothing is left."""
    metric = RandomEffects(np.zeros((2, 6)), np.zeros((2, 6, 0)), np.zeros(0), np.zeros(1, int))
    gains = {one.label: one.gains for one in (*singles, *pairs)}
    return decide(singles, list(pairs), gains, metric, RemainingStructure(0.7, 0.6), DEFAULT_THRESHOLDS)


def test_what_all_touches_bring_is_claimed_though_gains_scatter():
    """Evidence of 30 from all of 60 touches is enough beside half the gain of a claim; from two of them it is not."""
    scattered = np.tile([4.0, -3.5], 30)
    borne, hung = (believed("lag", scattered, falls) for falls in (np.full(60, 0.6), spread(15.0, 15.0, count=60)))
    assert 0.5 * DEFAULT_THRESHOLDS.claim_gain <= borne.gain < DEFAULT_THRESHOLDS.claim_gain
    assert borne.gain < DEFAULT_THRESHOLDS.gain_sigmas * borne.gain_error
    assert borne.objections(DEFAULT_THRESHOLDS) == ()
    assert len(hung.objections(DEFAULT_THRESHOLDS)) == 3
    against = believed("lag", scattered - 1.0, np.full(60, 0.6))
    assert against.objections(DEFAULT_THRESHOLDS) != ()


def test_half_of_what_a_claim_needs_is_a_trace():
    """From all touches, half the evidence is a trace, a third is nothing; from two touches any is nothing."""
    scattered = np.tile([4.0, -3.5], 30)
    for fall, verdict in ((0.6, "explained"), (0.3, "below detection"), (0.15, "nothing found")):
        assert decided([believed("lag", scattered, np.full(60, fall))]).verdict == verdict
    assert decided([believed("lag", scattered, spread(9.0, 9.0, count=60))]).verdict is Verdict.NOTHING_FOUND


def test_of_two_only_what_adds_its_own_is_named():
    """Beside a strong effect, what adds a claim's worth is named; what errors bring, or is its remainder, is not."""
    all_alike = np.full(60, 1.0)
    lag = believed("lag", 5.0 * all_alike, 5.0 * all_alike)
    for name, alone, added, names in (
        ("wear", 0.8, 0.8, {"lag", "wear"}),  # brings beside the lag what it brings alone: 48
        ("dome", 0.4, 0.3, {"lag"}),  # 18: simulators that differ bring as much
        ("relaxation", 3.0, 1.2, {"lag"}),  # 72, but 180 alone: it is the lag, told a little otherwise
    ):
        other = believed(name, alone * all_alike, alone * all_alike)
        pair = believed(("lag", name), (5.0 + added) * all_alike, (5.0 + added) * all_alike)
        assert set(decided([lag, other], [pair]).best.names) == names


def test_a_special_case_is_said_in_place_of_the_wider_one():
    """A turned frame explains as much as all gains together, with three numbers for ten: one name, no tie."""
    each = np.full(60, 2.0)
    turned = believed("frame_rotation", each, each, occam=8.0, numbers=3)
    wider = believed("gain_crosstalk", each, each, occam=15.0, numbers=10)
    assert (decided([turned, wider]).claimed, decided([turned, wider]).ties) == (("frame_rotation",), ())
    as_wide = believed("gain_crosstalk", each, each, occam=15.0, numbers=3)
    assert [tie.name for tie in decided([turned, as_wide]).ties] == ["gain_crosstalk"]


def test_evidence_tells_apart_what_gains_cannot():
    """Gains that differ by less than their errors leave a tie, unless all frames together say which."""
    scattered = 2.0 + np.tile([6.0, -6.0], 30)
    best = believed("lag", np.full(60, 2.0), np.full(60, 2.0))
    for falls, tied in ((1.7, ["wear"]), (1.4, [])):
        other = believed("wear", scattered - 0.3, np.full(60, falls))
        assert [tie.name for tie in decided([best, other]).ties] == tied
    likelier = decided([best, believed("wear", scattered - 1.0, np.full(60, 2.3))])
    assert (likelier.best.label, [tie.name for tie in likelier.ties]) == ("wear", ["lag"])


def test_structure_that_two_touches_bring_takes_no_name_away():
    """Ten times the noise in one touch of 25 is said and counts for nothing; twice the noise in all of them does."""
    noise, names = np.full(25, 60.0), [f"t{number}" for number in range(25)]
    odd = RemainingStructure.of(np.where(np.arange(25) == 7, 10.0, 1.0) * noise, noise, names)
    wide = RemainingStructure.of(2.0 * noise, noise, names)
    assert odd.dispersion > DEFAULT_THRESHOLDS.structure_dispersion
    assert odd.worst_two[0] == "t7"
    assert (odd.without_worst_two, wide.without_worst_two) == (1.0, 2.0)
    third = judged([20.0] * 25, signature=9.0, share=0.33)
    asked = [third], [], {"lag": third.gains}, None
    found = decide(*asked, odd, DEFAULT_THRESHOLDS)
    assert found.verdict is Verdict.PARTLY_EXPLAINED
    assert found.left.is_in_few(DEFAULT_THRESHOLDS)
    assert decide(*asked, wide, DEFAULT_THRESHOLDS).verdict is Verdict.NOT_EXPLAINED


def test_another_may_stand_for_one_of_two_that_are_named():
    """Beside a lag, what adds as much as wear does is tied with it; what adds half of it, or nothing, is not."""
    alone, metric = (
        judged([20.0] * 25),
        RandomEffects(np.zeros((1, 6)), np.zeros((1, 6, 0)), np.zeros(0), np.zeros(1, int)),
    )

    def beside(name, each, numbers=1):
        pair = judged([20.0 + each] * 25)
        change, model = np.ones((1, 6)), SimpleNamespace(coordinates=range(1 + numbers))
        fit = SimpleNamespace(
            names=("lag", name), effect_change=change, metric=metric, effect_fields=change[:, :, None], model=model
        )
        return dataclasses.replace(pair, fit=fit)

    stays = dataclasses.replace(alone, fit=SimpleNamespace(names=("lag",), metric=metric))
    twins = [(stays, beside("heating", 3.8)), (stays, beside("inertia", 2.0)), (stays, beside("dome", -1.0))]
    (tie,) = ties_of_two(beside("wear", 4.0), twins, DEFAULT_THRESHOLDS)
    assert (tie.name, tie.instead_of, tie.label) == ("heating", "wear", "lag + heating")
    assert tie.cosine == pytest.approx(1.0)
    assert tie.gain_apart == pytest.approx(5.0)
    # what holds wear as a special case, and explains less with numbers more, is not
    assert ties_of_two(beside("wear", 4.0), [(stays, beside("soft_region", 3.6, numbers=4))], DEFAULT_THRESHOLDS) == ()


def test_what_would_not_be_claimed_is_said_with_the_size_that_would():
    """A reach of twice the claim's signal shows from half its range; half of it at no plausible strength."""
    reach = DEFAULT_THRESHOLDS.visible * np.array([2.0, 0.5])
    numbers = Strength("lag", "delay"), Strength("wear", "stiffness_change")
    known = Identifiability(numbers, np.zeros(2), np.eye(2), reach, ())
    assert known.undetectable == ("wear",)
    assert known.shows_from == pytest.approx(known.ends / [2.0, 0.5])
    assert DEFAULT_THRESHOLDS.visible**2 / 2 == pytest.approx(DEFAULT_THRESHOLDS.claim_gain)


def test_a_number_that_shows_at_no_place_is_said_beside_those_of_its_effect_that_do():
    """An indenter's place shows, its radius does not; of one effect that shows nowhere, the effect is said."""
    mount = [Strength("mount_offset", name, place) for name in ("x", "radius_error") for place in ("ball3", "bar")]
    reach = DEFAULT_THRESHOLDS.visible * np.array([0.5, 2.0, 0.2, 0.4, 0.5])
    known = Identifiability((*mount, Strength("wear", "stiffness_change")), np.zeros(5), np.eye(5), reach, ())
    assert known.undetectable_numbers == (Strength("mount_offset", "radius_error", "ball3"),)
    assert known.undetectable == ("wear",)


def test_what_cannot_be_played_is_no_candidate(monkeypatch):
    """Springs so soft that the gel finds no balance end the refit of one effect, not the diagnosis."""

    def unbalanced(*_, **options):
        raise UsageError("no balance", "stiffer springs", "Lessen the compliances.")

    monkeypatch.setattr("tactiledata.diagnose.naming.refit.joint_fit", unbalanced)
    plain = SimpleNamespace(model=joint_model(GelMaterial(9e5, 0.475, 0.7), [], 1, 0))
    fits = Refits(SimpleNamespace(starts=[0]), np.zeros((1, 6, 0)), plain, NamingOptions(), lambda text: None)
    start = EffectSetting("arm_compliance", {"translation": 1e-4})
    asked = Screened("arm_compliance", 9.0, 5.0, [(start,)], frozenset({Strength("arm_compliance", "translation")}))
    assert fits.singles([asked]) == []


def test_what_is_not_beaten_is_listed_beside_the_best():
    """Another that reaches the claim is listed until the best gains more by 1.3 standard errors of the difference."""
    rng = np.random.default_rng(0)
    metric = RandomEffects(np.zeros((2, 6)), np.zeros((2, 6, 0)), np.zeros(0), np.zeros(1, int))

    def one(name, gains, column):
        change = np.zeros((2, 6))
        change[:, column] = 1.0
        fit = SimpleNamespace(names=(name,), effect_change=change, effect_fields=change[:, :, None], model=model)
        return ScoredCandidate(
            fit, gains, 10.0, 1.0, 0.9, 4.3, 0.0, (), (), evidence=float(gains.sum()), evidence_per_trajectory=gains
        )

    model = SimpleNamespace(coordinates=(None,))
    best = one("lag", UNIT * rng.normal(2.4, 0.2, 25), 0)
    scattered = rng.normal(0.0, 1.0, 25)
    scattered = 3.0 * UNIT * (scattered - scattered.mean()) / scattered.std(ddof=1)
    error = float(np.sqrt(25) * scattered.std(ddof=1))
    for name, behind in (("wear", 1.0), ("dome", 1.8)):
        other = one(name, best.gains - scattered - behind * error / 25, 1)
        assert other.gain >= DEFAULT_THRESHOLDS.claim_gain
        gains = {"lag": best.gains, name: other.gains}
        left = RemainingStructure.of(np.full(25, 10.0), np.full(25, 10.0), [f"t{k}" for k in range(25)])
        found = decide([best, other], [], gains, metric, left, DEFAULT_THRESHOLDS)
        assert found.best is best
        assert [tie.name for tie in found.ties] == (["wear"] if name == "wear" else [])


def test_a_number_is_held_against_an_effect_from_twice_its_range_on():
    """A clock that loses 150 ppm where 100 are plausible may be one; at 250 it is something else."""
    rate = next(one for one in EFFECTS["clock_skew"]().parameters if one.name == "rate")
    end = rate.plausible[1]
    assert [rate.beyond(share * end) for share in (0.5, 1.5, 2.0)] == [0.0, 0.0, 0.0]
    assert rate.beyond(2.5 * end) == pytest.approx(0.5 * end)
    assert rate.beyond(-2.5 * end) == pytest.approx(0.5 * end)
    strength = next(one for one in EFFECTS["area_friction"]().parameters if one.name == "shear_strength")
    assert strength.beyond(-1e4) == 1e4

"""When a joint fit ends: at its own best, or far behind another explanation that it cannot reach any more."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from tied_worlds import START, effect, recorded

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.diagnose.naming import joint_fit as module
from tactiledata.diagnose.naming import kept_fits, refit
from tactiledata.diagnose.naming.joint_fit import joint_fit, plain_fit
from tactiledata.diagnose.naming.kept_fits import FitRequest, KeptFits
from tactiledata.diagnose.naming.linearise import Linearised
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.parameters import joint_model
from tactiledata.diagnose.naming.refit import Refits
from tactiledata.diagnose.naming.screen import Screened, screen
from tactiledata.diagnose.naming.signatures import effect_signatures
from tactiledata.diagnose.naming.strength import Strength
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.errors import TactileDataError, UsageError


@pytest.fixture(scope="module")
def fitting():
    """fit(settings, to_beat): of touches of a gel that relaxes, and how many rounds it took."""
    white = WhitenedTouches.of(recorded(effect("relaxation", share=0.4, time=1.0), touches=8, slide=1e-3))

    def fit(settings, **to_beat):
        start = joint_model(START, settings, len(white.starts), len(white.simulation_errors))
        rounds = []
        with pytest.MonkeyPatch.context() as patch:
            slopes = Linearised.slopes
            patch.setattr(Linearised, "slopes", lambda self, *at: rounds.append(1) or slopes(self, *at))
            found = joint_fit(white, start, **to_beat)
        return found, len(rounds)

    return fit


@pytest.mark.slow
def test_what_is_far_behind_is_left(fitting):
    """Another explanation that costs much less than this one ever will."""
    start = effect("relaxation", share=0.1, time=0.5)
    whole, many = fitting(start)
    left, few = fitting(start, to_beat=whole.cost - 1e5)
    assert few < many
    assert left.cost > whole.cost


@pytest.mark.slow
def test_the_wrong_effect_is_as_far_behind_whether_it_is_left_or_not(fitting):
    """A yielding arm in place of the relaxing gel is as far behind, whether it is left or not."""
    wrong = effect("arm_compliance", translation=1e-5)
    best, _ = fitting(effect("relaxation", share=0.1, time=0.5))
    whole, _ = fitting(wrong)
    left, _ = fitting(wrong, to_beat=best.cost)
    assert left.cost >= whole.cost > best.cost + module.BEHIND


@pytest.mark.slow
def test_what_is_near_or_may_come_near_is_led_to_its_end(fitting):
    """A fit that is near, or may come near, is led to its end, also if a round stalls on the way."""
    start = effect("relaxation", share=0.1, time=0.5)
    whole, many = fitting(start)
    again, rounds = fitting(start, to_beat=whole.cost)
    assert (again.cost, rounds) == (whole.cost, many)


@pytest.fixture(scope="module")
def late():
    """Touches whose force sensor lags by 20 ms, with noise, and the plain fit to them."""
    white = WhitenedTouches.of(recorded(effect("lag", delay=0.02), touches=8, slide=1e-3))
    noise = np.random.default_rng(0).normal(size=white.measured.shape)
    rows = np.split(noise, white.starts[1:])
    cases = [
        dataclasses.replace(case, measured=case.measured + one * case.noise.deviations)
        for case, one in zip(white.touch_set.touches, rows, strict=True)
    ]
    white = WhitenedTouches.of(dataclasses.replace(white.touch_set, touches=cases))
    return white, plain_fit(white, START)


def test_a_fit_stands_where_the_cost_is_least(late):
    """Moved by one deviation either way, E and every error of the simulation raise the cost by one."""
    white, fit = late
    work = Linearised(white, frozenset())
    curvature = np.einsum("nkq,nkq->q", fit.shared, fit.shared) + fit.precision
    for entry in (0, *range(3, len(curvature))):
        step = 1.0 / np.sqrt(curvature[entry])
        for way in (-step, step):
            vector = fit.model.vector.copy()
            vector[entry] += way
            rise = work.evaluate(fit.model.at(vector, fit.model.offsets)).cost - fit.cost
            assert rise == pytest.approx(1.0, abs=0.2), (entry, rise)


@pytest.mark.slow
def test_a_refit_reaches_what_the_screen_promises(late):
    """The cost falls by the score of a small effect, or a little more where it is not linear: nothing is lost."""
    white, base = late
    signatures = effect_signatures(white, base.model.material, ["lag"], offsets=base.model.offsets)
    (promised,) = screen(base.metric, base.residual_at_centre, signatures)
    start = joint_model(base.model.material, promised.starts[0], len(white.starts), len(base.model.errors))
    found = joint_fit(white, start)
    assert promised.score > 40.0
    assert 0.95 * promised.score < base.cost - found.cost < 1.25 * promised.score


@pytest.mark.slow
def test_a_static_friction_is_reached_though_mu_is_at_its_bound():
    """A refit with a static friction costs at most 5 more than one from the truth, with mu at its bound before.

    To first order about that fit next to nothing slides, and a small excess changes nothing.
    """
    truth = effect("static_friction", excess=0.5, length=2e-4)
    white = WhitenedTouches.of(recorded(truth, touches=12, slide=6e-4))
    box = dataclasses.replace(find_bounds("wide"), high=(4e6, 0.495, 0.85))
    base = joint_fit(white, joint_model(START, [], len(white.starts), len(white.simulation_errors), box=box))
    assert base.model.material.friction == pytest.approx(0.85)
    signatures = effect_signatures(white, base.model.material, ["static_friction"], (), base.model.offsets)
    (promised,) = screen(base.metric, base.residual_at_centre, signatures)
    (best,) = Refits(white, base, NamingOptions(), lambda text: None).singles([promised])
    from_truth = joint_fit(white, joint_model(START, truth, len(white.starts), len(base.model.errors), box=box))
    assert base.cost - from_truth.cost > 40.0
    assert best.cost < from_truth.cost + 5.0


@pytest.mark.parametrize("balances", [True, False])
def test_an_added_effect_never_costs_more_than_the_fit_without_it(late, monkeypatch, balances):
    """A refit that its start leads astray, or that finds no balance there, is made again from next to that fit.

    That of a pair is made from what its second effect had alone, too, and the best one counts.
    """
    white, base = late
    made = {}
    far = {"lag": ("delay", 0.5), "clock_skew": ("rate", 4e-3)}

    def fit(whitened, start, held=(), rounds=12, to_beat=np.inf):
        is_far = any(setting.values[far[setting.effect][0]] >= far[setting.effect][1] for setting in start.settings)
        if is_far and not balances:
            raise UsageError("no balance", "a weaker effect", "Lessen it.")
        found = joint_fit(whitened, start, held, 0 if is_far else 2, to_beat)
        made[str(start.settings)] = found.cost
        return found

    def promising(name):
        number, value = far[name]
        strengths = frozenset({Strength(name, number)})
        return Screened(name, 1e4, 1e4, [tuple(effect(name, **{number: value}))], strengths)

    monkeypatch.setattr(kept_fits, "joint_fit", fit)
    monkeypatch.setattr(refit, "effect_signatures", lambda *_: [])
    refits = Refits(white, base, NamingOptions(), lambda text: None)
    lag, skew = (refits.singles([promising(name)])[0] for name in far)
    assert lag.cost <= base.cost
    assert skew.cost <= base.cost
    # both orders of a pair start far away
    monkeypatch.setattr(refit, "screen", lambda *_: [promising("clock_skew")])
    pairs = refits.pairs([promising(name) for name in far], [lag, skew])
    assert [pair.names for pair in pairs if pair.names[0] == "lag"] == [("lag", "clock_skew")]
    assert all(pair.cost <= lag.cost for pair in pairs if pair.names[0] == "lag")
    from_alone = made[str((*lag.model.settings, *skew.model.settings))]
    assert min(pair.cost for pair in pairs) <= from_alone


def test_a_fit_is_made_once_until_it_is_forgotten(late, monkeypatch):
    """A fit with the same start and sizes of errors is made once; others, and forgotten ones, are made anew."""
    white, base = late
    made = []

    def fit(whitened, start, held=(), rounds=12, to_beat=np.inf):
        made.append(start.settings)
        return SimpleNamespace(names=tuple(setting.effect for setting in start.settings))

    monkeypatch.setattr(kept_fits, "joint_fit", fit)
    kept, plain = KeptFits(), base.model
    lagging = joint_model(plain.material, effect("lag", delay=0.02), len(white.starts), len(plain.errors))
    first = kept.joint_fit(white, plain)
    assert kept.joint_fit(white, plain.at(plain.vector, plain.offsets.copy())) is first
    kept.joint_fit(white, lagging)
    assert len(made) == 2
    others = (
        (white, plain.at(plain.vector, plain.offsets + 1e-6)),
        (dataclasses.replace(white, errors=dataclasses.replace(white.errors, shape=0.5)), plain),
        (white.with_trust(0.5 * white.trust), plain),
        (white.with_simulated(2.0 * white.measured), plain),
    )
    for whitened, start in others:
        assert kept.joint_fit(whitened, start) is not first
    assert len(made) == 6
    kept.forget({"lag", "clipping"})
    assert kept.joint_fit(white, plain) is first
    kept.joint_fit(white, lagging)
    assert len(made) == 7
    kept.forget()
    assert kept.joint_fit(white, plain) is not first


@pytest.mark.slow
def test_a_second_naming_makes_no_fit_again(late, monkeypatch):
    """A naming that is given the fits of an earlier one of the same touches makes none, and gives the same answer."""
    white, _ = late
    options = NamingOptions(effects=("lag", "relaxation"), profile=False)
    kept, made = KeptFits(), []
    fit = kept_fits.joint_fit
    monkeypatch.setattr(kept_fits, "joint_fit", lambda *given: made.append(given) or fit(*given))
    first = name_effects(white.touch_set, START, options, kept=kept)
    count = len(made)
    assert count > 5
    again = name_effects(white.touch_set, START, options, kept=kept)
    assert len(made) == count
    assert [(one.label, one.evidence) for one in again.scored] == [(one.label, one.evidence) for one in first.scored]
    assert again.decision.claimed == first.decision.claimed


def test_several_fits_are_those_made_one_by_one(late):
    """Fits that are asked for together are those made alone, in order; one that is asked for twice is made once."""
    white, base = late
    plain = base.model
    lagging = joint_model(plain.material, effect("lag", delay=0.02), len(white.starts), len(plain.errors))
    kept = KeptFits()
    first = kept.joint_fit(white, plain, rounds=1)
    asked = [FitRequest(lagging, rounds=1), FitRequest(plain, rounds=1), FitRequest(lagging, rounds=1)]
    found = kept.joint_fits(white, asked)
    assert found[1] is first
    assert found[0] is found[2] is kept.joint_fit(white, lagging, rounds=1)
    assert found[0].cost == joint_fit(white, lagging, rounds=1).cost != first.cost


def test_a_fit_without_balance_is_none_and_a_fault_is_raised(late, monkeypatch):
    """Springs that find no balance leave a gap in the list; any other error of the toolkit ends the run."""
    white, base = late

    def fit(whitened, start, held=(), rounds=12, to_beat=np.inf):
        if rounds == 1:
            raise UsageError("no balance", "stiffer springs", "Lessen the compliances.")
        if rounds == 2:
            raise TactileDataError("a file is gone", "the file", "Look for it.")
        return base

    monkeypatch.setattr(kept_fits, "joint_fit", fit)
    asked = [FitRequest(base.model, rounds=rounds) for rounds in (1, 3)]
    assert KeptFits().joint_fits(white, asked) == [None, base]
    with pytest.raises(TactileDataError, match="a file is gone"):
        KeptFits().joint_fits(white, [FitRequest(base.model, rounds=2)])

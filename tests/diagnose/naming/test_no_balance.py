"""A diagnosis ends with an answer where gel and springs find no balance with something that it tries."""

import dataclasses

import numpy as np
import pytest
from touch_worlds import START, World, world_cases

from tactiledata.diagnose.naming import intervals
from tactiledata.diagnose.naming.intervals import IntervalRequest, profiled_intervals
from tactiledata.diagnose.naming.name_effects import name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.next_trial.rivals import rivals_of
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.unseen import errors
from tactiledata.diagnose.verdict import Verdict
from tactiledata.effects.simulate.simulator import unbalanced

SOFT = "arm_compliance"


def refuse(settings):
    """Raise the error of a play without any balance where the arm alone bends."""
    if [setting.effect for setting in settings] == [SOFT]:
        raise unbalanced(0.017, 30)


class Unplayable(TouchSet):
    """Touches of which no play finds a balance where the arm alone bends; fits do."""

    def play(self, material, settings, offsets=None, near=None):
        refuse(settings)
        return super().play(material, settings, offsets, near)


class Unfitted(TouchSet):
    """Touches of which neither plays nor fits find a balance where the arm alone bends."""

    def simulate(self, material, settings, offsets=None, near=None):
        refuse(settings)
        return super().simulate(material, settings, offsets, near)


@pytest.fixture(scope="module")
def bent():
    """Touches of an arm that bends, on a gel that relaxes."""
    return world_cases(World(compliance=1.5e-5, relaxing=0.3), 2, trajectories=16)


@pytest.mark.slow
def test_a_pair_is_judged_where_one_of_it_cannot_be_played_alone(bent):
    """What the other one changes is then not known: trajectories agree on nothing of it, and the answer is given."""
    options = NamingOptions(effects=(SOFT, "relaxation"), profile=False)
    known, unknown = (name_effects(cases, START, options) for cases in (bent, Unplayable(bent.touches, bent.base)))
    (pair,) = [one for one in known.scored if len(one.names) == 2]
    (other,) = [one for one in unknown.scored if len(one.names) == 2]
    assert pair.agreement_beside["relaxation"] > 1.0
    assert other.agreement_beside == {**pair.agreement_beside, "relaxation": 0.0}
    assert other.evidence == pair.evidence


@pytest.mark.slow
def test_what_cannot_be_played_is_no_rival(bent):
    """An undetectable effect without any balance at its strongest is left out of what a next trial should tell."""
    naming = name_effects(bent, START, NamingOptions(effects=(SOFT,), profile=False, pairs=False))
    quiet = dataclasses.replace(
        naming,
        scored=[],
        decision=dataclasses.replace(naming.decision, verdict=Verdict.NOTHING_FOUND, best=None, ties=()),
        identifiable=dataclasses.replace(
            naming.identifiable, visible=np.full_like(naming.identifiable.visible, np.inf)
        ),
    )
    unfitted = dataclasses.replace(naming.whitened, touch_set=Unfitted(bent.touches, bent.base))
    stubborn = dataclasses.replace(quiet, whitened=unfitted)
    assert [one.name for one in rivals_of(quiet).members[1:]] == [SOFT]
    assert rivals_of(stubborn).members[1:] == ()
    # the same of an effect that a screen finds, where nothing is claimed and nothing was refitted
    open_ones = [
        dataclasses.replace(one, decision=dataclasses.replace(one.decision, verdict=Verdict.NOT_EXPLAINED))
        for one in (quiet, stubborn)
    ]
    assert [one.name for one in rivals_of(open_ones[0]).members] == [SOFT]
    assert rivals_of(open_ones[1]).members == ()


@pytest.mark.slow
def test_an_interval_ends_where_there_is_no_balance(bent, monkeypatch):
    """An interval is 0.3 to 0.5 of its width by the curvature where nothing beyond half of that width has a balance."""
    naming = name_effects(bent, START, NamingOptions(effects=("relaxation",), profile=False, pairs=False))
    request = IntervalRequest(naming.whitened, naming.base, 1.0)
    by_curvature = {(end.entry, end.side): end.by_curvature for end in request.ends}

    def cost(whitened, start, held, rounds):
        (entry,) = held
        away = start.vector[entry] - naming.base.model.vector[entry]
        share = abs(away) / by_curvature[entry, np.sign(away)]
        if share > 0.5:
            raise unbalanced(0.017, 30)
        return naming.base.cost + intervals.RISE * share**2

    monkeypatch.setattr(intervals, "least_cost", cost)
    whole = request.reached(list(by_curvature.values()))
    for found, wide in zip(profiled_intervals([request])[0], whole, strict=True):
        for end, far in ((found.high, wide.high), (found.low, wide.low)):
            # a number at its bound goes no further
            assert end == far == found.value or 0.3 < (end - found.value) / (far - wide.value) < 0.5


@pytest.mark.slow
def test_an_interval_without_any_balance_ends_short_of_all_that_was_tried(bent, monkeypatch):
    """If all three tries of an end fail, it lies at 0.7 of the third try, 0.343 of the width by the curvature."""
    naming = name_effects(bent, START, NamingOptions(effects=("relaxation",), profile=False, pairs=False))
    request = IntervalRequest(naming.whitened, naming.base, 1.0)

    def cost(whitened, start, held, rounds):
        raise unbalanced(0.017, 30)

    monkeypatch.setattr(intervals, "least_cost", cost)
    expected = request.reached([intervals.SHORTER**3 * min(end.by_curvature, end.room) for end in request.ends])
    for found, end in zip(profiled_intervals([request])[0], expected, strict=True):
        assert (found.low, found.high) == pytest.approx((end.low, end.high), rel=1e-12)


@pytest.mark.slow
def test_offsets_of_held_out_touches_stay_where_the_next_have_no_balance(bent, monkeypatch):
    """Wrenches of touches that are held out are those of the offsets before."""
    naming = name_effects(bent, START, NamingOptions(effects=("relaxation",), profile=False, pairs=False))
    white, model = naming.whitened, naming.base.model
    numerical = white.simulation_error_wrenches(model.material, model.offsets)
    first = white.touch_set.played(model.material, (), model.offsets)

    def played(self, material, settings, offsets=None):
        if not np.array_equal(offsets, model.offsets):
            raise unbalanced(0.017, 30)
        return first

    monkeypatch.setattr(TouchSet, "played", played)
    found = errors._with_own_offsets(white, model, numerical)
    assert np.array_equal(found, first.wrench + numerical @ model.errors)

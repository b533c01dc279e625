"""Intervals hold what they say, and trajectories that disagree widen them."""

import numpy as np
import pytest
from closed_form import FRAMES, NOISE, TRUTH, ClosedFormWorld

from tactiledata.calibrate.bounds import find_bounds
from tactiledata.calibrate.coverage import coverage
from tactiledata.calibrate.intervals import RISE, bootstrap_intervals, intervals_hold, profile_intervals
from tactiledata.calibrate.least_squares import polish, spread
from tactiledata.calibrate.losses import NormLoss, VectorLoss
from tactiledata.calibrate.search import search

WIDE = find_bounds("wide")


def vector(world, measured):
    return VectorLoss(world.response("wide"), measured, NOISE, np.full(world.count, 40.0))


def polished(loss):
    return WIDE.scaled(polish(loss, WIDE, WIDE.shares(TRUTH)).shares)


@pytest.fixture(scope="module")
def loss():
    world = ClosedFormWorld()
    return vector(world, world.measured(offsets=np.random.default_rng(5).normal(0, 4e-5, world.count)))


@pytest.mark.slow
def test_polish_finds_what_the_search_finds(loss):
    """Gauss-Newton from a start that is not the optimum ends where nlopt does."""
    found = search(loss, WIDE, TRUTH)
    polished = WIDE.scaled(polish(loss, WIDE, WIDE.shares(TRUTH * [1.05, 0.99, 0.9])).shares)
    assert polished == pytest.approx(found, rel=2e-3)
    assert loss.value(polished) <= loss.value(found) * (1 + 1e-9)


@pytest.mark.slow
def test_the_deviance_has_risen_at_the_ends(loss):
    """Each end is where the profile has risen by the quantile, times what trajectories disagree on."""
    found = polished(loss)
    known = profile_intervals(loss, WIDE, found)
    best = polish(loss, WIDE, WIDE.shares(found)).cost
    for k in (0, 2):
        for side in (0, 1):
            assert not known.is_open[k, side]
            place = found.copy()
            place[k] = known.ends[k, side]
            rise = polish(loss, WIDE, WIDE.shares(place), held=k).cost - best
            assert rise == pytest.approx(RISE * known.inflation[k], rel=0.1)


@pytest.mark.slow
def test_what_intervals_hold_is_what_lies_between_their_ends(loss):
    """Without the search for the ends, the same answer a little within them and a little beyond; nu's is the box's."""
    found = polished(loss)
    ends = profile_intervals(loss, WIDE, found).ends
    for side in (0, 1):
        for share, is_held in ((0.95, True), (1.05, False)):
            values = found + share * (ends[:, side] - found)
            assert (intervals_hold(loss, WIDE, found, values)[[0, 2]] == is_held).all()


@pytest.mark.slow
def test_intervals_narrow_with_more_trajectories(loss):
    """Four times the trajectories give half the width."""
    many = ClosedFormWorld(80)
    other = vector(many, many.measured(offsets=np.random.default_rng(5).normal(0, 4e-5, many.count)))
    widths = []
    for one in (loss, other):
        known = profile_intervals(one, WIDE, polished(one))
        widths.append(np.ptp(known.ends, axis=1) / np.sqrt(known.inflation))
    assert widths[0][[0, 2]] / widths[1][[0, 2]] == pytest.approx(2.0, abs=0.7)


def test_trajectories_that_disagree_widen_the_intervals():
    """A factor on all forces, another for each trajectory, is more than the noise explains."""
    world = ClosedFormWorld()
    factors = 1 + 0.2 * np.random.default_rng(0).standard_normal(world.count)
    measured = world.measured()
    inflation = []
    for values in (measured, measured * np.repeat(factors, FRAMES)[:, None]):
        one = vector(world, values)
        inflation.append(spread(one, WIDE, WIDE.shares(polished(one))).inflation)
    assert inflation[0].max() < 2.5
    assert inflation[1][0] > 2 * inflation[0][0]


def test_an_interval_that_only_the_bounds_end_is_open():
    """Without slip nothing tells mu from above."""
    world = ClosedFormWorld(shear=1e-5)
    one = vector(world, world.measured())
    known = profile_intervals(one, WIDE, polished(one))
    assert known.is_open[2, 1]
    assert known.ends[2, 1] == WIDE.high[2]


@pytest.mark.slow
def test_the_bootstrap_is_the_same_for_a_seed():
    """One seed gives the same bootstrap intervals twice, another seed gives others; low ends lie below high ends."""
    world = ClosedFormWorld(12)
    one = NormLoss(world.response(), world.measured())
    bounds = find_bounds("paper")
    found = search(one, bounds, TRUTH)
    draws = [bootstrap_intervals(one, bounds, found, seed, draws=5).ends for seed in (1, 1, 2)]
    assert (draws[0] == draws[1]).all()
    assert (draws[0] != draws[2]).any()
    assert (draws[0][:, 0] <= draws[0][:, 1]).all()


@pytest.mark.slow
def test_coverage_counts_what_is_covered(loss):
    """A few draws give shares between 0 and 1, the same for a seed."""
    one, other = (coverage(loss, WIDE, TRUTH, draws=2, seed=1) for _ in range(2))
    assert (one.share == other.share).all()
    assert ((one.share >= 0) & (one.share <= 1)).all()


@pytest.mark.nightly
def test_nominal_95_percent_covers_90_to_98(loss):
    """Intervals hold the truth in 90 to 98 % of 200 surrogate data sets, with noise, zeros and offsets drawn anew."""
    found = coverage(loss, WIDE, TRUTH, draws=200, seed=0)
    assert (found.share >= 0.90).all()
    assert (found.share <= 0.985).all()

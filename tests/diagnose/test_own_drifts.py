"""What own parameters follow: nothing in nulls, and what is planted with its size, whatever else hides it."""

import dataclasses

import numpy as np
import pytest
from planted import planted

from tactiledata.diagnose.locate.own_offsets import own_drifts, own_values
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Covariate, ResidualParameter

DRAWS = 299


def dome(world, radius=100.0):
    """Deeper by r^2 / (2 R) in the middle than at r, mm."""
    x, y = (world.covariates[name].values for name in "xy")
    return world.slopes[:, :, 2] * ((x**2 + y**2) / (-2 * radius))[:, None]


def with_distance(world):
    x, y = (world.covariates[name].values for name in "xy")
    return dataclasses.replace(world, covariates={**world.covariates, "distance": Covariate(np.hypot(x, y), "mm")})


def found(world, seed=0, draws=DRAWS):
    return own_drifts(project(world), seed, draws)


def test_nulls_follow_nothing():
    """Of 60 nulls with correlated noise and unequal offsets, 5 % and three standard errors at most are drifts."""
    alarms = [found(with_distance(planted(seed)))[0].p <= 0.05 for seed in range(60)]
    assert np.mean(alarms) <= 0.05 + 3 * np.sqrt(0.05 * 0.95 / 60)


def test_values_are_those_that_were_dealt():
    """Offsets come back to a twentieth of their scatter where the forces tell them so well."""
    world = planted(3, trajectories=60, heavy=False, random_effects=False)
    dealt = np.random.default_rng(5).normal(0, 0.04, 60)
    hidden = world.with_values(world.values + world.slopes[:, :, 2] * np.repeat(dealt, 15)[:, None])
    told = own_values(project(hidden))["offset"]
    assert np.corrcoef(told, dealt)[0, 1] > 0.9


def test_values_are_the_most_likely_ones_under_all_priors():
    """The values are those of the normal equations over all numbers, with an error that two indenters share."""
    world = planted(6)
    field = world.slopes[:, :, 2] * (0.02 * (world.labels["indenter"] != "cone"))[:, None]
    error = dataclasses.replace(ResidualParameter("error"), is_tested=False, prior_deviation=1.0)
    given = dataclasses.replace(world.with_fields({"error": field}), parameters=(*world.parameters, error))
    trajectories = len(given.starts)
    own = np.zeros((*given.values.shape, trajectories))
    own[np.arange(len(given.values)), :, given.trajectory] = given.slopes[:, :, 2]
    columns = np.concatenate([given.slopes[:, :, [0, 1, 3]], own], axis=2).reshape(-1, 3 + trajectories)
    precision = np.array([0.0, 0.0, 1.0, *np.full(trajectories, 0.04**-2)])
    expected = np.linalg.solve(columns.T @ columns + np.diag(precision), columns.T @ given.values.ravel())
    np.testing.assert_allclose(own_values(project(given))["offset"], expected[3:], atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_dome_is_told_by_the_distance_from_the_middle(seed):
    """Its fall within the interval, no other covariate before it."""
    plain = with_distance(planted(seed, 60))
    first = found(plain.with_values(plain.values + dome(plain)), seed, 999)[0]
    assert (first.parameter, first.covariate) == ("offset", "distance")
    assert first.p <= 0.05
    assert first.words.startswith("each trajectory's own offset falls by")
    distance = plain.covariates["distance"].values[plain.starts]
    slope = np.polyfit(distance, -(distance**2) / 200.0, 1)[0]
    span = slope * float(np.diff(np.quantile(plain.covariates["distance"].values, [0.05, 0.95]))[0])
    assert abs(first.change.value - span) < 1.5 * first.change.half_width


def test_an_indenter_is_named():
    """An indenter with an offset of its own is named, at its level, with its sign."""
    world = planted(4, 60)
    deeper = world.slopes[:, :, 2] * (0.1 * (world.labels["indenter"] == "cone"))[:, None]
    first = found(world.with_values(world.values + deeper))[0]
    assert (first.covariate, first.at) == ("indenter", "cone")
    assert "rises by" in first.words
    assert "at indenter cone, against all others" in first.words


def test_what_varies_inside_trajectories_is_not_asked():
    """Depth goes up and down in each trajectory, and the fitted offset is a part of it."""
    assert {"depth", "phase", "contact"}.isdisjoint({one.covariate for one in found(planted(0))})


def test_parameters_that_are_not_asked_are_silent():
    """A parameter that is not to be tested gives no finding."""
    world = planted(0)
    kept = tuple(dataclasses.replace(one, is_tested=False) for one in world.parameters)
    assert found(dataclasses.replace(world, parameters=kept)) == ()


def test_blocks_are_exchanged_as_one():
    """Blocks of two trajectories are exchanged as one: there are half as many units as trajectories."""
    world = planted(0)
    blocked = dataclasses.replace(world, blocks=world.groups // 2)
    assert own_values(project(blocked))["offset"].shape == (20,)
    # places, speeds, times and indenters differ inside a block, its number does not
    assert {one.covariate for one in found(blocked)} == {"index"}


def test_a_seed_says_the_same():
    """One seed gives the same findings twice."""
    assert [one.words for one in found(planted(1), 7)] == [one.words for one in found(planted(1), 7)]

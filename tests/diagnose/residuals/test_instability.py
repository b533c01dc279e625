"""Drifting parameters: found where planted, with the right size, and not where there are none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planted import MODULUS, modulus_over, planted

from tactiledata.diagnose.locate.drifts import look_alikes, parameter_drifts
from tactiledata.diagnose.locate.free_air import with_zeros
from tactiledata.diagnose.residuals.instruments import slope, steps
from tactiledata.diagnose.residuals.projection import project
from tactiledata.diagnose.residuals.residuals import Covariate
from tactiledata.diagnose.residuals.scores import contributions
from tactiledata.diagnose.residuals.sign_flips import family_wise, signs
from tactiledata.diagnose.residuals.slopes import change
from tactiledata.errors import TactileDataError


def at_most(rate, count, level):
    """Whether a number of alarms is one that the level explains."""
    return rate * count <= level * count + 3.0 * np.sqrt(level * (1 - level) * count)


@pytest.mark.parametrize(("covariate", "share"), [("depth", 0.12), ("minutes", -0.2), ("speed", 0.25)])
def test_a_planted_drift_is_the_first_answer(covariate, share):
    """E over a covariate is the strongest pair, with its sign, and its interval holds the truth."""
    values = planted().covariates[covariate].values
    low, high = (0.2, 1.0) if covariate == "depth" else np.quantile(values, [0.05, 0.95])
    world = planted(3, 60, plant=modulus_over(covariate, share, low, high, covariate == "speed"))
    first = parameter_drifts(project(world), draws=499)[0]
    assert (first.parameter, first.p <= 0.01) == ("E", True)
    assert covariate in (first.covariate, *first.alike)
    assert np.sign(first.change.value) == np.sign(share)
    assert ("rises" if share > 0 else "falls") in first.words
    assert "%" in first.words


@pytest.mark.slow
def test_the_false_alarm_rate_is_the_level():
    """Noise that is correlated and of all sizes, moduli of trajectories that differ: 5 % alarms in 120 nulls."""
    smallest = [
        min(one.p for one in parameter_drifts(project(planted(seed, 24, 10)), seed, draws=199)) for seed in range(120)
    ]
    assert at_most(np.mean(np.array(smallest) <= 0.05), 120, 0.05)
    assert 0.1 < np.mean(np.array(smallest) <= 0.3) < 0.45, "p-values are uniform, not merely large"


@pytest.mark.slow
def test_frames_as_units_would_cry_wolf():
    """The pitfall: taking each frame for a trajectory makes an alarm of most nulls with correlated noise."""
    alarms = 0
    for seed in range(20):
        world = planted(seed, 24, 10, own=False)
        pretended = type(world)(
            world.values, world.components, np.arange(len(world.values)), world.covariates, {}, world.parameters,
            world.sensitivities,
        )  # fmt: skip
        alarms += parameter_drifts(project(pretended), seed, draws=199)[0].p <= 0.05
    assert alarms >= 10


def test_intervals_cover():
    """Of 150 intervals of 95 %, at least 88 % hold the planted change."""
    share, held = 0.1, 0
    for seed in range(150):
        world = planted(seed, 30, 10, plant=modulus_over("x", share, -6, 6))
        projection = project(world)
        x = world.covariates["x"].values
        moved = change(projection, 0, (x + 6) / 12)
        held += abs(moved.value - share * MODULUS) <= moved.half_width
    assert held >= 132


def test_what_a_refit_takes_away_is_no_evidence():
    """A change of E common to all frames moves no score; the refit finds it."""
    world = planted(1)
    moved = world.with_values(world.values + world.slopes[:, :, 0] * 30.0)
    first, second = project(world), project(moved)
    np.testing.assert_allclose(second.refit - first.refit, [30.0, 0.0], atol=1e-6)
    for place in (0, 1):
        instruments = steps(world.covariates["depth"].values, np.array([0.3, 0.6]))
        one, other = (contributions(each, place, instruments).by_unit for each in (first, second))
        np.testing.assert_allclose(one, other, atol=1e-6)


def test_own_parameters_take_away_what_they_can():
    """A contact offset of each trajectory, with a prior that allows any, leaves every score as it was."""
    from dataclasses import replace

    world = planted(2)
    free = replace(world, parameters=(*world.parameters[:2], replace(world.parameters[2], own_deviation=float("inf"))))
    offsets = np.random.default_rng(0).normal(0, 0.3, 40)[world.trajectory]
    moved = free.with_values(free.values + world.slopes[:, :, 2] * offsets[:, None])
    instruments = steps(world.covariates["minutes"].values, np.array([20.0]))
    one, other = (contributions(project(each), 0, instruments).by_unit for each in (free, moved))
    np.testing.assert_allclose(one, other, atol=1e-5 * np.abs(one).max())


def test_scores_agree_with_a_dense_twin():
    """Contributions equal those of explicit covariance matrices and a projection written out."""
    world = planted(5, 9, 6)
    projection = project(world)
    instrument = steps(world.covariates["depth"].values, np.array([0.4]))
    n, k = world.values.shape
    own = np.zeros((n * k, n * k))
    for start, count in zip(world.starts, world.counts, strict=True):
        rows = slice(start * k, (start + count) * k)
        s = world.slopes[start : start + count, :, 2].ravel()
        own[rows, rows] = 0.04**2 * np.outer(s, s)
    weight = np.linalg.inv(np.eye(n * k) + own)
    shared = world.slopes[:, :, :2].reshape(n * k, 2)
    alternative = (world.slopes[:, :, 0] * instrument).reshape(-1)
    inverse = np.linalg.inv(shared.T @ weight @ shared)
    left = world.values.ravel() - shared @ (inverse @ shared.T @ weight @ world.values.ravel())
    clean = alternative - shared @ (inverse @ shared.T @ weight @ alternative)
    expected = np.add.reduceat((clean * (weight @ left)).reshape(n, k).sum(axis=1), world.starts)
    found = contributions(projection, 0, instrument)
    np.testing.assert_allclose(found.by_unit[:, 0], expected, atol=1e-8)
    np.testing.assert_allclose(found.information[0], clean @ weight @ clean, rtol=1e-8)


def test_statistics_agree_with_refits_written_out():
    """The statistics are those of refits with signs thrown anew: all parameters and the alternative are fitted.

    The standard error is the sandwich of that fit's scores.
    """
    from scipy.stats import norm
    from scipy.stats import t as student

    world = planted(7, 30, 8, own=False)
    projection = project(world)
    instrument = steps(world.covariates["depth"].values, np.array([0.3]))
    found = contributions(projection, 0, instrument)
    thrown = signs(30, 5, 3)
    alternative = (world.slopes[:, :, 0] * instrument)[:, :, None]
    design = np.concatenate([world.slopes, alternative], axis=2)
    clean = projection.orthogonal(alternative)[:, :, 0]
    expected = []
    for one in thrown:
        flipped = projection.left * one[world.trajectory][:, None]
        fit = np.linalg.lstsq(design.reshape(-1, 3), flipped.ravel(), rcond=None)[0]
        left = flipped - design @ fit
        scores = np.add.reduceat((clean * left).sum(axis=1), world.starts)
        freedom = found.effective[0] - 1.0
        deviation = np.sqrt((scores**2).sum() * (freedom + 1.0) / freedom) / found.information[0]
        expected.append(norm.ppf(student.cdf(fit[2] / deviation, freedom)))
    np.testing.assert_allclose(found.flipped(thrown)[:, 0], expected, rtol=0.02, atol=0.005)


def test_the_same_seed_gives_the_same_answer():
    """Bit for bit; another seed gives another throw."""
    projection = project(planted(4))
    assert parameter_drifts(projection, 7, 99) == parameter_drifts(projection, 7, 99)
    assert [one.p for one in parameter_drifts(projection, 7, 99)] != [
        one.p for one in parameter_drifts(projection, 8, 99)
    ]


def test_the_order_of_trajectories_does_not_matter():
    """Statistics are the same when trajectories come in another order."""
    world = planted(6, 12)
    order = np.random.default_rng(0).permutation(12)
    rows = np.concatenate([np.flatnonzero(world.trajectory == one) for one in order])
    shuffled = type(world)(
        world.values[rows], world.components, world.groups[rows],
        {name: Covariate(one.values[rows], one.unit) for name, one in world.covariates.items()},
        {name: one[rows] for name, one in world.labels.items()}, world.parameters, world.slopes[rows],
    )  # fmt: skip
    one, other = (
        {(drift.parameter, drift.covariate): drift.statistic for drift in parameter_drifts(project(each), 0, 19)}
        for each in (world, shuffled)
    )
    assert one.keys() == other.keys()
    np.testing.assert_allclose([one[key] for key in one], [other[key] for key in one], rtol=1e-9)


def test_covariates_that_cannot_be_told_apart_are_named():
    """Minutes that grow with the index are said to be its like."""
    world = planted(0)
    clock = Covariate(world.covariates["index"].values * 2.0 + 1.0, "min")
    both = type(world)(
        world.values, world.components, world.groups, {**world.covariates, "clock": clock}, world.labels,
        world.parameters, world.slopes,
    )  # fmt: skip
    assert look_alikes(both)["clock"] == ("index",)
    assert look_alikes(both)["depth"] == ()


def test_indenters_that_were_mounted_one_after_the_other_are_named():
    """The index then cannot be told from the indenter; mounted in turns it can."""
    world = planted(0)
    for number, expected in ((world.trajectory // 10, ("indenter",)), (world.trajectory % 4, ())):
        mounted = type(world)(
            world.values, world.components, world.groups, world.covariates, {"indenter": number.astype(str)},
            world.parameters, world.slopes,
        )  # fmt: skip
        assert look_alikes(mounted)["index"] == expected
        assert ("index" in look_alikes(mounted)["indenter"]) == bool(expected)


def test_a_zero_that_drifts_is_no_modulus_that_does():
    """A zero of fz that drifts is named by its size in newtons, and no modulus is."""
    world = with_zeros(planted(4, 60, own=False))
    minutes = world.covariates["minutes"].values
    drifting = world.values + np.column_stack([0 * minutes, 0 * minutes, 3.0 * minutes / 90])
    first = parameter_drifts(project(world.with_values(drifting)), draws=499)[0]
    assert (first.parameter, first.covariate, first.p <= 0.01) == ("zero of fz", "minutes", True)
    assert abs(first.change.value - 0.3 * 0.9) < 1.5 * first.change.half_width


def test_few_trajectories_are_said():
    """Seven are too few for a test that exchanges trajectories."""
    with pytest.raises(TactileDataError, match="at least 8"):
        parameter_drifts(project(planted(0, 7)))


def test_blocks_are_exchanged_where_they_are_given():
    """Contributions are summed over days of recording; the score itself is that of single trajectories."""
    from dataclasses import replace

    world = planted(3, 60)
    days = world.trajectory // 6
    by_day = replace(world, blocks=days)
    assert by_day.unit_count == 10
    total = contributions(project(by_day), 0, steps(world.covariates["depth"].values, np.array([0.5])))
    single = contributions(project(world), 0, steps(world.covariates["depth"].values, np.array([0.5])))
    np.testing.assert_allclose(total.size, single.size)
    assert len(total.by_unit) == 10


@given(st.integers(2, 12), st.integers(0, 10**6))
def test_family_wise_values_are_an_order_of_the_statistics(count, seed):
    """A larger statistic never has a larger p-value, and none is below that of the single test."""
    rng = np.random.default_rng(seed)
    observed, drawn = rng.exponential(size=count), rng.exponential(size=(99, count))
    p_values = family_wise(observed, drawn)
    order = np.argsort(-observed)
    assert (np.diff(p_values[order]) >= 0).all()
    assert (p_values >= (1 + (drawn >= observed).sum(axis=0)) / 100 - 1e-12).all()


def test_signs_are_fair():
    """Half are minus, none is anything else."""
    thrown = signs(40, 2000, 0)
    assert set(np.unique(thrown)) == {-1.0, 1.0}
    assert abs(thrown.mean()) < 0.02


def test_a_slope_spans_the_quantiles():
    """A slope is 0 at the 5 % quantile and 1 at the 95 % quantile, on a logarithm if the covariate spans decades."""
    values = 10 ** np.linspace(-2, 2, 1001)
    instrument, low, high = slope(values, np.ones(1001))
    np.testing.assert_allclose([low, high], [10**-1.8, 10**1.8], rtol=0.02)
    np.testing.assert_allclose(np.interp([low, 1.0, high], values, instrument[:, 0]), [0, 0.5, 1], atol=0.01)

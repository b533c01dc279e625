"""Intervals: they cover, they know that frames of a touch are no independent samples, and they say when they cannot."""

import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.metrics.bootstrap import LEAST_GROUPS, bootstrap


def world(rng, groups=30, size=12, between=1.0, within=0.2):
    """Values whose trajectories differ; the mean over all worlds is 0."""
    names = np.repeat(np.arange(groups), size)
    return rng.normal(0, between, groups)[names] + rng.normal(0, within, names.size), names


def test_intervals_cover():
    """95 % intervals hold the true mean in about 95 % of worlds; as if frames were independent they would not."""
    rng = np.random.default_rng(0)
    covered = naive = 0
    for trial in range(200):
        values, names = world(rng)
        by_touch = bootstrap(values, names, rounds=300, seed=trial)
        by_frame = bootstrap(values, np.arange(len(values)), rounds=300, seed=trial)
        covered += by_touch.low <= 0 <= by_touch.high
        naive += by_frame.low <= 0 <= by_frame.high
    assert 0.88 < covered / 200 < 0.99
    assert naive / 200 < 0.6


def test_a_statistic_of_rows_agrees_with_the_quick_mean():
    """The mean by the general way has the same interval, up to the draws."""
    values, names = world(np.random.default_rng(1))
    quick, general = bootstrap(values, names, rounds=800), bootstrap(values, names, statistic=np.mean, rounds=800)
    assert quick.value == pytest.approx(general.value)
    assert quick.low == pytest.approx(general.low, abs=0.1)
    assert quick.high == pytest.approx(general.high, abs=0.1)


def test_samples_without_a_value_are_left_out_and_counted():
    """NaN stands for an empty mask: it moves nothing."""
    values, names = world(np.random.default_rng(2))
    some = values.copy()
    some[5::7] = np.nan
    found = bootstrap(some, names)
    assert found.value == pytest.approx(np.nanmean(some))
    assert found.left_out == np.isnan(some).sum()
    assert found.samples + found.left_out == len(values)


def test_too_few_trajectories_have_no_interval():
    """A value, but no interval; one more trajectory and there is one."""
    values = np.arange(float(LEAST_GROUPS))
    few = bootstrap(values[1:], np.arange(LEAST_GROUPS - 1))
    assert np.isnan(few.low)
    assert str(few) == "2.5"
    assert np.isfinite(bootstrap(values, np.arange(LEAST_GROUPS)).low)


def test_infinite_values_stay_infinite():
    """The PSNR of equal pictures is infinite, and so is a mean with it; no warning."""
    assert bootstrap([np.inf, 30, 31, 29, 30, 32], range(6)).value == np.inf


def test_what_cannot_be_resampled_is_refused():
    """No values at all, and trajectories of another length, are refused."""
    with pytest.raises(UsageError, match="mask"):
        bootstrap([np.nan], ["a"])
    with pytest.raises(UsageError, match="trajectory for each"):
        bootstrap([1.0, 2.0], ["a"])

"""Intervals that the binomial distribution foretells, what is counted, and what is refused."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from tactiledata.errors import UsageError
from tactiledata.metrics.bootstrap import Interval, bootstrap

ONE_IN_FIVE = [0.0, 0.0, 0.0, 0.0, 1.0]
"""Of five draws, the number of ones is binomial: at most 0, 1, 2, 3 with 33, 74, 94.2, 99.3 %."""


@pytest.mark.parametrize(("level", "high"), [(0.2, 0.2), (0.4, 0.2), (0.6, 0.4), (0.8, 0.4), (0.95, 0.6), (0.999, 0.8)])
def test_ends_are_the_quantiles_of_the_binomial(level, high):
    """The upper end at 60, 70, 80, 90, 97.5 and 99.95 %; for the complement the lower end is one less it."""
    found = bootstrap(ONE_IN_FIVE, list("abcde"), level=level, rounds=20_000)
    assert (found.value, found.high) == pytest.approx((0.2, high))
    assert found.low == pytest.approx(0.0 if level > 0.4 else {0.2: 0.2, 0.4: 0.0}[level])
    other = bootstrap(1 - np.array(ONE_IN_FIVE), range(5), level=level, rounds=20_000)
    assert other.low == pytest.approx(1 - high)


def test_the_interval_is_of_95_percent_from_a_thousand_draws_of_seed_0():
    """What is not said is as if it were said so; another level, seed or number of draws gives another interval."""
    values, names = np.random.default_rng(0).normal(size=40), np.repeat(np.arange(20), 2)
    found = bootstrap(values, names)
    assert found == bootstrap(values, names, level=0.95, rounds=1000, seed=0)
    for other in ({"level": 0.9}, {"seed": 1}, {"rounds": 999}):
        assert found != bootstrap(values, names, **other)


def test_a_statistic_sees_the_rows_of_the_same_draws():
    """The mean of drawn rows is drawn as the quick way draws it, also where trajectories differ in length."""
    rng = np.random.default_rng(1)
    names = rng.permutation(np.repeat(np.arange(7), [1, 2, 3, 4, 5, 6, 7]))
    values = rng.normal(size=28) + names
    quick, general = bootstrap(values, names, rounds=200), bootstrap(values, names, rounds=200, statistic=np.mean)
    assert (general.low, general.high) == pytest.approx((quick.low, quick.high))


def test_a_draw_has_whole_trajectories():
    """Each draw has as many trajectories as there are, each with all of its rows."""
    rows = np.stack([np.repeat(np.arange(6), 3), np.tile(np.arange(3), 6)], axis=1)
    seen = []

    def note(drawn):
        seen.append(drawn)
        return 0.0

    bootstrap(rows, rows[:, 0], statistic=note, rounds=20)
    assert len(seen) == 21  # all rows first
    for drawn in seen:
        assert drawn.shape == (18, 2)
        for first in range(0, 18, 3):
            assert drawn[first : first + 3, 1].tolist() == [0, 1, 2]
            assert len(set(drawn[first : first + 3, 0])) == 1
    assert len({tuple(drawn[:, 0]) for drawn in seen}) > 15


def test_a_mean_weighs_samples_alike():
    """A trajectory of many samples counts more: five equal values have no spread, whatever the lengths are."""
    names = np.repeat(np.arange(5), [1, 10, 2, 7, 30])
    found = bootstrap(np.full(50, 2.5), names)
    assert (found.value, found.low, found.high) == (2.5, 2.5, 2.5)
    # of two lengths, 1 and 9, the mean of all is nine tenths
    lengths = np.repeat(np.arange(6), [1, 9, 1, 9, 1, 9])
    assert bootstrap((lengths % 2).astype(float), lengths).value == pytest.approx(0.9)


def test_what_took_part_is_counted():
    """Samples with a value, their trajectories, and samples without one; a row with any NaN has none."""
    values = [1.0, np.nan, 3.0, np.nan]
    found = bootstrap(values, ["a", "b", "a", "c"])
    assert (found.value, found.samples, found.trajectories, found.left_out) == (2.0, 2, 1, 2)
    rows = [[1.0, 2.0], [np.nan, 2.0], [3.0, np.nan], [5.0, 6.0]]
    found = bootstrap(rows, list("abcd"), statistic=lambda kept: float(kept.sum()))
    assert (found.value, found.samples, found.left_out) == (14.0, 2, 2)


@pytest.mark.parametrize(("count", "has_ends"), [(4, False), (5, True), (6, True)])
def test_five_trajectories_are_enough(count, has_ends):
    """With four there is a value alone."""
    found = bootstrap(np.arange(float(count)), range(count))
    assert np.isfinite([found.low, found.high]).tolist() == [has_ends] * 2


def test_an_interval_is_said_with_four_digits():
    """The interval stands in brackets behind the value, and the value stands alone if there is none."""
    assert str(Interval(1.23456, 0.98765, 12345.6, 9, 9, 0)) == "1.235 [0.9877, 1.235e+04]"
    assert str(Interval(1.23456, np.nan, np.nan, 9, 2, 0)) == "1.235"


@pytest.mark.parametrize(
    ("values", "names", "words"),
    [
        ([], [], "none of 0 samples has a value"),
        ([np.nan, np.nan], [0, 1], "none of 2 samples has a value"),
        (3.0, 3.0, "a trajectory for each value"),
        ([1.0, 2.0], [0], "a trajectory for each value"),
        ([1.0], [0, 1], "a trajectory for each value"),
        ([[1.0, 2.0], [3.0, 4.0]], [0, 1], r"values of shape \(2, 2\)"),
    ],
)
def test_what_has_no_mean_is_refused(values, names, words):
    """Values that are none, all NaN, one number, of other lengths or without a statistic are refused."""
    with pytest.raises(UsageError, match=words):
        bootstrap(values, names)


def test_an_interval_that_was_found_stays():
    """No field of an interval can be set anew."""
    with pytest.raises(FrozenInstanceError):
        bootstrap(ONE_IN_FIVE, list("abcde")).value = 0.0

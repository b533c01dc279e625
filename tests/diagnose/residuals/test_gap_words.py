"""Shares of a gap as people read them: all of it, a part, or more of it than before."""

import pytest

from tactiledata.diagnose.residuals.gap import Gap
from tactiledata.diagnose.residuals.wording import change_words, gap_words


@pytest.mark.parametrize(
    ("closed", "interval", "said"),
    [
        (1.7, (1.2, 2.8), "all"),
        (1.7, (0.8, 2.8), "100 % (80 % to 100 %)"),
        (0.5, (0.25, 0.75), "50 % (25 % to 75 %)"),
        (float("nan"), (float("nan"), float("nan")), "-"),
    ],
)
def test_no_more_than_the_whole_is_said_and_no_interval_of_nothing(closed, interval, said):
    """An interval that is cut on both sides would be "100 % (100 % to 100 %)", which tells nobody anything."""
    assert gap_words(Gap(0.2, 0.1, 0.1, closed, interval), True) == said


def test_without_a_gap_there_is_no_share():
    """Without a gap a dash stands for the share, however large the ratio of two small numbers is."""
    assert gap_words(Gap(0.1, 0.1, 0.1, 5.0, (1.5, 9.0)), False) == "-"


def test_a_gap_that_grows_is_not_closed_by_less_than_nothing():
    """Growth is stated as growth, beyond the whole gap too, with the interval from the smaller to the larger."""
    assert (
        change_words(Gap(0.12, 0.2, 0.1, -1.5, (-2.5, -0.5))) == "the gap to the noise grows by 150 % (50 % to 250 %)"
    )
    assert change_words(Gap(0.2, 0.1, 0.1, 1.7, (1.2, 2.8))) == "all of the gap is closed"

"""The time that is left of a long command, from the time that it has taken."""

import pytest

from tactiledata.cli.output import time_left


@pytest.mark.parametrize(
    ("done", "total", "seconds", "said"),
    [
        (10, 40, 60.0, ", about 3 min left"),
        (1, 3, 30.0, ", about 1 min left"),
        (1, 2, 59.0, ""),
        (40, 40, 600.0, ""),
        (0, 40, 600.0, ""),
        (1, 481, 4.0, ""),
        (24, 481, 96.0, ""),
        (25, 481, 96.0, ", about 29 min left"),
    ],
)
def test_the_time_left_is_in_proportion_to_the_steps_left(done, total, seconds, said):
    """A quarter done in a minute leaves three; nothing is said below a minute, at the end, before 25 of 481."""
    assert time_left(done, total, seconds) == said

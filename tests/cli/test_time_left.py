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
    ],
)
def test_the_time_left_is_in_proportion_to_the_steps_left(done, total, seconds, said):
    """A quarter done in a minute leaves three; below a minute, at the end and before the first step nothing is said."""
    assert time_left(done, total, seconds) == said

"""Numbers of things in words."""

import pytest

from tactiledata.contract.wording import counted


@pytest.mark.parametrize(
    ("number", "noun", "words"),
    [
        (0, "frame", "0 frames"),
        (1, "frame", "1 frame"),
        (2, "frame", "2 frames"),
        (0, "trajectory", "0 trajectories"),
        (1, "trajectory", "1 trajectory"),
        (2, "trajectory", "2 trajectories"),
        (-1, "frame", "-1 frames"),
    ],
)
def test_a_noun_is_in_the_singular_after_one_alone(number, noun, words):
    """One frame is in the singular, and all other numbers take the plural, of trajectories too."""
    assert counted(number, noun) == words

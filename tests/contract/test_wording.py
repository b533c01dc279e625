"""Numbers of things in words."""

import pytest

from tactiledata.contract.wording import agreeing, counted, listed


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


@pytest.mark.parametrize(("number", "word"), [(-1, "are"), (0, "are"), (1, "is"), (2, "are")])
def test_a_verb_agrees_with_one_alone(number, word):
    """One frame is, and all other numbers of them are."""
    assert agreeing(number, "is", "are") == word


@pytest.mark.parametrize(
    ("names", "words"), [([], ""), (["a"], "a"), (["a", "b"], "a, b"), (["a", "b", "c"], "a, b …")]
)
def test_what_is_not_listed_is_marked(names, words):
    """Two names at most; the mark stands only where there is a third."""
    assert listed(names, 2) == words

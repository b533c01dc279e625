"""The Tab key completes commands and options in a shell that was told how."""

import pytest
from command import run_command


@pytest.mark.parametrize(
    ("words", "place", "completed"),
    [("tactiledata spl", "1", "split"), ("tactiledata split --frac", "2", "--fractions"), ("tactiledata xyz", "1", "")],
)
def test_words_are_completed(capsys, monkeypatch, words, place, completed):
    """A shell asks by environment variables; the answer is one word a line, and nothing where nothing fits."""
    monkeypatch.setenv("_TACTILEDATA_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", place)
    code, out, err = run_command(capsys)
    assert (code, out.split(), err) == (0, completed.split(), "")

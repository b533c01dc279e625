"""What of a program is its digest."""

from tactiledata.contract.program import statements


def test_words_about_a_program_leave_its_plays_valid():
    """Docstrings, comments and blank lines are no part of the digest; numbers, defaults and texts in use are."""
    inside = '    """Return a share."""\n    return a / b if a else "none"\n'
    program = 'LIMIT = 2\n"""A limit."""\n\n\ndef share(a, b=1):\n' + inside
    words = 'LIMIT = 2\n# a comment\ndef share(a, b=1):\n    return a / b if a else "none"\n'
    assert statements(program) == statements(words)
    changed = [("LIMIT = 2", "LIMIT = 3"), ("b=1", "b=2"), ('"none"', '"nothing"'), ("a / b", "a * b")]
    assert len({statements(program), *(statements(program.replace(*pair)) for pair in changed)}) == 5

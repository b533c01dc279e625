"""Git LFS pointers are told by their first line alone, and named with what fetches the file."""

import os

import pytest

from tactiledata.contract.lfs_pointer import (
    START,
    fault_words,
    is_lfs_pointer,
    not_fetched,
    pointer_words,
    refuse_lfs_pointer,
    refuse_pointer_bytes,
)
from tactiledata.errors import BrokenLog, NotFetched

POINTER = START + b"\noid sha256:4d7a\nsize 12345\n"


@pytest.mark.parametrize(
    ("content", "is_pointer"),
    [
        (POINTER, True),
        (START, True),
        (START[:-1], False),
        (b"", False),
        (b" " + POINTER, False),
        (POINTER[::-1], False),
    ],
)
def test_a_pointer_is_told_by_how_it_begins(tmp_path, content, is_pointer):
    """The whole first line, at the very start: a byte less, or one before it, is another file."""
    path = tmp_path / "x.bin"
    path.write_bytes(content)
    assert is_lfs_pointer(path) == is_pointer
    for refuse in (lambda: refuse_lfs_pointer(path), lambda: refuse_pointer_bytes(content, str(path))):
        if is_pointer:
            with pytest.raises(NotFetched) as caught:
                refuse()
            assert caught.value.facts["file"] == str(path)
        else:
            refuse()


def test_what_is_no_file_is_no_pointer(tmp_path):
    """A folder, a pipe that nobody writes to and a path without anything are no pointers, without waiting."""
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path, tmp_path / "pipe", tmp_path / "nothing", tmp_path / ("x" * 300)):
        assert not is_lfs_pointer(path)
        refuse_lfs_pointer(path)


@pytest.mark.parametrize(("others", "words"), [(0, "a.png is a"), (1, "a.png (and 1 more) is a"), (9, "(and 9 more)")])
def test_other_pointers_are_counted(others, words):
    """One alone is named; with others it is said how many more there are."""
    assert words in str(not_fetched("a.png", others))
    assert words in pointer_words("a.png", others)


def test_one_alone_by_default():
    """A pointer file stands alone unless a number of others is stated."""
    assert str(not_fetched("a.png")) == str(not_fetched("a.png", 0))
    assert pointer_words("a.png") == "a.png is a Git LFS pointer, not the file; run `git lfs pull`"


def test_the_remedy_stands_with_pointers_alone():
    """A finding about another fault does not advise to fetch a file."""
    assert fault_words(BrokenLog("a cut file", "a whole one")) == "a cut file"

"""Git LFS pointers: small texts that a repository holds in the place of files that were not fetched."""

from __future__ import annotations

from pathlib import Path

from tactiledata.errors import NotFetched, TactileDataError

START = b"version https://git-lfs.github.com/spec/v1"
"""How a pointer begins."""
POINTER_WORDS = "is a Git LFS pointer"
"""What every message about a pointer says."""


def is_lfs_pointer(path: Path) -> bool:
    """Whether a file is a Git LFS pointer; not, where it cannot be read."""
    try:
        if not path.is_file():  # a pipe would be waited for
            return False
        with path.open("rb") as stream:
            return stream.read(len(START)) == START
    except OSError:
        return False


def refuse_lfs_pointer(path: Path) -> None:
    """Refuse a file that is a Git LFS pointer.

    Raises
    ------
    NotFetched
        It is one.
    """
    if is_lfs_pointer(path):
        raise not_fetched(str(path))


def refuse_pointer_bytes(content: bytes, name: str) -> None:
    """Refuse the content of a file that is a Git LFS pointer; ``name`` is what errors call the file.

    Raises
    ------
    NotFetched
        It is one.
    """
    if content.startswith(START):
        raise not_fetched(name)


def not_fetched(name: str, others: int = 0) -> NotFetched:
    """The error for a file that is a Git LFS pointer, and for how many others with it."""
    more = f" (and {others} more)" if others else ""
    return NotFetched(
        f"{name}{more} {POINTER_WORDS}, not the file",
        "the file itself",
        "`git lfs pull` in the repository fetches it.",
        file=name,
    )


def fault_words(error: TactileDataError) -> str:
    """What an error found, as a clause of a finding; of a pointer with what fetches the file."""
    return f"{error.found}; run `git lfs pull`" if isinstance(error, NotFetched) else error.found


def without_remedy(error: Exception) -> str:
    """An error as text; of a pointer only what was found, where another finding says once what fetches the files."""
    return error.found if isinstance(error, NotFetched) else str(error)


def pointer_words(name: str, others: int = 0) -> str:
    """What `not_fetched` says as one clause, for findings and lists."""
    return fault_words(not_fetched(name, others))

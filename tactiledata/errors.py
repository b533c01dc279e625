"""The tree of errors that tactiledata raises, every one of them also a builtin exception.

::

    TactileDataError
    ├── UsageError (ValueError)            the call was wrong                      exit code 2
    │   ├── UnknownName (KeyError)         a name that no table holds; lists near ones
    │   └── MissingSplit (KeyError)        data was asked for without a split
    ├── SchemaError (ValueError)           a document does not fit its schema; carries the path inside it
    ├── BrokenLog (ValueError)             a recording that cannot be read at all
    │   └── NotFetched                     a Git LFS pointer stands in the place of the file
    ├── UnsafeContent (ValueError)         data that would execute, or a path that leaves its folder
    ├── MissingFile (FileNotFoundError)    a file that was named and is not there          exit code 2
    │   └── LostFile                       a file that other files name and that is gone   exit code 1
    ├── StoreError (ValueError)            a store that is damaged, foreign or of another version
    │   └── StoreBusy (BlockingIOError)    another process writes to the store
    ├── LeakError (ValueError)             data that would be on both sides of a split
    ├── CheckpointError (ValueError)       weights that are damaged, foreign, or of other data than these
    └── NotFinite (ArithmeticError)        NaN or infinity where learning needs numbers

A message has three parts: what was found, what was expected, what to do. The facts are kept as attributes, so that a
caller need not parse the text.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any


class TactileDataError(Exception):
    """An error with its facts.

    Parameters
    ----------
    found : str
        What was found, with value, unit, file and place.
    expected : str
        What was expected instead; may be empty.
    remedy : str
        What the reader can do now; may be empty.
    **facts
        The values behind the message, kept in ``facts``.
    """

    exit_code = 1

    def __init__(self, found: str, expected: str = "", remedy: str = "", **facts: Any) -> None:
        self.found = found
        self.expected = expected
        self.remedy = remedy
        self.facts = facts
        super().__init__(found)

    def __str__(self) -> str:
        parts = [self.found.rstrip(".")]
        if self.expected:
            parts.append(f"expected {self.expected}".rstrip("."))
        text = "; ".join(parts) + "."
        return f"{text} {self.remedy}" if self.remedy else text

    def __reduce__(self) -> tuple[Any, ...]:
        # keyword facts do not survive the default pickling, and errors travel between worker processes
        return (_rebuild, (type(self), self.found, self.expected, self.remedy, self.facts))


def _rebuild(
    kind: type[TactileDataError], found: str, expected: str, remedy: str, facts: dict[str, Any]
) -> TactileDataError:
    # of several builtin bases, only that of OSError may allocate an error that has it
    error: TactileDataError = (OSError if issubclass(kind, OSError) else Exception).__new__(kind)
    TactileDataError.__init__(error, found, expected, remedy, **facts)
    return error


class UsageError(TactileDataError, ValueError):
    """The call was wrong: an option, a name or a combination of them."""

    exit_code = 2


class UnknownName(UsageError, KeyError):
    """A name that a table does not hold; the message lists the nearest names."""

    def __init__(self, kind: str, name: str, known: Iterable[str], remedy: str = "") -> None:
        choices = sorted(known)
        near = difflib.get_close_matches(name, choices, n=3, cutoff=0.4)
        listed = ", ".join(choices) if choices else "none"
        hint = f"Did you mean {' or '.join(near)}?" if near else ""
        super().__init__(
            f"unknown {kind} {name!r}",
            f"one of: {listed}",
            " ".join(part for part in (hint, remedy) if part),
            kind=kind,
            name=name,
            known=choices,
            near=near,
        )


class MissingSplit(UsageError, KeyError):
    """Training data was asked for without saying which part of which split."""


class SchemaError(TactileDataError, ValueError):
    """A document that does not fit its schema; ``facts['path']`` is the place inside the document."""


class BrokenLog(TactileDataError, ValueError):
    """A recording from which nothing can be read, or (with ``strict``) not everything."""


class NotFetched(BrokenLog):
    """A file of which only the Git LFS pointer is there."""


class UnsafeContent(TactileDataError, ValueError):
    """Data that would run code when read, or a path that leaves its folder."""


class MissingFile(TactileDataError, FileNotFoundError):
    """A file or folder that was named and does not exist."""

    exit_code = 2


class LostFile(MissingFile):
    """A file that a store, a log or another document names and that is gone: damage, not a wrong call."""

    exit_code = 1


class StoreError(TactileDataError, ValueError):
    """A store that is damaged, not a store, or of a version that this code does not know."""


class StoreBusy(StoreError, BlockingIOError):
    """Another process holds the store's writing lock."""


class LeakError(TactileDataError, ValueError):
    """Data that would stand on both sides of a split."""


class CheckpointError(TactileDataError, ValueError):
    """Weights that are damaged, foreign, or were learned from other data or settings than those at hand."""


class NotFinite(TactileDataError, ArithmeticError):
    """NaN or infinity in what a network learns from, or in what comes out of it."""

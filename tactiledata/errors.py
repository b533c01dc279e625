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
    │   ├── NotAStore                      something else was named where a store belongs     exit code 2
    │   └── StoreBusy (BlockingIOError)    another process writes to the store
    ├── LeakError (ValueError)             data that would be on both sides of a split
    ├── CheckpointError (ValueError)       weights that are damaged, foreign, or of other data than these
    └── NotFinite (ArithmeticError)        NaN or infinity where learning needs numbers

A message has three parts: what was found, what was expected, what to do. The facts are kept as attributes, so that a
caller need not parse the text.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from typing import Any

MOST_LISTED, FEW_LISTED = 30, 12
"""Most names that a message lists in full, and how many it lists of more."""


class TactileDataError(Exception):
    """Base class of all errors of the toolkit: a message in three parts, and the facts behind it.

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
    """Raised where a call is wrong: an option, a name or a combination of them."""

    exit_code = 2


class UnknownName(UsageError, KeyError):
    """Raised for a name that a table does not hold; the message lists the nearest names.

    Parameters
    ----------
    kind : str
        What the table holds, in the singular, for example ``"format"``.
    name : str
        The name that was given.
    known : iterable of str
        All names of the table.
    remedy : str
        What the reader can do now, after the proposal of near names; may be empty.
    unless_near : str
        What the reader can do now where no name of the table is near; may be empty.
    """

    def __init__(self, kind: str, name: str, known: Iterable[str], remedy: str = "", unless_near: str = "") -> None:
        choices = sorted(set(known))
        near = near_names(name, choices)
        shown = choices if len(choices) <= MOST_LISTED else [*choices[:FEW_LISTED], f"… ({len(choices)} in all)"]
        hint = f"Did you mean {' or '.join(near)}?" if near else unless_near
        super().__init__(
            f"unknown {kind} {name!r}" if shown else f"unknown {kind} {name!r}: there is no {kind}",
            f"one of: {', '.join(shown)}" if shown else "",
            " ".join(part for part in (hint, remedy) if part),
            kind=kind,
            name=name,
            known=choices,
            near=near,
        )


def near_names(name: str, known: Iterable[str]) -> list[str]:
    """Return the names that one resembles: at most three, none much less alike than the first.

    Names that differ in digits alone are no misspellings of one another, but other numbers: ``t00042`` is not
    ``t00027``. The folder before the last slash is left out of this comparison.

    Parameters
    ----------
    name : str
        The name that was given.
    known : iterable of str
        Names that it may be meant to be.
    """
    choices = [choice for choice in known if not _is_another_number(name, choice)]
    near = difflib.get_close_matches(name, choices, n=3, cutoff=0.4)
    alike = [difflib.SequenceMatcher(None, choice, name).ratio() for choice in near]
    return [choice for choice, ratio in zip(near, alike, strict=True) if ratio > alike[0] - 0.2]


def _is_another_number(name: str, other: str) -> bool:
    """Return whether the last parts of two names have digits and differ in nothing else."""
    last, other_last = (each.rpartition("/")[2] for each in (name, other))
    shape, other_shape = (re.sub(r"\d", "0", each) for each in (last, other_last))
    return last != other_last and shape == other_shape


class MissingSplit(UsageError, KeyError):
    """Raised where training data is requested without a split and its part."""


class SchemaError(TactileDataError, ValueError):
    """Raised for a document that does not fit its schema; ``facts['path']`` is the place inside the document."""


class BrokenLog(TactileDataError, ValueError):
    """Raised for a recording from which nothing can be read, or (with ``strict``) not everything."""


class NotFetched(BrokenLog):
    """Raised for a file of which only the Git LFS pointer is there."""


class UnsafeContent(TactileDataError, ValueError):
    """Raised for data that would run code when read, and for a path that leaves its folder."""


class MissingFile(TactileDataError, FileNotFoundError):
    """Raised for a file or folder that the caller names and that does not exist."""

    exit_code = 2


class LostFile(MissingFile):
    """Raised for a file that a store, a log or another document names and that is gone: damage, not a wrong call."""

    exit_code = 1


class StoreError(TactileDataError, ValueError):
    """Raised for a store that is damaged, for a path that is no store, and for a store of an unknown version."""


class NotAStore(StoreError):
    """Raised for a file or folder that the caller names in the place of a store: a wrong call, not damage."""

    exit_code = 2


class StoreBusy(StoreError, BlockingIOError):
    """Raised where another process holds the store's writing lock."""


class LeakError(TactileDataError, ValueError):
    """Raised for data that would stand on both sides of a split."""


class CheckpointError(TactileDataError, ValueError):
    """Raised for weights that are damaged, foreign, or learned from other data or settings than those at hand."""


class NotFinite(TactileDataError, ArithmeticError):
    """Raised for NaN or infinity in what a network learns from, or in what it gives."""

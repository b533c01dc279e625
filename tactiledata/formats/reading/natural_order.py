"""Names in the order in which people count: ``frame2`` before ``frame10``."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

_DIGITS = re.compile(r"([0-9]+)")


def natural_key(text: str) -> tuple[tuple[tuple[int, int, str], ...], str]:
    """A sorting key in which runs of ASCII digits count as numbers.

    Equal numbers written differently (``1``, ``01``) fall back to plain order, so that the order is total.

    Examples
    --------
    >>> sorted(["10.png", "9.png", "1.png"], key=natural_key)
    ['1.png', '9.png', '10.png']
    """
    parts = _DIGITS.split(text)
    return tuple((0, int(part), "") if index % 2 else (1, 0, part) for index, part in enumerate(parts)), text


def natural_sorted(names: Iterable[str]) -> list[str]:
    """Names in natural order."""
    return sorted(names, key=natural_key)


def natural_paths(paths: Iterable[Path]) -> list[Path]:
    """Paths in the natural order of their whole text."""
    return sorted(paths, key=lambda path: natural_key(path.as_posix()))


def last_number(text: str) -> int | None:
    """The last run of ASCII digits in a name, as a number; ``None`` where there is none.

    Examples
    --------
    >>> last_number("frame_0000012.jpg")
    12
    """
    found = _DIGITS.findall(text)
    return int(found[-1]) if found else None

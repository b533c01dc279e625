"""Numbers of things in words, and messages that say the same of several things."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

QUOTED = re.compile(r"(?<!\w)'([^']*)'(?!\w)")
"""A name in quotation marks; an apostrophe inside a word is none."""

PREFIX = re.compile(r"\A[^\s:]+: ")
"""What stands before the first colon of a message: the file, the stream or the thing that it is about."""


LINEAR_IS_LOW = "at 1 mm depth its forces are 5 to 15 % low, and up to 28 % along a shear of a small contact"
"""How far small strain is off, in words: docs/results.md, "The gel: linear against finite strain"."""


def counted(number: int, noun: str) -> str:
    """A number and its noun, in the plural where there is not one.

    Examples
    --------
    >>> counted(1, "recording"), counted(2, "recording"), counted(0, "trajectory")
    ('1 recording', '2 recordings', '0 trajectories')
    """
    if number == 1:
        return f"{number} {noun}"
    return f"{number} {noun[:-1]}ies" if noun.endswith("y") else f"{number} {noun}s"


def left_out_words(number: int, reason: str) -> str:
    """Say that a number of trajectories are left out, and why.

    Examples
    --------
    >>> left_out_words(2, "no contact wrench in the gel frame")
    '2 trajectories left out: no contact wrench in the gel frame'
    """
    return f"{counted(number, 'trajectory')} left out: {reason}"


def all_left_out(left_out: Mapping[str, int]) -> str:
    """Say of every reason how many trajectories are left out, by reason; empty where none is.

    Examples
    --------
    >>> all_left_out({"no pose": 1, "flagged as bad": 2})
    '2 trajectories left out: flagged as bad; 1 trajectory left out: no pose'
    """
    return "; ".join(left_out_words(number, reason) for reason, number in sorted(left_out.items()))


def agreeing(number: int, one: str, several: str) -> str:
    """The form of a word that goes with a number of things.

    Parameters
    ----------
    number : int
        How many things there are.
    one, several : str
        The word for one thing, and for none or several.

    Examples
    --------
    >>> [f"{counted(number, 'gap')} {agreeing(number, 'lies', 'lie')} inside" for number in (1, 2)]
    ['1 gap lies inside', '2 gaps lie inside']
    """
    return one if number == 1 else several


def listed(names: Sequence[str], most: int) -> str:
    """The first names, with commas between them and a mark where there are more.

    Parameters
    ----------
    names : sequence of str
        Names in their order.
    most : int
        How many are listed.

    Examples
    --------
    >>> listed(["t1", "t2", "t3"], 2)
    't1, t2 …'
    """
    return ", ".join(names[:most]) + (" …" if len(names) > most else "")


def bare_wording(message: str, names: Iterable[str] = ()) -> str:
    """A message without what differs from one recording to the next: numbers, names in quotes, and given names.

    Parameters
    ----------
    message : str
        A sentence with values.
    names : iterable of str
        Names without spaces that may stand in it, of recordings for example.

    Examples
    --------
    >>> bare_wording("run1: wrench has 3 gaps (12.5 s)") == bare_wording("run2: wrench has 14 gaps (0.3 s)")
    True
    >>> bare_wording("sensor 'left' has no serial: left") == bare_wording("sensor 'right' has no serial: right")
    True
    >>> bare_wording("wrench has 3 gaps") == bare_wording("wrench stands still for 3 s")
    False
    """
    known = {*names, *QUOTED.findall(message)}
    bare = []
    for word in QUOTED.sub("…", PREFIX.sub("… ", message, count=1)).split():
        core = word.strip('()[],.;:`"')
        differs = core in known or core == "…" or any(letter.isdigit() for letter in core)
        if not differs:
            bare.append(word)
        elif bare[-1:] != ["…"]:
            bare.append("…")
    return " ".join(bare)

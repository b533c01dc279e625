"""Numbers of things in words."""

from __future__ import annotations

from collections.abc import Sequence


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

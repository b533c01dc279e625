"""Plans by name: ``wedge-2`` has 36 touches, ``wedge-2x14`` the first 14 of them, ``mounts-0`` 25 touches.

``coarse-0`` has ten touches on a coarse pad of small strain, and three effects are tried: it shows that a proof runs,
and nothing else.
"""

from __future__ import annotations

import re

from tactiledata.errors import UsageError
from tactiledata.prove.worlds.plan import WorldPlan
from tactiledata.prove.worlds.wedges import COUNT, WedgePlan

FEWEST, MOST = 8, 200
"""Number of touches that a plan may have: a diagnosis needs eight."""
_NAME = re.compile(r"(wedge|mounts|coarse)-(\d{1,6})(?:x(\d{1,3}))?")


def named_plan(name: str) -> WorldPlan:
    """Return the plan of a name.

    Parameters
    ----------
    name : str
        The kind of plan, its number, and perhaps how many touches it has.

    Raises
    ------
    UsageError
        The name is none, or the number of touches is too small or too large.

    Examples
    --------
    >>> len(named_plan("wedge-2x14").touches)
    14
    """
    found = _NAME.fullmatch(name)
    if found is None:
        raise UsageError(
            f"a plan called {name!r}",
            "wedge-N or mounts-N, with xM for M touches, or coarse-N",
            "For example wedge-2x14: the first 14 touches of plan 2.",
        )
    kind, number, count = found[1], int(found[2]), found[3]
    if kind == "coarse" and count is None:
        return WorldPlan(number, is_quick=True)
    touches = int(count) if count else (COUNT if kind == "wedge" else 25)
    if not FEWEST <= touches <= MOST or kind == "coarse" or (kind == "mounts" and touches % 5):
        raise UsageError(
            f"a plan of {touches} touches ({name!r})",
            f"{FEWEST} to {MOST} touches for wedge-N, a multiple of 5 for mounts-N, and no number for coarse-N",
            "Name another number of touches.",
        )
    return WedgePlan(number, count=touches) if kind == "wedge" else WorldPlan(number, mounts=touches // 5)

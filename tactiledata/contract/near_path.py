"""What to say of a path at which nothing is: a link that leads nowhere, or a neighbour with nearly the same name."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from pathlib import Path

from tactiledata.errors import near_names

MOST_LOOKED_AT = 10_000
"""Most entries of a folder that are compared with a name."""
ALIKE = 0.7
"""Least likeness of two names without their endings: 1 where they are the same."""


def near_path(path: Path, endings: Sequence[str] = ("",)) -> str:
    """Return the question whether a neighbour of a path was meant, such as "Did you mean ds.zarr?"; empty without one.

    Of a link that leads nowhere it returns where it leads to instead.

    Parameters
    ----------
    path : Path
        A path at which nothing is.
    endings : sequence of str
        What the name of a neighbour may end in; anything by default.
    """
    try:
        if dead := dead_link(path):
            return f"{dead[0].upper()}{dead[1:]}."
        names = [entry.name for entry, _ in zip(path.parent.iterdir(), range(MOST_LOOKED_AT), strict=False)]
    except (OSError, ValueError):
        return ""
    # a name that leads nowhere stands in its folder, too
    others = [name for name in sorted(names) if name.endswith(tuple(endings)) and name != path.name]
    stems = {path.stem, *near_names(path.stem, {Path(name).stem for name in others})}
    alike = [name for name in others if Path(name).stem in stems and _likeness(name, path.name) >= ALIKE]
    near = near_names(path.name, alike)
    return f"Did you mean {' or '.join(str(path.with_name(name)) for name in near)}?" if near else ""


def dead_link(path: Path) -> str:
    """Return where a link that leads nowhere leads to, in words; empty of anything else.

    Parameters
    ----------
    path : Path
        A path in a folder that can be read, or one of which nothing is said.
    """
    try:
        return (
            f"it is a link to {path.readlink()}, which is not there" if path.is_symlink() and not path.exists() else ""
        )
    except OSError:
        return ""


def _likeness(name: str, other: str) -> float:
    """Return how alike two names of files are without their endings, 0 to 1."""
    return difflib.SequenceMatcher(None, Path(name).stem, Path(other).stem).ratio()

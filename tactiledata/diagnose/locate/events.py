"""Moments at which something begins or ends, found in the labels of the frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Indices
from tactiledata.diagnose.residuals.residuals import Residuals

KNOWN = {
    ("phase", "free air", "approach"): "approach",
    ("phase", "free air", None): "contact onset",
    ("phase", "approach", None): "contact onset",
    ("phase", None, "dwell"): "dwell start",
    ("phase", "dwell", "shear"): "shear start",
    ("contact", "stick", "slip"): "slip onset",
    ("contact", "slip", "stick"): "end of slip",
    ("phase", None, "reverse"): "shear reversal",
    ("phase", None, "leave"): "reversal",
    ("phase", None, "free air"): "separation",
}
"""Label, value before, value after (``None``: any) -> what people call it."""
FEWEST_TRAJECTORIES = 8


@dataclass(frozen=True)
class Events:
    """Moments of one kind.

    Parameters
    ----------
    name : str
    rows : (m,)
        First frame after each, ascending.
    """

    name: str
    rows: Indices


def stretch(residuals: Residuals) -> Indices:
    """Number of the stretch of each frame (n,): frames of one trajectory in which every label keeps its value."""
    turns = np.concatenate([[0], np.diff(residuals.trajectory)]) != 0
    for texts in residuals.labels.values():
        turns[1:] |= texts[1:] != texts[:-1]
    return np.cumsum(turns).astype(np.int64)


def find_events(residuals: Residuals) -> tuple[Events, ...]:
    """Changes of each label inside trajectories, those that fewer than eight trajectories show left out."""
    found: dict[str, list[Indices]] = {}
    is_inside = np.diff(residuals.trajectory) == 0
    for label, texts in residuals.labels.items():
        rows = np.flatnonzero((texts[1:] != texts[:-1]) & is_inside) + 1
        for before, after in sorted({(str(texts[row - 1]), str(texts[row])) for row in rows}):
            name = _name(label, before, after)
            here = rows[(texts[rows - 1] == before) & (texts[rows] == after)]
            found.setdefault(name, []).append(here)
    events = [Events(name, np.unique(np.concatenate(parts))) for name, parts in found.items()]
    return tuple(one for one in events if len(np.unique(residuals.trajectory[one.rows])) >= FEWEST_TRAJECTORIES)


def _name(label: str, before: str, after: str) -> str:
    for (known, start, end), name in KNOWN.items():
        if known == label and start in (None, before) and end in (None, after):
            return name
    return f"{label} turns from {before} to {after}"

"""Events: frames at which a label changes inside a trajectory, such as contact onset or slip onset."""

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
"""Names of events: (label, text before, text after) -> name, where ``None`` stands for any text."""
FEWEST_TRAJECTORIES = 8
"""Fewest trajectories that must show an event for it to be analysed."""


@dataclass(frozen=True)
class Events:
    """All m events of one kind.

    Parameters
    ----------
    name : str
        Name of the kind, such as ``"slip onset"``.
    rows : (m,)
        First frame after each event, ascending.
    """

    name: str
    rows: Indices


def stretch_numbers(residuals: Residuals) -> Indices:
    """Return the number (n,) of each frame's stretch: successive frames of one trajectory in which no label changes."""
    begins = np.concatenate([[0], np.diff(residuals.trajectory)]) != 0
    for texts in residuals.labels.values():
        begins[1:] |= texts[1:] != texts[:-1]
    return np.cumsum(begins).astype(np.int64)


def find_events(residuals: Residuals) -> tuple[Events, ...]:
    """Return all kinds of events that at least `FEWEST_TRAJECTORIES` trajectories show."""
    rows_of: dict[str, list[Indices]] = {}
    is_inside = np.diff(residuals.trajectory) == 0
    for label, texts in residuals.labels.items():
        rows = np.flatnonzero((texts[1:] != texts[:-1]) & is_inside) + 1
        for before, after in sorted({(str(texts[row - 1]), str(texts[row])) for row in rows}):
            name = _name(label, before, after)
            here = rows[(texts[rows - 1] == before) & (texts[rows] == after)]
            rows_of.setdefault(name, []).append(here)
    events = [Events(name, np.unique(np.concatenate(parts))) for name, parts in rows_of.items()]
    return tuple(event for event in events if len(np.unique(residuals.trajectory[event.rows])) >= FEWEST_TRAJECTORIES)


def _name(label: str, before: str, after: str) -> str:
    """Return the name of the event at which a label changes from one text to another."""
    for (known_label, start, end), name in KNOWN.items():
        if known_label == label and start in (None, before) and end in (None, after):
            return name
    return f"{label} turns from {before} to {after}"

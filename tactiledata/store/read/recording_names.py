"""Names that tell the recordings of a store apart: their keys, numbered where several have one key."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tactiledata.contract.wording import counted, listed
from tactiledata.errors import UsageError

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

SHOWN = 6
"""Recordings that an error names."""


def recording_names(store: Store) -> list[str]:
    """The name of each recording of a store, no two alike."""
    return told_apart(store.sources(["key"])["key"].to_pylist())


def told_apart(keys: Sequence[str]) -> list[str]:
    """Names for recordings in their order: the key, with a number behind it where others have the same.

    Examples
    --------
    >>> told_apart(["a.mcap", "run.mcap", "run.mcap"])
    ['a.mcap', 'run.mcap~1', 'run.mcap~2']
    """
    times = Counter(keys)
    taken = {key for key, count in times.items() if count == 1}
    names = []
    for key in keys:
        name, number = key, 0
        while times[key] > 1 and (number == 0 or name in taken):
            number += 1
            name = f"{key}~{number}"
        taken.add(name)
        names.append(name)
    return names


def named_recording(store: Store, name: str) -> int | None:
    """Row of the recording that is named, by its name or its key; ``None`` where there is none.

    Raises
    ------
    UsageError
        Several recordings have the key.
    """
    names = recording_names(store)
    if name in names:
        return names.index(name)
    sources = store.sources(["key", "sha256", "trajectories"]).to_pylist()
    rows = [row for row, source in enumerate(sources) if source["key"] == name]
    if len(rows) > 1:
        counts = {row: counted(sources[row]["trajectories"], "trajectory") for row in rows}
        shown = [f"{names[row]} (SHA-256 {sources[row]['sha256'][:12]}…, {counts[row]})" for row in rows]
        raise UsageError(
            f"{len(rows)} recordings are called {name!r}",
            f"one of these names: {listed(shown, SHOWN)}",
            "Type the name that stands before the brackets.",
        )
    return rows[0] if rows else None

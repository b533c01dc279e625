"""Which trajectories a person means by a name: a uid, a name, a recording and a name, or a whole recording."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tactiledata.contract.wording import counted, listed
from tactiledata.errors import UnknownName, UsageError
from tactiledata.store.read.recording_names import named_recording, recording_names

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

SHOWN = 6
"""Trajectories that an error names."""


def full_names(store: Store) -> list[str]:
    """The full name of each trajectory of a store: the name of its recording, a slash, and its own name."""
    return _full(store, recording_names(store))


def _full(store: Store, recordings: Sequence[str]) -> list[str]:
    rows = store.trajectories(["trajectory", "source"]).to_pylist()
    return [f"{recordings[row['source']]}/{row['trajectory']}" for row in rows]


def _told_apart(store: Store, rows: Sequence[int], typed: Sequence[str]) -> list[str]:
    """Names to type for rows of the table of trajectories, each with what tells the trajectory from the others."""
    sources = store.sources(["key", "sha256"]).to_pylist()
    facts = store.trajectories(["source", "sensor", "start_ns", "frame_start", "frame_stop"]).take(list(rows))
    told = []
    for name, row in zip(typed, facts.to_pylist(), strict=True):
        source = sources[row["source"]]
        told.append(
            f"{name} (of {source['key']}, SHA-256 {source['sha256'][:12]}…, sensor {row['sensor'] or 'not named'}, "
            f"{counted(row['frame_stop'] - row['frame_start'], 'image')}, begins at {row['start_ns'] / 1e9:.3f} s)"
        )
    return told


def named_trajectories(store: Store, names: Sequence[str], whole_recordings: bool = False) -> list[int]:
    """Rows of the trajectories that are named, each once, in the order of the names.

    Parameters
    ----------
    store : Store
    names : sequence of str
        Uids, names, or full names such as ``D20001.mcap/t00000``.
    whole_recordings : bool
        Whether a name that no trajectory has may be that of a recording, which means all its trajectories.

    Raises
    ------
    UnknownName
        No trajectory has this name.
    UsageError
        Several trajectories have it, or several recordings; a recording without a trajectory.
    """
    full = full_names(store)
    uids, own = (store.trajectories([column])[column].to_pylist() for column in ("uid", "trajectory"))
    rows_of: defaultdict[str, set[int]] = defaultdict(set)
    for kind in (uids, own, full, _full(store, store.sources(["key"])["key"].to_pylist())):
        for row, name in enumerate(kind):
            rows_of[name].add(row)
    rows: list[int] = []
    for name in names:
        if name not in rows_of:
            recording = named_recording(store, name) if whole_recordings else None
            if recording is None:
                known = [*recording_names(store), *full] if whole_recordings else full
                raise UnknownName("trajectory or recording" if whole_recordings else "trajectory", name, known)
            rows += _of_recording(store, recording, name)
            continue
        if len(rows_of[name]) > 1:
            meant = sorted(rows_of[name])
            typed = [full[row] if len(rows_of[full[row]]) == 1 else uids[row] for row in meant]
            raise UsageError(
                f"{len(meant)} trajectories are called {name!r}",
                f"one of these names: {listed(_told_apart(store, meant, typed), SHOWN)}",
                "Type the name that stands before the brackets.",
            )
        rows += rows_of[name]
    return list(dict.fromkeys(rows))


def _of_recording(store: Store, recording: int, name: str) -> list[int]:
    """Rows of the trajectories of a recording, which has some."""
    sources = store.trajectories(["source"])["source"].to_pylist()
    rows = [row for row, source in enumerate(sources) if source == recording]
    if not rows:
        raise UsageError(
            f"the recording {name} has no trajectory", "a recording with trajectories", "Name another one."
        )
    return rows

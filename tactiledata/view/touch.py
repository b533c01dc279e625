"""What a store knows of one trajectory that is shown, apart from its numbers and pictures."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.contract.description import LogDescription
from tactiledata.contract.simulated import Kind
from tactiledata.store.read.flags import Flag, flagged_trajectories
from tactiledata.store.read.reader import Store
from tactiledata.store.read.recording_names import recording_names
from tactiledata.store.read.simulated import trajectory_kinds


@dataclass(frozen=True)
class ViewedTouch:
    """A trajectory that is shown, with the recording that it is part of.

    Parameters
    ----------
    facts : dict
        Its row in the table of trajectories.
    recording : str
        Key of its recording.
    description : LogDescription
        What the recording says of the rig.
    signals : dict, name -> (name in the store, first row, row after the last)
        Where its samples lie, by the names that the recording gave.
    aligned : dict, name -> name in the store
        Values at the moments of frames, likewise.
    kind : "simulated", "real" or "not stated"
        What is stated of its recording.
    flag : Flag, optional
    log_ns : int
        Moment of the first frame or sample of its recording, ns, host clock.
    """

    facts: Mapping[str, Any]
    recording: str
    description: LogDescription
    signals: Mapping[str, tuple[str, int, int]]
    aligned: Mapping[str, str]
    kind: Kind
    flag: Flag | None
    log_ns: int

    @property
    def uid(self) -> str:
        """Identity of the trajectory."""
        return str(self.facts["uid"])

    @property
    def name(self) -> str:
        """Recording and name, as people read and type them."""
        return f"{self.recording}/{self.facts['trajectory']}"

    @property
    def start_ns(self) -> int:
        """Start, ns, host clock."""
        return int(self.facts["start_ns"])

    @property
    def seconds(self) -> float:
        """The duration of the trajectory, s."""
        return (int(self.facts["end_ns"]) - self.start_ns) / 1e9

    @property
    def title(self) -> str:
        """Its name for a narrow list: whether it is flagged, its name, indenter, whether anybody recorded it."""
        facts = self.facts
        words = ["FLAGGED" if self.flag else "", facts["trajectory"], facts["indenter"]]
        words += [
            "simulated" if self.kind == "simulated" else "",
            "synthetic" if facts["parent"] else "",
            self.recording,
        ]
        return " ".join(word for word in words if word)


class TouchReader:
    """Reads trajectories of a store; its tables are read once.

    Parameters
    ----------
    store : Store
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._table = store.trajectories()
        self._sources = store.sources(["key", "description", "contents"])
        self._names = recording_names(store)
        self._kinds = trajectory_kinds(store)
        self._flags = flagged_trajectories(store)
        frames = store.frames(["source", "t_ns"])
        self._frame_source, self._frame_t_ns = frames["source"].to_numpy(), frames["t_ns"].to_numpy()

    def touch(self, row: int) -> ViewedTouch:
        """The trajectory in one row of the table of trajectories."""
        facts = self._table.slice(row, 1).to_pylist()[0]
        source = self._sources.slice(facts["source"], 1).to_pylist()[0]
        contents = json.loads(source["contents"])
        spans = json.loads(facts["signal_rows"])
        signals = {
            contents["signals"][stored]["name"]: (stored, first, stop)
            for stored, (first, stop) in spans.items()
            if stop > first
        }
        return ViewedTouch(
            facts=facts,
            recording=self._names[facts["source"]],
            description=LogDescription(json.loads(source["description"])),
            signals=signals,
            aligned={entry["name"]: stored for stored, entry in contents["aligned"].items()},
            kind=self._kinds[row],
            flag=self._flags.get(facts["uid"]),
            log_ns=self._log_start(facts, contents),
        )

    def _log_start(self, facts: Mapping[str, Any], contents: Mapping[str, Any]) -> int:
        """Moment of the first frame or sample of a trajectory's recording, ns."""
        moments = [int(facts["start_ns"])]
        of_source = self._frame_t_ns[self._frame_source == facts["source"]]
        moments += [int(of_source.min())] if len(of_source) else []
        for stored, entry in contents["signals"].items():
            first, stop = entry["rows"]
            if stop > first:
                moments.append(int(self._store.signal(stored).t_ns(first, first + 1)[0]))
        return int(np.min(moments))

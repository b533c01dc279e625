"""A store whose trajectories are planned once, with what calibration, replay and diagnosis read of each of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.arrays import Times
from tactiledata.contract.description import LogDescription
from tactiledata.replay.plan import MakePad, ReplayPlan, plan_replay
from tactiledata.store.read.reader import Store


@dataclass(frozen=True)
class OpenedStore:
    """A store and the plan of its trajectories; tables and descriptions are parsed at the first use and kept.

    Parameters
    ----------
    store : Store
        The store that is read.
    plan : ReplayPlan
        All trajectories that have frames, with their pads and indenters.
    """

    store: Store
    plan: ReplayPlan

    @classmethod
    def planned(cls, store: Store, make_pad: MakePad, indenter_folder: Path | None = None) -> OpenedStore:
        """Plan all trajectories of a store.

        Parameters
        ----------
        store : Store
            The store that is read.
        make_pad : callable
            Makes the pad of a sensor's geometry.
        indenter_folder : Path, optional
            Folder of the meshes of indenters that recordings name by a path.
        """
        return cls(store, plan_replay(store, make_pad, indenter_folder))

    @cached_property
    def frame_t_ns(self) -> Times:
        """Moments (n,), ns, host clock, of all frames of the store."""
        return np.asarray(self.store.frames(["t_ns"])["t_ns"])

    @cached_property
    def trajectories(self) -> tuple[dict[str, Any], ...]:
        """All trajectories in the order of their table: ``uid``, ``source``, ``sensor``, ``peak_force``, and ``spans``.

        ``spans`` maps the name of a signal to the rows [start, stop) that the trajectory has in it.
        """
        table = self.store.trajectories(["uid", "source", "sensor", "peak_force", "signal_rows"]).to_pylist()
        return tuple({**row, "spans": json.loads(row.pop("signal_rows"))} for row in table)

    @cached_property
    def by_uid(self) -> dict[str, dict[str, Any]]:
        """Rows of ``trajectories`` by the uid of the trajectory."""
        return {row["uid"]: row for row in self.trajectories}

    @cached_property
    def descriptions(self) -> tuple[LogDescription, ...]:
        """Descriptions of the recordings, by the number of the source."""
        texts = self.store.sources(["description"])["description"].to_pylist()
        return tuple(LogDescription(json.loads(text)) for text in texts)

    def description_of(self, uid: str) -> LogDescription:
        """Description of the recording that holds a trajectory."""
        return self.descriptions[self.by_uid[uid]["source"]]

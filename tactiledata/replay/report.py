"""Report of a replay: numbers of frames and trajectories, and why some could not be replayed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from tactiledata.contract.simulated import SimulatedCount
from tactiledata.contract.wording import LINEAR_IS_LOW, counted, listed
from tactiledata.replay.effect_words import effects_in_words
from tactiledata.replay.plan import ReplayPlan
from tactiledata.replay.untouched import UntouchedTouch, untouched_lines, untouched_touches
from tactiledata.store.read.meshes import HAS_MESH
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_recordings

MOST_NAMED = 3
"""Trajectories that a line names of those that could not be replayed for one reason."""


@dataclass(frozen=True)
class ReplayReport:
    """Numbers of a store's mesh after a replay, and the trajectories that were refused.

    Parameters
    ----------
    store, mesh : str
        Location of the store and name of the mesh.
    fidelity : str
        Strain measure of the engine; empty where there is no mesh.
    effects : str
        Effects in words; empty where there are none.
    material : dict
        E (Pa), nu and mu.
    new_frames : int
        Rows that this replay attached.
    trajectories : int
        Trajectories of the store that have frames.
    status : dict, words -> number of frames
        Outcome of all frames.
    refused : dict, reason -> uids
        Trajectories that could not be replayed at all.
    with_mesh : int
        Frames with a mesh, in contact or in free air.
    simulated : SimulatedCount
        How many of the store's recordings are themselves simulated.
    names : dict, uid -> full name
        Of the trajectories that could not be replayed.
    untouched : tuple of UntouchedTouch
        Trajectories that were pressed, as the measured forces say, and that never touch the gel in this mesh.
    """

    store: str
    mesh: str
    fidelity: str
    effects: str
    material: Mapping[str, float]
    new_frames: int
    trajectories: int
    status: Mapping[str, int]
    refused: Mapping[str, tuple[str, ...]]
    with_mesh: int
    simulated: SimulatedCount
    names: Mapping[str, str]
    untouched: tuple[UntouchedTouch, ...] = ()

    @classmethod
    def of(cls, store: Store, name: str, plan: ReplayPlan, rows_before: int) -> ReplayReport:
        """Make the report of a replay that has ended.

        Parameters
        ----------
        store : Store
            The store with its mesh.
        name : str
            Name of the mesh.
        plan : ReplayPlan
            All trajectories, with the reasons of those refused.
        rows_before : int
            Rows of the mesh before this replay.
        """
        refused: dict[str, list[str]] = {}
        for touch in plan.touches:
            if touch.obstacle is not None:
                refused.setdefault(touch.reason, []).append(touch.uid)
        reasons = {reason: tuple(uids) for reason, uids in refused.items()}
        simulated = simulated_recordings(store)
        uids = store.trajectories(["uid"])["uid"].to_pylist()
        left = {uid for of_reason in refused.values() for uid in of_reason}
        names = {uid: full for uid, full in zip(uids, full_names(store), strict=True) if uid in left}
        if name not in store.mesh_names:
            return cls(str(store.location), name, "", "", {}, 0, len(plan.touches), {}, reasons, 0, simulated, names)
        mesh = store.mesh(name)
        counts = Counter({int(code): count for code, count in mesh.facts["counts"].items()})
        return cls(
            store=str(store.location),
            mesh=name,
            fidelity=mesh.settings["fidelity"],
            effects=effects_in_words(mesh.settings),
            material=mesh.settings["material"],
            new_frames=mesh.facts["rows"] - rows_before,
            trajectories=len(plan.touches),
            status={mesh.statuses[code]: count for code, count in sorted(counts.items())},
            refused=reasons,
            with_mesh=sum(counts[code] for code in HAS_MESH),
            simulated=simulated,
            names=names,
            untouched=untouched_touches(store, name, plan),
        )

    @property
    def fell_short(self) -> bool:
        """Whether a trajectory was refused, or no frame has a mesh."""
        return bool(self.refused) or not self.with_mesh

    def document(self) -> dict[str, Any]:
        """Return the report as JSON values."""
        document = {**asdict(self), "refused": {reason: list(uids) for reason, uids in self.refused.items()}}
        del document["simulated"]
        return {**document, "simulated_recordings": self.simulated.document()}

    def lines(self) -> list[str]:
        """Return the report as lines of text for a terminal."""
        label = f" (linear: a preview, {LINEAR_IS_LOW})" if self.fidelity == "linear" else ""
        lines = [
            f"mesh {self.mesh}{label}: {counted(self.with_mesh, 'frame')} with a mesh; {self.new_frames} frames are new"
        ]
        if not self.with_mesh:
            lines.append("  no page was written, and nothing is drawn: no frame has a mesh")
        if self.effects:
            lines.append(f"  with {self.effects}; the wrench is what the force sensor would read")
        lines += [f"  {counted(count, 'frame')}: {words}" for words, count in self.status.items()]
        for reason, uids in self.refused.items():
            named = listed([self.names[uid] for uid in uids], MOST_NAMED)
            lines.append(f"  {counted(len(uids), 'trajectory')} not replayed ({named}): {reason}")
        lines += untouched_lines(self.untouched, self.store)
        if self.simulated.sentence:
            lines.append(f"  {self.simulated.sentence}")
        return lines

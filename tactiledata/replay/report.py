"""What a replay did, in numbers and reasons."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from tactiledata.contract.simulated import SimulatedCount
from tactiledata.contract.wording import counted
from tactiledata.replay.effect_words import effects_in_words
from tactiledata.replay.plan import ReplayPlan
from tactiledata.store.read.meshes import HAS_MESH
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import simulated_recordings


@dataclass(frozen=True)
class ReplayReport:
    """What a store's mesh holds after a replay.

    Parameters
    ----------
    store, mesh : str
    fidelity : str
    effects : str
        That it was made with, in words; empty where there are none.
    material : dict
        E, nu and mu that it was made with.
    new_frames : int
        Rows that this replay attached.
    trajectories : int
        With frames.
    status : dict, words -> frames
    refused : dict, reason -> uids
        Trajectories that could not be replayed at all.
    with_mesh : int
        Frames, in contact or in free air.
    simulated : SimulatedCount
        Of the store's recordings.
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

    @classmethod
    def of(cls, store: Store, name: str, plan: ReplayPlan, before: int) -> ReplayReport:
        """The report of a store as it is, after it had ``before`` rows."""
        refused: dict[str, list[str]] = {}
        for touch in plan.touches:
            if touch.obstacle is not None:
                refused.setdefault(touch.reason, []).append(touch.uid)
        reasons = {reason: tuple(uids) for reason, uids in refused.items()}
        simulated = simulated_recordings(store)
        if name not in store.mesh_names:
            return cls(str(store.location), name, "", "", {}, 0, len(plan.touches), {}, reasons, 0, simulated)
        mesh = store.mesh(name)
        counts = Counter({int(code): count for code, count in mesh.facts["counts"].items()})
        return cls(
            store=str(store.location),
            mesh=name,
            fidelity=mesh.settings["fidelity"],
            effects=effects_in_words(mesh.settings),
            material=mesh.settings["material"],
            new_frames=mesh.facts["rows"] - before,
            trajectories=len(plan.touches),
            status={mesh.statuses[code]: count for code, count in sorted(counts.items())},
            refused=reasons,
            with_mesh=sum(counts[code] for code in HAS_MESH),
            simulated=simulated,
        )

    @property
    def fell_short(self) -> bool:
        """Whether a trajectory could not be replayed at all, or none is there."""
        return bool(self.refused) or not self.with_mesh

    def document(self) -> dict[str, Any]:
        """As JSON values."""
        document = {**asdict(self), "refused": {reason: list(uids) for reason, uids in self.refused.items()}}
        del document["simulated"]
        return {**document, "simulated_recordings": self.simulated.document()}

    def lines(self) -> list[str]:
        """For people."""
        label = " (linear: a preview, forces up to 20 % low at 1 mm)" if self.fidelity == "linear" else ""
        said = [
            f"mesh {self.mesh}{label}: {counted(self.with_mesh, 'frame')} with a mesh, {self.new_frames} of all new"
        ]
        if self.effects:
            said.append(f"  with {self.effects}; its wrench is what the force sensor would read")
        said += [f"  {counted(count, 'frame')}: {words}" for words, count in self.status.items()]
        for reason, uids in self.refused.items():
            listed = ", ".join(uids[:3]) + (" …" if uids[3:] else "")
            said.append(f"  {counted(len(uids), 'trajectory')} not replayed ({listed}): {reason}")
        if self.simulated.sentence:
            said.append(f"  {self.simulated.sentence}")
        return said

"""Which trajectories of a store can be replayed, with which indenter, gel and transforms, and why others cannot."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.description import LogDescription
from tactiledata.contract.provenance import json_bytes
from tactiledata.effects.touch.response import GelVariant
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.gel.contact.history import GelTouch
from tactiledata.gel.contact.relief import indenter_relief
from tactiledata.gel.mesh.cells import cell_quadrature
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.indenters import make_indenter
from tactiledata.indenters.base import Indenter
from tactiledata.replay.geometry import gel_geometry, implausible
from tactiledata.replay.poses import gel_from_indenter
from tactiledata.replay.status import STATUSES, ReplayStatus
from tactiledata.sensors.base import GelGeometry
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.reader import Store

MakePad = Callable[[str, GelGeometry], PadMesh]
"""A function that makes the pad mesh of a sensor model from its name and geometry."""

NOMINAL = GelVariant()
"""The gel without changes of its law."""
GAP_LIMIT_NS = 100_000_000
"""Largest gap, ns, between two samples across which a pose is interpolated."""


@dataclass(frozen=True)
class PlannedTouch:
    """A trajectory of a store with all that a replay of it needs, or the reason why it cannot be replayed.

    Parameters
    ----------
    uid, name, sensor, indenter : str
        Identity of the trajectory; its name, with that of its recording where others have the same; names of the sensor
        and the indenter.
    frames : (first, stop)
        Rows in the table of frames.
    obstacle : ReplayStatus, optional
        Why the trajectory cannot be replayed; ``None`` where it can.
    detail : str
        More of the obstacle, in words.
    poses : str
        The store's name for the aligned tcp poses.
    solid : Indenter, optional
        Shape of the indenter.
    tcp_from_gel, base_from_indenter : (4, 4), optional
        Places of the gel on the arm and of the indenter, metres.
    pad : int
        Number of the pad in the plan; -1 where it is unknown.
    """

    uid: str
    name: str
    sensor: str
    indenter: str
    frames: tuple[int, int]
    obstacle: ReplayStatus | None = None
    detail: str = ""
    poses: str = ""
    solid: Indenter | None = None
    tcp_from_gel: Array | None = None
    base_from_indenter: Array | None = None
    pad: int = -1

    @property
    def reason(self) -> str:
        """The obstacle with its detail, in words; empty where there is none."""
        words = "" if self.obstacle is None else STATUSES[self.obstacle]
        return f"{words}: {self.detail}" if self.detail else words

    def gel_touch(self, store: Store, offset: float, gap_limit_ns: int = GAP_LIMIT_NS) -> GelTouch:
        """Return poses and indenter for the gel engine, at the moments when the frames were captured.

        Poses are interpolated between samples at the native rate, linearly in position and by slerp in rotation.

        Parameters
        ----------
        store : Store
            The store of the plan.
        offset : m
            How much deeper the indenter is than recorded, along the gel frame's -z.
        gap_limit_ns : int
            Largest gap between two samples, ns; a pose across a longer one is missing (NaN).
        """
        assert self.solid is not None
        assert self.tcp_from_gel is not None
        assert self.base_from_indenter is not None
        values, gap_ns = store.aligned(self.poses, np.arange(*self.frames))
        values = np.where((gap_ns > gap_limit_ns)[:, None], np.nan, values)
        poses = gel_from_indenter(values, self.tcp_from_gel, self.base_from_indenter, offset)
        return GelTouch(self.solid, poses)


@dataclass(frozen=True)
class PlannedPad:
    """Pad of one geometry.

    Parameters
    ----------
    mesh : PadMesh
        Its mesh.
    sensor : str
        Sensor model, or "gel".
    geometry : GelGeometry
        Dimensions from which the mesh was made.
    law : GelVariant
        Changes of the material's law by effects.
    """

    mesh: PadMesh
    sensor: str
    geometry: GelGeometry
    law: GelVariant = NOMINAL

    @property
    def described(self) -> dict[str, Any]:
        """The pad's name, digest, sensor model, geometry and law as JSON values."""
        geometry = json.loads(json_bytes(vars(self.geometry)))
        law = {} if self.law == NOMINAL else {"law": json.loads(json_bytes(asdict(self.law)))}
        names = {"name": self.mesh.name, "sha256": self.mesh.digest, "sensor": self.sensor}
        return {**names, "geometry": geometry, **law}


@dataclass(frozen=True)
class ReplayPlan:
    """All trajectories of a store that have frames, in the order of their frames, and the pads that they press."""

    touches: tuple[PlannedTouch, ...]
    pads: tuple[PlannedPad, ...]


def plan_replay(store: Store, make_pad: MakePad, indenter_folder: Path | None = None) -> ReplayPlan:
    """Return the plan of a store's replay; trajectories that cannot be replayed carry the reason.

    Parameters
    ----------
    store : Store
        Its descriptions and its table of trajectories are read.
    make_pad : callable
        Makes the pad mesh of a sensor model from its name and geometry.
    indenter_folder : Path, optional
        Folder of the mesh files that recordings name by a relative path.
    """
    planner = _Planner(store, make_pad, indenter_folder)
    columns = ["uid", "trajectory", "source", "sensor", "indenter", "frame_start", "frame_stop"]
    table = store.trajectories(columns).to_pylist()
    times = Counter(row["trajectory"] for row in table)
    # a trajectory goes by its own name where that is enough, else by those of its recording and its own
    named = [
        {**row, "trajectory": row["trajectory"] if times[row["trajectory"]] == 1 else full}
        for row, full in zip(table, full_names(store), strict=True)
    ]
    rows = [row for row in named if row["frame_stop"] > row["frame_start"]]
    touches = tuple(planner.touch(row) for row in sorted(rows, key=lambda row: row["frame_start"]))
    return ReplayPlan(touches, tuple(planner.pads))


Usable = TypeVar("Usable", Indenter, int)


class _Obstacle(Exception):
    """Reason why a trajectory cannot be replayed; raised and caught within `_Planner`."""

    def __init__(self, status: ReplayStatus, detail: str = "") -> None:
        super().__init__(detail)
        self.status, self.detail = status, detail


class _Planner:
    """Reader of a store's descriptions, which makes each indenter and each pad once."""

    def __init__(self, store: Store, make_pad: MakePad, indenter_folder: Path | None) -> None:
        self._make_pad, self._folder = make_pad, indenter_folder
        self._sources = store.sources(["description", "contents"])
        self._sensors = store.sensors()
        self._read: tuple[int, LogDescription, Mapping[str, Any]] | None = None
        self._solids: dict[bytes, Indenter | _Obstacle] = {}
        self._numbers: dict[bytes, int | _Obstacle] = {}
        self.pads: list[PlannedPad] = []

    def touch(self, row: Mapping[str, Any]) -> PlannedTouch:
        """Plan the trajectory in one row of the table of trajectories."""
        frames = (row["frame_start"], row["frame_stop"])
        identity = (row["uid"], row["trajectory"], row["sensor"], row["indenter"], frames)
        try:
            return PlannedTouch(*identity, **self._needs(row))
        except _Obstacle as obstacle:
            return PlannedTouch(*identity, obstacle=obstacle.status, detail=obstacle.detail)

    def _needs(self, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields of a `PlannedTouch` that a replay needs, or raise the first obstacle."""
        description, contents = self._source(row["source"])
        poses = next((stored for stored, entry in contents["aligned"].items() if entry["name"] == "tcp"), None)
        if poses is None:
            raise _Obstacle(ReplayStatus.NO_POSES)
        tcp_from_gel = description.transform("tcp_from_gel")
        if tcp_from_gel is None:
            raise _Obstacle(ReplayStatus.GEL_PLACE_UNKNOWN)
        if row["indenter"] not in description.indenters:
            raise _Obstacle(ReplayStatus.INDENTER_UNKNOWN, repr(row["indenter"]) if row["indenter"] else "none named")
        place = description.base_from_indenter(row["indenter"])
        if place is None:
            raise _Obstacle(ReplayStatus.INDENTER_PLACE_UNKNOWN, repr(row["indenter"]))
        return {
            "poses": poses,
            "tcp_from_gel": tcp_from_gel.matrix,
            "base_from_indenter": place.matrix,
            "solid": self._solid(description.indenters[row["indenter"]], row["indenter"]),
            "pad": self._pad(description.sensors.get(row["sensor"]) or self._sensors.get(row["sensor"], {})),
        }

    def _source(self, number: int) -> tuple[LogDescription, Mapping[str, Any]]:
        """Description and contents of a recording; the last one read is kept."""
        if self._read is None or self._read[0] != number:
            row = self._sources.slice(number, 1).to_pylist()[0]
            self._read = number, LogDescription(json.loads(row["description"])), json.loads(row["contents"])
        return self._read[1:]

    def _solid(self, entry: Mapping[str, Any], name: str) -> Indenter:
        """Return an indenter's shape, or raise the obstacle where it cannot be made or pressed."""
        key = json_bytes({part: value for part, value in entry.items() if part != "base_from_indenter"})
        if key not in self._solids:
            try:
                if "mesh" in entry and self._folder is None:
                    raise UsageError(
                        f"indenter {name!r} is the mesh {entry['mesh']!r}",
                        "the folder of the mesh files that recordings name",
                        "Name it with --indenters FOLDER.",
                    )
                solid = make_indenter(entry, self._folder, f"indenter {name!r}")
                indenter_relief(solid)
                self._solids[key] = solid
            except TactileDataError as error:
                self._solids[key] = _Obstacle(ReplayStatus.INDENTER_UNUSABLE, str(error))
        return _unless_obstacle(self._solids[key])

    def _pad(self, facts: Mapping[str, Any]) -> int:
        """Return the number of a sensor's pad, or raise the obstacle where it cannot be made."""
        model = str(facts.get("model") or "gel")
        key = json_bytes({"model": model, "gel": facts.get("gel", {})})
        if key not in self._numbers:
            try:
                self._numbers[key] = self._new_pad(model, facts)
            except _Obstacle as obstacle:
                self._numbers[key] = obstacle
        return _unless_obstacle(self._numbers[key])

    def _new_pad(self, model: str, facts: Mapping[str, Any]) -> int:
        """Make a sensor's pad, and return its number or that of an equal one."""
        geometry = gel_geometry(facts)
        if geometry is None:
            raise _Obstacle(ReplayStatus.GEL_UNKNOWN, f"model {model!r}")
        if fault := implausible(geometry):
            raise _Obstacle(ReplayStatus.GEL_UNUSABLE, fault)
        try:
            mesh = self._make_pad(model, geometry)
            cell_quadrature(mesh)
        except TactileDataError as error:
            raise _Obstacle(ReplayStatus.GEL_UNUSABLE, str(error)) from error
        for number, pad in enumerate(self.pads):
            if pad.mesh.digest == mesh.digest:
                return number
        self.pads.append(PlannedPad(mesh, model, geometry))
        return len(self.pads) - 1


def _unless_obstacle(result: Usable | _Obstacle) -> Usable:
    """Return a result, or raise it where it is an obstacle."""
    if isinstance(result, _Obstacle):
        raise result
    return result

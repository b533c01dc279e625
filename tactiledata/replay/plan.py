"""What of a store can be replayed: each trajectory with its indenter, gel and transforms, or the reason why not."""

from __future__ import annotations

import json
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
from tactiledata.store.read.reader import Store

MakePad = Callable[[str, GelGeometry], PadMesh]
"""The pad of a sensor model of this name and geometry."""

NOMINAL = GelVariant()
GAP_LIMIT_NS = 100_000_000
"""A pose interpolated across a longer gap is none."""


@dataclass(frozen=True)
class PlannedTouch:
    """One trajectory.

    Parameters
    ----------
    uid, name, sensor, indenter : str
    frames : (first, stop)
        Rows in the table of frames.
    obstacle : ReplayStatus, optional
        Why it cannot be replayed.
    detail : str
        More of the obstacle, in words.
    poses : str
        The store's name for the aligned tcp poses.
    solid : Indenter, optional
    tcp_from_gel, base_from_indenter : (4, 4), optional
    pad : int
        Which of the plan's pads; -1 where not known.
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
        """The obstacle in words."""
        words = "" if self.obstacle is None else STATUSES[self.obstacle]
        return f"{words}: {self.detail}" if self.detail else words

    def gel_touch(self, store: Store, offset: float, gap_limit_ns: int = GAP_LIMIT_NS) -> GelTouch:
        """The touch for the gel engine, at the moments when the frames were captured.

        Poses lie between the two neighbouring samples of the native rate, linear in position and slerp in rotation.

        Parameters
        ----------
        offset : m, by how much the indenter is deeper than recorded
        gap_limit_ns : a pose between samples further apart is missing
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
    """The pad of one geometry: mesh, sensor model and geometry that it was made of, and what differs of its law."""

    mesh: PadMesh
    sensor: str
    geometry: GelGeometry
    law: GelVariant = NOMINAL

    @property
    def described(self) -> dict[str, Any]:
        """As JSON values."""
        geometry = json.loads(json_bytes(vars(self.geometry)))
        law = {} if self.law == NOMINAL else {"law": json.loads(json_bytes(asdict(self.law)))}
        named = {"name": self.mesh.name, "sha256": self.mesh.digest, "sensor": self.sensor}
        return {**named, "geometry": geometry, **law}


@dataclass(frozen=True)
class ReplayPlan:
    """All trajectories that have frames, in the order of their frames, and the pads that they press."""

    touches: tuple[PlannedTouch, ...]
    pads: tuple[PlannedPad, ...]


def plan_replay(store: Store, make_pad: MakePad, indenter_folder: Path | None = None) -> ReplayPlan:
    """What of a store can be replayed.

    Parameters
    ----------
    make_pad : callable
    indenter_folder : Path, optional
        Where the meshes of indenters lie that recordings name by a path.
    """
    planner = _Planner(store, make_pad, indenter_folder)
    columns = ["uid", "trajectory", "source", "sensor", "indenter", "frame_start", "frame_stop"]
    rows = [row for row in store.trajectories(columns).to_pylist() if row["frame_stop"] > row["frame_start"]]
    touches = tuple(planner.touch(row) for row in sorted(rows, key=lambda row: row["frame_start"]))
    return ReplayPlan(touches, tuple(planner.pads))


Found = TypeVar("Found", Indenter, int)


class _Obstacle(Exception):
    """A way out of `_Planner`, never seen outside."""

    def __init__(self, status: ReplayStatus, detail: str = "") -> None:
        super().__init__(detail)
        self.status, self.detail = status, detail


class _Planner:
    def __init__(self, store: Store, make_pad: MakePad, indenter_folder: Path | None) -> None:
        self._make_pad, self._folder = make_pad, indenter_folder
        self._sources = store.sources(["description", "contents"])
        self._sensors = store.sensors()
        self._read: tuple[int, LogDescription, Mapping[str, Any]] | None = None
        self._solids: dict[bytes, Indenter | _Obstacle] = {}
        self._numbers: dict[bytes, int | _Obstacle] = {}
        self.pads: list[PlannedPad] = []

    def touch(self, row: Mapping[str, Any]) -> PlannedTouch:
        """One row of the table of trajectories."""
        frames = (row["frame_start"], row["frame_stop"])
        named = (row["uid"], row["trajectory"], row["sensor"], row["indenter"], frames)
        try:
            return PlannedTouch(*named, **self._needs(row))
        except _Obstacle as obstacle:
            return PlannedTouch(*named, obstacle=obstacle.status, detail=obstacle.detail)

    def _needs(self, row: Mapping[str, Any]) -> dict[str, Any]:
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
        if self._read is None or self._read[0] != number:
            row = self._sources.slice(number, 1).to_pylist()[0]
            self._read = number, LogDescription(json.loads(row["description"])), json.loads(row["contents"])
        return self._read[1:]

    def _solid(self, entry: Mapping[str, Any], name: str) -> Indenter:
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
        model = str(facts.get("model") or "gel")
        key = json_bytes({"model": model, "gel": facts.get("gel", {})})
        if key not in self._numbers:
            try:
                self._numbers[key] = self._new_pad(model, facts)
            except _Obstacle as obstacle:
                self._numbers[key] = obstacle
        return _unless_obstacle(self._numbers[key])

    def _new_pad(self, model: str, facts: Mapping[str, Any]) -> int:
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


def _unless_obstacle(found: Found | _Obstacle) -> Found:
    if isinstance(found, _Obstacle):
        raise found
    return found

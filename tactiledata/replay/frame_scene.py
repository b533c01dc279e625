"""The scene of one frame of a store: arm, gel and indenter where the recording says that they were."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from tactiledata.arrays import Array
from tactiledata.contract.description import LogDescription
from tactiledata.errors import TactileDataError, UnknownName, UsageError
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.gel.scene.arm import ToolCheck, base_from_flange, fit_tool
from tactiledata.gel.scene.scene import GelScene, SceneParts
from tactiledata.indenters import make_indenter
from tactiledata.replay.geometry import gel_geometry
from tactiledata.store.read.reader import Store
from tactiledata.transforms import Transform, pose_matrices

POSITION_AGREES, ROTATION_AGREES = 1e-3, 5e-3
"""m and rad: a rigid tool leaves less than this between joints and poses of one moment."""


@dataclass(frozen=True)
class FrameScene:
    """A frame's scene, and what was found on the way.

    Parameters
    ----------
    scene : GelScene
    pose_from : "tcp" or "joints"
        Where the pose of the sensor comes from.
    check : ToolCheck, optional
        How joints and poses agree along the trajectory, where both were recorded.
    """

    scene: GelScene
    pose_from: str
    check: ToolCheck | None

    @property
    def agrees(self) -> bool:
        """Whether joints and poses tell the same, as far as both were recorded."""
        check = self.check
        return check is None or (check.position_off < POSITION_AGREES and check.rotation_off < ROTATION_AGREES)

    def facts(self) -> dict[str, Any]:
        """As JSON values: where the indenter stands in the gel frame, the distance, how joints and poses agree."""
        scene, check = self.scene, self.check
        gel_from_indenter = np.linalg.inv(scene.pose("gel")) @ scene.pose("indenter")
        return {
            "pose_from": self.pose_from,
            "indenter_tip_in_gel_m": gel_from_indenter[:3, 3].tolist(),
            "distance_m": scene.distance()[0],
            "joints_against_poses": None
            if check is None
            else {
                "samples": check.samples,
                "position_rms_m": check.position_off,
                "rotation_rms_rad": check.rotation_off,
                "flange_from_tcp_m": check.flange_from_tcp[:3, 3].tolist(),
                "agree": self.agrees,
            },
        }


def frame_scene(
    store: Store,
    trajectory: str,
    frame: int,
    indenter_folder: Path | None = None,
    flange_from_tcp: Transform | None = None,
) -> FrameScene:
    """The scene of a frame.

    Parameters
    ----------
    trajectory : str
        Name or uid.
    frame : int
        Counted from 0 within the trajectory.
    indenter_folder : Path, optional
        Where the meshes of indenters lie that recordings name by a path.
    flange_from_tcp : Transform, optional
        The tool, for stores without poses; left out: what joints and poses say together, else none.

    Raises
    ------
    UnknownName, UsageError
        No such trajectory or frame.
    TactileDataError
        What the scene needs and the recording does not tell: a pose, the gel's or the indenter's place.
    """
    row = _trajectory(store, trajectory)
    frames = np.arange(row["frame_start"], row["frame_stop"])
    if not 0 <= frame < len(frames):
        raise UsageError(f"frame {frame} of trajectory {row['trajectory']}", f"0 to {len(frames) - 1}", "")
    source = store.sources(["description", "contents"]).slice(row["source"], 1).to_pylist()[0]
    description = LogDescription(json.loads(source["description"]))
    stored = {entry["name"]: name for name, entry in json.loads(source["contents"])["aligned"].items()}
    poses = np.full((len(frames), 4, 4), np.nan)
    joints = np.full((len(frames), 6), np.nan)
    if "tcp" in stored:
        rows = store.aligned(stored["tcp"], frames)[0]
        known = np.isfinite(rows).all(axis=1)
        poses[known] = pose_matrices(rows[known])
    if "joints" in stored:
        joints = store.aligned(stored["joints"], frames)[0]
    check = fit_tool(joints, poses)
    tool = _tool(flange_from_tcp, check)
    at, angles, pose_from = poses[frame], joints[frame], "tcp"
    if np.isnan(at).any():
        if np.isnan(angles).any():
            raise TactileDataError(
                f"at frame {frame} of {row['trajectory']} neither pose nor joints are known",
                "a pose stream 'tcp', or 'joints'",
                "Take another frame, or map the stream (docs/formats.md).",
            )
        at, pose_from = base_from_flange(angles)[0] @ tool, "joints"
    indenter, place = _indenter(description, row["indenter"], indenter_folder)
    tcp_from_gel = description.transform("tcp_from_gel")
    if tcp_from_gel is None:
        raise _not_told("robot: tcp_from_gel")
    is_arm_known = bool(np.isfinite(angles).all())
    parts = SceneParts(
        at,
        tcp_from_gel.matrix,
        _outer_body(_pad(description, store, row["sensor"])),
        indenter,
        place,
        angles if is_arm_known else None,
        # the arm's own noise must not move the sensor, whose pose is better known
        np.linalg.inv(base_from_flange(angles)[0]) @ at if is_arm_known else None,
    )
    return FrameScene(GelScene(parts), pose_from, check)


def _trajectory(store: Store, name: str) -> dict[str, Any]:
    columns = ["uid", "trajectory", "source", "sensor", "indenter", "frame_start", "frame_stop"]
    rows = store.trajectories(columns).to_pylist()
    found = [row for row in rows if name in (row["trajectory"], row["uid"])]
    if len(found) > 1:
        uids = ", ".join(row["uid"] for row in found)
        raise UsageError(f"{len(found)} trajectories are called {name!r}", f"one of their uids: {uids}", "Name a uid.")
    if not found:
        raise UnknownName("trajectory", name, [row["trajectory"] for row in rows])
    return found[0]


def _tool(stated: Transform | None, check: ToolCheck | None) -> Array:
    if stated is not None:
        return stated.matrix
    return np.eye(4) if check is None else check.flange_from_tcp


def _indenter(description: LogDescription, name: str, folder: Path | None) -> tuple[trimesh.Trimesh, Array]:
    if name not in description.indenters:
        raise _not_told(f"indenters: {name or 'of this trajectory'}")
    place = description.base_from_indenter(name)
    if place is None:
        raise _not_told(f"indenters: {name}: base_from_indenter")
    return make_indenter(description.indenters[name], folder, f"indenter {name!r}").mesh(), place.matrix


def _pad(description: LogDescription, store: Store, sensor: str) -> PadMesh:
    facts = description.sensors.get(sensor) or store.sensors().get(sensor, {})
    geometry = gel_geometry(facts)
    if geometry is None:
        raise _not_told(f"sensors: {sensor}: gel")
    return pad_mesh(str(facts.get("model", "gel")), geometry)


def _outer_body(mesh: PadMesh) -> trimesh.Trimesh:
    """The pad as a closed solid: its convex hull, which a dome on a flat base fills."""
    return trimesh.convex.convex_hull(mesh.vertices)


def _not_told(key: str) -> TactileDataError:
    return TactileDataError(
        f"the recording does not say {key}",
        f"{key} in its description",
        "Add it to log.yaml or the mapping and ingest with --replace.",
    )

"""MuJoCo scene of one frame of a store, with arm, gel and indenter in their recorded places."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from tactiledata.arrays import Array
from tactiledata.contract.description import LogDescription
from tactiledata.errors import TactileDataError, UsageError
from tactiledata.gel.mesh.pad import PadMesh
from tactiledata.gel.mesh.structured_pad import pad_mesh
from tactiledata.gel.scene.arm import ToolCheck, base_from_flange, fit_tool
from tactiledata.gel.scene.scene import GelScene, SceneParts
from tactiledata.indenters import make_indenter
from tactiledata.replay.geometry import gel_geometry
from tactiledata.store.read.named_trajectories import named_trajectories
from tactiledata.store.read.reader import Store
from tactiledata.transforms import Transform, pose_matrices

POSITION_AGREES, ROTATION_AGREES = 1e-3, 5e-3
"""Largest root mean square errors, m and rad, at which joints and poses agree on a rigid tool."""


@dataclass(frozen=True)
class FrameScene:
    """Scene of a frame, the source of its pose, and a check of joints against poses.

    Parameters
    ----------
    scene : GelScene
        The scene.
    pose_from : "tcp" or "joints"
        Stream from which the pose of the sensor comes.
    check : ToolCheck, optional
        Agreement of joints and poses along the trajectory, where both were recorded.
    """

    scene: GelScene
    pose_from: str
    check: ToolCheck | None

    @property
    def agrees(self) -> bool:
        """Whether joints and poses agree, or only one of them was recorded."""
        check = self.check
        return check is None or (check.position_off < POSITION_AGREES and check.rotation_off < ROTATION_AGREES)

    def facts(self) -> dict[str, Any]:
        """Return place of the indenter (gel frame), distance, and agreement of joints and poses, as JSON values."""
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
    """Make the scene of a frame.

    Parameters
    ----------
    store : Store
        Its poses, joints and descriptions are read.
    trajectory : str
        Uid, name, or recording and name, such as ``D20001.mcap/t00000``.
    frame : int
        Counted from 0 within the trajectory.
    indenter_folder : Path, optional
        Folder of the mesh files that recordings name by a relative path.
    flange_from_tcp : Transform, optional
        The tool, for stores without poses. By default it is fitted to joints and poses, or the identity where one of
        them is missing.

    Raises
    ------
    UnknownName
        No trajectory has this name.
    UsageError
        The name is ambiguous, or the trajectory has no such frame.
    TactileDataError
        The recording lacks the pose, the gel's place or geometry, or the indenter's shape or place.
    """
    columns = ["trajectory", "source", "sensor", "indenter", "frame_start", "frame_stop"]
    row = store.trajectories(columns).slice(named_trajectories(store, [trajectory])[0], 1).to_pylist()[0]
    frames = np.arange(row["frame_start"], row["frame_stop"])
    if not 0 <= frame < len(frames):
        raise UsageError(f"frame {frame} of trajectory {row['trajectory']}", f"0 to {len(frames) - 1}", "")
    source = store.sources(["description", "contents"]).slice(row["source"], 1).to_pylist()[0]
    description = LogDescription(json.loads(source["description"]))
    stored = {entry["name"]: name for name, entry in json.loads(source["contents"])["aligned"].items()}
    # poses and joints of the whole trajectory, from which the tool is fitted
    poses = np.full((len(frames), 4, 4), np.nan)
    joints = np.full((len(frames), 6), np.nan)
    if "tcp" in stored:
        rows = store.aligned(stored["tcp"], frames)[0]
        is_known = np.isfinite(rows).all(axis=1)
        poses[is_known] = pose_matrices(rows[is_known])
    if "joints" in stored:
        joints = store.aligned(stored["joints"], frames)[0]
    check = fit_tool(joints, poses)
    tool = _tool(flange_from_tcp, check)
    # the pose of this frame; joints and the tool serve where it is missing
    base_from_tcp, angles, pose_from = poses[frame], joints[frame], "tcp"
    if np.isnan(base_from_tcp).any():
        if np.isnan(angles).any():
            raise TactileDataError(
                f"at frame {frame} of {row['trajectory']} neither pose nor joints are known",
                "a pose stream 'tcp', or 'joints'",
                "Take another frame, or map the stream (docs/formats.md).",
            )
        base_from_tcp, pose_from = base_from_flange(angles)[0] @ tool, "joints"
    # indenter, gel and arm in their places
    indenter, place = _indenter(description, row["indenter"], indenter_folder)
    tcp_from_gel = description.transform("tcp_from_gel")
    if tcp_from_gel is None:
        raise _missing("robot: tcp_from_gel")
    is_arm_known = bool(np.isfinite(angles).all())
    parts = SceneParts(
        base_from_tcp,
        tcp_from_gel.matrix,
        _outer_body(_pad(description, store, row["sensor"])),
        indenter,
        place,
        angles if is_arm_known else None,
        # the arm's own noise must not move the sensor, whose pose is better known
        np.linalg.inv(base_from_flange(angles)[0]) @ base_from_tcp if is_arm_known else None,
    )
    return FrameScene(GelScene(parts), pose_from, check)


def _tool(stated: Transform | None, check: ToolCheck | None) -> Array:
    """Return flange_from_tcp (4, 4): as stated, else as fitted, else the identity."""
    if stated is not None:
        return stated.matrix
    return np.eye(4) if check is None else check.flange_from_tcp


def _indenter(description: LogDescription, name: str, folder: Path | None) -> tuple[trimesh.Trimesh, Array]:
    """Shape of an indenter and base_from_indenter (4, 4); refuse one that the recording does not describe."""
    if name not in description.indenters:
        raise _missing(f"indenters: {name or 'of this trajectory'}")
    place = description.base_from_indenter(name)
    if place is None:
        raise _missing(f"indenters: {name}: base_from_indenter")
    return make_indenter(description.indenters[name], folder, f"indenter {name!r}").mesh(), place.matrix


def _pad(description: LogDescription, store: Store, sensor: str) -> PadMesh:
    """Low-resolution pad of a sensor; refuse a sensor without gel geometry."""
    facts = description.sensors.get(sensor) or store.sensors().get(sensor, {})
    geometry = gel_geometry(facts)
    if geometry is None:
        raise _missing(f"sensors: {sensor}: gel")
    return pad_mesh(str(facts.get("model", "gel")), geometry)


def _outer_body(mesh: PadMesh) -> trimesh.Trimesh:
    """Convex hull of a pad, a closed solid that a dome on a flat base fills."""
    return trimesh.convex.convex_hull(mesh.vertices)


def _missing(key: str) -> TactileDataError:
    """Error for a key that the recording's description lacks."""
    return TactileDataError(
        f"the recording does not say {key}",
        f"{key} in its description",
        "Add it to log.yaml or the mapping and ingest with --replace.",
    )

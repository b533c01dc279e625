"""The deformed gel of a trajectory in 3-D, where a replay attached one, and the indenter that presses it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Indices, Mask, PictureArray, SingleArray, Times
from tactiledata.contract.wording import counted
from tactiledata.errors import UnknownName
from tactiledata.replay.indenter_path import indenter_path
from tactiledata.store.read.meshes import StoredMesh
from tactiledata.store.read.reader import Store
from tactiledata.view.chosen import thinned
from tactiledata.view.options import ViewOptions
from tactiledata.view.rerun_package import load_rerun
from tactiledata.view.touch_log import TouchLog

SURFACE, PRESSED, INDENTER = "gel/surface", "gel/pressed", "gel/indenter"
"""Entities: the outer surface, its points under the indenter, and the indenter where it was recorded."""
BLOCK = 32
"""Frames in memory at once."""
PRESSED_COLOUR, PRESSED_RADIUS = (255, 120, 0), 1.2e-4
INDENTER_COLOUR = (170, 170, 180, 110)


def shown_mesh(store: Store, name: str | None) -> StoredMesh | None:
    """The mesh that is shown: the named one, else the most faithful of the store; ``None`` where it has none.

    Raises
    ------
    UnknownName
        The store has no mesh of that name.
    """
    names = store.mesh_names
    if name is not None:
        if name not in names:
            raise UnknownName("mesh", name, names, "`tactiledata replay` attaches meshes.")
        return store.mesh(name)
    meshes = [store.mesh(known) for known in names]
    return min(meshes, key=lambda mesh: mesh.settings["fidelity"] == "linear") if meshes else None


@dataclass(frozen=True)
class ShownGel:
    """What is shown of the gel in a trajectory.

    Parameters
    ----------
    missing : list of str
        What is not there, a sentence each.
    meshes : int
        Frames with a mesh.
    largest_move : float, m
        Largest displacement in them: that of the brightest colour.
    """

    missing: list[str]
    meshes: int = 0
    largest_move: float = 0.0


def put_gel(log: TouchLog, store: Store, mesh: StoredMesh | None, options: ViewOptions) -> ShownGel:
    """Put the deformed gel of a trajectory and the indenter; return what is shown of it.

    Parameters
    ----------
    log : TouchLog
    store : Store
    mesh : StoredMesh, optional
        ``None`` where the store was not replayed.
    options : ViewOptions
    """
    if mesh is None:
        return ShownGel(["No mesh and no simulated force: the store was not replayed (`tactiledata replay`)."])
    facts = log.touch.facts
    rows = np.arange(facts["frame_start"], facts["frame_stop"])
    rows = rows[thinned(len(rows), options.stride, options.pictures)]
    t_ns = store.frames(["t_ns"])["t_ns"].to_numpy()[rows]
    status = mesh.status(rows)
    has_mesh = mesh.has_mesh(rows)
    missing = _without(mesh, status[~has_mesh], len(rows))
    if not has_mesh.any():
        return ShownGel(missing)
    largest = _largest_move(mesh, rows[has_mesh])
    _put_surface(log, mesh, rows, t_ns, has_mesh, largest)
    missing += _put_indenter(log, store, rows, t_ns)
    return ShownGel(missing, int(has_mesh.sum()), largest)


def _without(mesh: StoredMesh, status: NDArray[np.int8], total: int) -> list[str]:
    """Say why frames have no mesh, a sentence for each reason."""
    said = []
    for code in np.unique(status).tolist():
        why = mesh.statuses.get(code, "the frame came after the replay; run `tactiledata replay` again")
        count = int((status == code).sum())
        share = "No mesh" if count == total else f"No mesh in {counted(count, 'frame')} of {total}"
        said.append(f"{share}: {why}.")
    return said


def _put_surface(log: TouchLog, mesh: StoredMesh, rows: Indices, t_ns: Times, has_mesh: Mask, largest: float) -> None:
    """Put the deformed outer surface and its pressed points; a frame without a mesh shows none."""
    rr = load_rerun()
    pad = mesh.pad()
    nodes, numbers = np.unique(pad.triangles, return_inverse=True)
    faces = numbers.reshape(-1, 3)
    place_of = np.full(pad.vertices.shape[1], -1, np.int64)
    place_of[pad.kept] = np.arange(len(pad.kept))
    kept, corners = place_of[nodes], place_of[pad.corners]
    log.put_static(SURFACE, rr.Mesh3D.from_fields(triangle_indices=faces.astype(np.uint32)))
    for first in range(0, len(rows), BLOCK):
        block = slice(first, first + BLOCK)
        moves, pressed = mesh.displacement(rows[block]), mesh.contact(rows[block])
        pads = mesh.pad_numbers(rows[block])
        for number, is_there in enumerate(has_mesh[block]):
            log.at(int(t_ns[first + number]))
            if not is_there:
                log.clear(SURFACE)
                log.clear(PRESSED)
                continue
            vertices, moved = pad.vertices[pads[number]], moves[number]
            colours = _colours(np.linalg.norm(moved[kept], axis=1), largest)
            positions = (vertices[nodes] + moved[kept]).astype(np.float32)
            normals = _normals(positions, faces)
            shape = {"vertex_positions": positions, "vertex_normals": normals, "vertex_colors": colours}
            log.put(SURFACE, rr.Mesh3D.from_fields(**shape))
            under = pressed[number]
            points = (vertices[pad.corners] + moved[corners])[under].astype(np.float32)
            log.put(PRESSED, rr.Points3D(points, colors=[PRESSED_COLOUR], radii=[PRESSED_RADIUS]))
        log.flush()


def _largest_move(mesh: StoredMesh, rows: Indices) -> float:
    """The largest displacement, m, of any kept node at frames with a mesh."""
    largest = 0.0
    for first in range(0, len(rows), BLOCK):
        moves = mesh.displacement(rows[first : first + BLOCK])
        largest = max(largest, float(np.linalg.norm(moves, axis=2).max(initial=0.0)))
    return largest


def _normals(positions: SingleArray, faces: Indices) -> SingleArray:
    """Normals (n, 3) at the vertices of a surface, by which light falls on it: means over its triangles, by area."""
    first, second, third = positions[faces].transpose(1, 0, 2)
    of_faces = np.cross(second - first, third - first)
    normals = np.zeros_like(positions)
    for corner in faces.T:
        np.add.at(normals, corner, of_faces)
    lengths = np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    return (normals / lengths).astype(np.float32)


def _colours(moved: SingleArray, largest: float) -> PictureArray:
    """Colours (n, 3) uint8 of displacements (n,), from dark blue (none) to yellow (the largest of the trajectory)."""
    level = np.rint(255 * moved / max(largest, 1e-12)).clip(0, 255).astype(np.uint8)
    return cv2.applyColorMap(level[:, None], cv2.COLORMAP_VIRIDIS)[:, 0, ::-1]


def _put_indenter(log: TouchLog, store: Store, rows: Indices, t_ns: Times) -> list[str]:
    """Put the indenter at its recorded poses; return in words why it is not there, where it is not."""
    rr = load_rerun()
    touch = log.touch
    path = indenter_path(store, touch.description, touch.facts["indenter"], touch.aligned, rows)
    if isinstance(path, str):
        return [f"No indenter beside the gel: {path}."]
    solid, poses = path
    log.put_static(
        INDENTER,
        rr.Mesh3D.from_fields(
            vertex_positions=np.asarray(solid.vertices, np.float32),
            vertex_normals=np.asarray(solid.vertex_normals, np.float32),
            triangle_indices=np.asarray(solid.faces, np.uint32),
            albedo_factor=INDENTER_COLOUR,
        ),
    )
    known = np.isfinite(poses).all(axis=(1, 2))
    for pose, moment in zip(poses[known], t_ns[known], strict=True):
        log.at(int(moment))
        log.put(INDENTER, rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
    return []

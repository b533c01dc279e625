"""Meshes attached to the frames of a store: appended run by run, each there wholly or not at all."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.contract.provenance import bytes_digest
from tactiledata.store.layout.arrays import append_rows, create_rows, open_root, set_length
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.manifest import Manifest, extended_digest
from tactiledata.store.layout.places import home_of
from tactiledata.store.read.meshes import FRAME_ARRAYS, PAD_ARRAYS, PadArrays, axes_of, mesh_path
from tactiledata.store.write.commit import changing

CHUNK_BYTES = 2**19
"""Of one chunk of rows before compression: a frame at random costs the decoding of one chunk."""
MOST_CHUNK_ROWS = 4096
CONTENT = {
    "displacement": "m, gel frame, of the nodes in kept",
    "force": "N, gel frame: what the indenter exerts on the nodes in surface",
    "contact": "1: the node in corners is pressed, 0: not, 255: no mesh",
    "wrench": "fx fy fz (N), tx ty tz (N m): what the gel exerts on the indenter, gel frame, torque about its origin",
    "residual": "largest unbalanced nodal force over the largest contact force",
    "status": "what became of the frame",
    "pad": "row of vertices; -1: no mesh",
    "vertices": "m, gel frame, undeformed",
}


def append_mesh(
    store_path: Path | str,
    name: str,
    described: Mapping[str, Any],
    pads: Sequence[Mapping[str, Any]],
    pad: PadArrays,
    frames: tuple[int, int],
    arrays: Mapping[str, NDArray[Any]],
) -> Manifest:
    """The manifest after frames got their rows in a mesh, in one commit; the mesh is made where there is none.

    Parameters
    ----------
    store_path : Path or str
        Folder of the store.
    name : str
        Of the mesh.
    described : dict
        ``settings``, ``statuses`` and ``kind`` of a mesh that is made.
    pads : sequence of dict
        What each of ``pad.vertices`` is of; appended where the mesh has fewer.
    pad : PadArrays
        The mesh itself, m; its numbering is that of the mesh that is there already.
    frames : (first, stop)
        ``first`` is where the mesh ends now.
    arrays : dict
        Rows by the names of ``FRAME_ARRAYS``.

    Raises
    ------
    StoreBusy, StoreError
        The store is as it was before.
    """
    with changing(store_path, with_card=False) as (folder, manifest):
        meshes = manifest.setdefault("meshes", {})
        if name not in meshes:
            meshes[name] = {**described, "rows": 0, "sizes": _sizes(pad), "pads": [], "counts": {}, "digest": ""}
            is_new = True
        else:
            is_new = False
        facts = meshes[name]
        if facts["rows"] != frames[0]:
            raise AssertionError(f"rows from {frames[0]} for a mesh of {facts['rows']}")
        with Batch(folder) as batch:
            writer = _MeshWriter(batch, home_of(manifest), name, facts)
            if is_new:
                writer.create(pad)
            writer.extend_pads(pads, pad.vertices)
            writer.extend_frames(frames[1], arrays)
            batch.publish()
        _count(facts, arrays)
    return manifest


def drop_mesh(store_path: Path | str, name: str) -> None:
    """A mesh is taken out of a store."""
    with changing(store_path) as (_, manifest):
        manifest["meshes"].pop(name)
        if not manifest["meshes"]:
            manifest.pop("meshes")


class _MeshWriter:
    def __init__(self, batch: Batch, home: str, name: str, facts: dict[str, Any]) -> None:
        self._batch, self._home, self._name, self._facts = batch, home, name, facts

    def _path(self, array: str) -> str:
        return mesh_path(self._home, self._name, array)

    def create(self, pad: PadArrays) -> None:
        """All arrays, empty, and the numbering of the mesh."""
        root = open_root(self._batch)
        for array, (dtype, fill, axes) in FRAME_ARRAYS.items():
            further = axes_of(self._facts, axes)
            chunk = _chunk_rows(dtype, further)
            create_rows(root, self._path(array), further, dtype, fill, chunk, self._attributes(array))
        for array, (dtype, rows, axes) in PAD_ARRAYS.items():
            further, count = axes_of(self._facts, axes), self._facts["sizes"][rows]
            chunk = 1 if array == "vertices" else max(1, count)
            create_rows(root, self._path(array), further, dtype, 0, chunk, self._attributes(array))
            if array != "vertices":
                append_rows(self._batch, self._path(array), 0, count, [getattr(pad, array)])

    def _attributes(self, array: str) -> dict[str, Any]:
        said: dict[str, Any] = {"content": CONTENT.get(array, "node numbers: rows of vertices")}
        if effects := self._facts["settings"].get("effects"):
            said["effects"] = effects
            if array == "wrench":
                said["content"] += "; with effects, as the force sensor would read it"
        return {**said, "statuses": self._facts["statuses"]} if array == "status" else said

    def extend_pads(self, pads: Sequence[Mapping[str, Any]], vertices: NDArray[np.float64]) -> None:
        """Pads that the mesh does not have yet."""
        known = len(self._facts["pads"])
        if len(pads) > known:
            append_rows(self._batch, self._path("vertices"), known, len(pads), [vertices[known:]])
            self._facts["pads"] = [dict(pad) for pad in pads]
            self._facts["sizes"]["pads"] = len(pads)

    def extend_frames(self, stop: int, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Rows of all frames up to ``stop``."""
        for array in FRAME_ARRAYS:
            values = arrays[array]
            if len(values):
                append_rows(self._batch, self._path(array), self._facts["rows"], stop, _blocks(values))
            else:
                set_length(self._batch, self._path(array), stop)
        self._facts["rows"] = stop


def _sizes(pad: PadArrays) -> dict[str, int]:
    counts = {name: len(getattr(pad, name)) for name in ("cells", "triangles", "kept", "surface", "corners", "base")}
    return {**counts, "vertices": pad.vertices.shape[1], "cell_nodes": pad.cells.shape[1], "pads": 0}


def _chunk_rows(dtype: str, further: tuple[int, ...]) -> int:
    row = np.dtype(dtype).itemsize * int(np.prod(further))
    return max(1, min(MOST_CHUNK_ROWS, CHUNK_BYTES // row))


def _blocks(values: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Some MiB at a time: what is mapped from a file is not read whole."""
    step = _chunk_rows(values.dtype.str, values.shape[1:]) * 8
    for start in range(0, len(values), step):
        yield np.asarray(values[start : start + step])


def _count(facts: dict[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    statuses, counts = np.unique(np.asarray(arrays["status"]), return_counts=True)
    for status, count in zip(statuses.tolist(), counts.tolist(), strict=True):
        facts["counts"][str(status)] = facts["counts"].get(str(status), 0) + count
    contents = [bytes_digest(arrays[name].tobytes()) for name in ("status", "wrench")]
    facts["digest"] = extended_digest(facts["digest"], *contents)

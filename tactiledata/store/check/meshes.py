"""Whether the meshes of a store are whole: every row readable, and what its status says of it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tactiledata.contract.lfs_pointer import without_remedy
from tactiledata.contract.records import Finding
from tactiledata.errors import TactileDataError
from tactiledata.store.read.meshes import FRAME_ARRAYS, HAS_MESH, StoredMesh
from tactiledata.store.read.reader import Store

BLOCK_ROWS = 64


def mesh_findings(store: Store) -> Iterator[Finding]:
    """Meshes that cannot be read, rows that are not what their status says, and frames that were not replayed."""
    for name in store.mesh_names:
        mesh = store.mesh(name)
        rows = mesh.facts["rows"]
        if rows > store.n_frames:
            yield _damage(name, f"it has {rows} rows for {store.n_frames} frames")
            continue
        try:
            mesh.pad()
            fault = _first_fault(mesh, rows)
        except (TactileDataError, OSError, ValueError, KeyError) as error:
            fault = without_remedy(error)
        if fault:
            yield _damage(name, fault)
        elif rows < store.n_frames:
            text = f"mesh {name!r} lacks the last {store.n_frames - rows} frames; `tactiledata replay` goes on"
            yield Finding("mesh-behind", "info", text, stream=name, count=store.n_frames - rows)


def _damage(name: str, message: str) -> Finding:
    return Finding("store-mesh", "damage", f"mesh {name!r}: {message}", stream=name)


def _first_fault(mesh: StoredMesh, rows: int) -> str:
    """A chunk that is gone reads as fill, which no frame with a mesh has, and no frame's status is."""
    counts: dict[str, int] = {}
    for start in range(0, rows, BLOCK_ROWS):
        frames = np.arange(start, min(start + BLOCK_ROWS, rows))
        status = mesh.status(frames)
        solved = np.isin(status, HAS_MESH)
        for code in status.tolist():
            counts[str(code)] = counts.get(str(code), 0) + 1
        for array in FRAME_ARRAYS:
            if array in ("status", "contact", "pad"):
                continue
            values = getattr(mesh, array)(frames).reshape(len(frames), -1)
            wrong = np.flatnonzero(np.isfinite(values).all(axis=1) != solved)
            if len(wrong):
                return f"{array} of frame {frames[wrong[0]]} is not what its status ({status[wrong[0]]}) says"
        wrong = np.flatnonzero((mesh.pad_numbers(frames) >= 0) != solved)
        touching = mesh.contact(frames).any(axis=1)
        wrong = np.union1d(wrong, np.flatnonzero(touching != (status == HAS_MESH[0])))
        if len(wrong):
            return f"pad or contact of frame {frames[wrong[0]]} is not what its status says"
    return "" if counts == mesh.facts["counts"] else "its statuses are not those that the manifest counts"

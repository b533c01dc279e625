"""Whether the meshes of a store are whole: every row readable, and what its status says of it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tactiledata.contract.records import Finding
from tactiledata.errors import NotFetched, TactileDataError
from tactiledata.store.read.meshes import FRAME_ARRAYS, HAS_MESH, StoredMesh
from tactiledata.store.read.reader import Store

BLOCK_ROWS = 64
REMEDY = "`tactiledata replay --replace` makes it anew"
"""What to do about a mesh that is damaged."""


def mesh_findings(store: Store) -> Iterator[Finding]:
    """Meshes that cannot be read, rows that are not what their status says, and frames that were not replayed."""
    for name in store.mesh_names:
        rows = store.mesh(name).facts["rows"]
        if fault := mesh_fault(store, name):
            yield Finding("store-mesh", "damage", f"mesh {name!r}: {fault}", stream=name)
        elif rows < store.n_frames:
            text = f"mesh {name!r} lacks the last {store.n_frames - rows} frames; `tactiledata replay` goes on"
            yield Finding("mesh-behind", "info", text, stream=name, count=store.n_frames - rows)


def mesh_fault(store: Store, name: str) -> str:
    """Why a mesh of a store cannot be trusted, and what to do; empty where it is whole. All of it is read."""
    mesh = store.mesh(name)
    rows = mesh.facts["rows"]
    if rows > store.n_frames:
        return f"it has {rows} rows for {store.n_frames} frames; {REMEDY}"
    try:
        mesh.pad()
        fault = _first_fault(mesh, rows)
    except NotFetched as error:
        return error.found
    except TactileDataError as error:
        fault = error.found
    except (OSError, ValueError, KeyError) as error:
        fault = str(error)
    return f"{fault}; {REMEDY}" if fault else ""


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

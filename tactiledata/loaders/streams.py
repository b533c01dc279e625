"""What the names of streams stand for: images, values at the moments of frames, native-rate signals, references."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import StoreError, UnknownName, UsageError

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

BACKGROUND = "background"
MeshKind = Literal["mesh", "mesh_wrench", "contact_mask"]
MESH_STREAMS: tuple[MeshKind, ...] = ("mesh", "mesh_wrench", "contact_mask")
"""What a replay attached; ``mesh/<name>`` says which replay where there are several."""
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
RESERVED = ("sensor", "indenter", "trajectory", "frame", "t_ns", "in_split")
"""Keys that every item has; no stream may be called so."""

Kind = Literal["image", "background", "aligned", "signal", "frame_value", "mesh", "mesh_wrench", "contact_mask"]
Unit = Literal["frame", "trajectory"]


@dataclass(frozen=True)
class Stream:
    """One stream of a dataset.

    Parameters
    ----------
    name : str
    kind : str
        ``aligned``: a value at the moment of each frame; ``signal``: samples at their native rate; ``mesh``,
        ``mesh_wrench``, ``contact_mask``: of what a replay attached.
    columns, units : (k,) names
        Empty for pictures.
    mesh : str
        The store's name of the mesh that it is of.
    """

    name: str
    kind: Kind
    columns: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    mesh: str = ""

    @property
    def is_picture(self) -> bool:
        """Whether it gives images."""
        return self.kind in ("image", "background")

    @property
    def is_of_mesh(self) -> bool:
        """Whether a replay attached it."""
        return self.kind in MESH_STREAMS

    @property
    def is_scalable(self) -> bool:
        """Whether mean and spread of its columns mean something: not of a mesh's nodes."""
        return self.kind not in ("mesh", "contact_mask")


def values_at_frames(store: Store, stream: Stream, rows: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return values (n, k) of a stream of numbers with a row a frame; NaN where none was recorded.

    Parameters
    ----------
    store : Store
        The store that holds them.
    stream : Stream
        Wrenches of a mesh, values of frames, or a signal aligned to frames.
    rows : (n,) int64
        Rows of frames.
    """
    if stream.kind == "mesh_wrench":
        return store.mesh(stream.mesh).wrench(rows)
    if stream.kind == "frame_value":
        return store.frame_values(stream.name, rows)
    return store.aligned(stream.name, rows)[0]


def nodes_at_frames(store: Store, stream: Stream, rows: NDArray[np.int64]) -> NDArray[Any]:
    """Return what a mesh's nodes do in frames: displacements (n, k, 3), m, or whether they are pressed (n, m).

    Parameters
    ----------
    store : Store
        The store that holds the mesh.
    stream : Stream
        Displacements or contact of a mesh.
    rows : (n,) int64
        Rows of frames.
    """
    mesh = store.mesh(stream.mesh)
    return mesh.displacement(rows) if stream.kind == "mesh" else mesh.contact(rows)


def find_streams(store: Store, names: Sequence[str] | str, unit: Unit) -> tuple[Stream, ...]:
    """Return streams by their names, in the order of the names.

    Parameters
    ----------
    store : Store
        The store that holds them.
    names : sequence of str, or str
        Names of signals, values, cameras, meshes or backgrounds.
    unit : "frame" or "trajectory"
        What an item of the dataset is; native rates need trajectories.

    Raises
    ------
    UnknownName
        A name that the store does not hold; the message lists what it holds.
    UsageError
        No name, a name given twice, or several cameras.
    StoreError
        Meshes, where none are attached.
    """
    asked = (names,) if isinstance(names, str) else tuple(names or ())
    if unit not in ("frame", "trajectory"):
        raise UnknownName("unit of a dataset", str(unit), ("frame", "trajectory"))
    if not asked or len(set(asked)) < len(asked) or not all(isinstance(name, str) for name in asked):
        raise UsageError(
            f"streams are {asked!r}",
            "names of streams, at least one, each once",
            f"The store holds: {', '.join(known(store))}.",
        )
    streams = tuple(_find(store, name, unit) for name in asked)
    cameras = [stream.name for stream in streams if stream.kind == "image"]
    if len(cameras) > 1:
        raise UsageError(
            f"streams name {len(cameras)} cameras ({', '.join(cameras)})",
            "at most one: each frame of a store is one image of one camera",
            "Make a dataset for each camera; `frame` and `t_ns` of the items tell which belong together.",
        )
    return streams


def known(store: Store) -> list[str]:
    """Names of all streams of a store."""
    manifest = store.manifest
    background = [BACKGROUND] if manifest["references"] else []
    values = [name for family in ("aligned", "signals", "frame_values") for name in manifest[family]]
    meshes = store.mesh_names
    of_meshes = [f"{stream}/{name}" for name in meshes for stream in MESH_STREAMS] if meshes[1:] else MESH_STREAMS
    return [*manifest["cameras"], *dict.fromkeys(values), *background, *(of_meshes if meshes else ())]


def _find(store: Store, name: str, unit: Unit) -> Stream:
    manifest = store.manifest
    if name in RESERVED:
        raise UsageError(f"a stream is called {name!r}", "another name", "Every item has this key anyway.")
    if name in manifest["cameras"]:
        return Stream(name, "image")
    families: tuple[tuple[str, Kind], ...] = (
        ("aligned" if unit == "frame" else "signals", "aligned" if unit == "frame" else "signal"),
        ("frame_values", "frame_value"),
    )
    for family, kind in families:
        if name in manifest[family]:
            facts = manifest[family][name]
            return Stream(name, kind, tuple(facts["columns"]), tuple(facts["units"]))
    if name == BACKGROUND:
        return Stream(name, "background")
    kind_of_mesh, _, mesh = name.partition("/")
    for mesh_kind in MESH_STREAMS:
        if mesh_kind == kind_of_mesh:
            return _of_mesh(store, name, mesh_kind, mesh)
    raise UnknownName("stream", name, known(store), "`tactiledata info` shows the streams of a store.")


def _of_mesh(store: Store, name: str, kind: MeshKind, mesh: str) -> Stream:
    meshes = store.mesh_names
    if not meshes:
        raise StoreError(
            f"the store {store.location} has no meshes",
            "a mesh for every frame",
            f"Run `tactiledata replay` to attach them, or leave {name!r} out of the streams.",
        )
    if not mesh and len(meshes) > 1:
        raise UsageError(
            f"the stream {name!r} could be of any of the meshes {', '.join(meshes)}",
            "one of them",
            f"Name it: {name}/{meshes[0]}.",
        )
    chosen = mesh or meshes[0]
    if chosen not in meshes:
        raise UnknownName("mesh", chosen, meshes, "`tactiledata info` shows the meshes of a store.")
    if kind == "mesh_wrench":
        return Stream(name, kind, WRENCH, ("N", "N", "N", "N m", "N m", "N m"), chosen)
    return (
        Stream(name, kind, ("x", "y", "z"), ("m",) * 3, chosen) if kind == "mesh" else Stream(name, kind, mesh=chosen)
    )

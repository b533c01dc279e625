"""Frames of one part of a split as arrays for networks: pictures of one size, displacements, forces, backgrounds."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from split_models.networks.mesh_graph import Topology, topology_of
from tactiledata.arrays import PictureArray
from tactiledata.contract.provenance import digest_of
from tactiledata.errors import UsageError
from tactiledata.loaders.numpy import TactileArrays

KEPT_BYTES = 4 * 2**30
"""Largest size in bytes up to which pictures, and displacements, are kept in memory; larger ones are read by batch."""
CHUNK = 256
"""Frames that are read together."""


class TouchFrames:
    """Frames of one part of a split; frames that lack a requested value are left out.

    Parameters
    ----------
    location : str or Path
        The store.
    part : str
        ``"<split>/<part>"``; data are never opened without a split.
    camera : str
        Stream of pictures.
    size : (height, width) px, optional
        Size to which pictures are scaled by area; their own size unless given.
    mesh : str, optional
        Name of a mesh of the store; ``""`` for its only one, None for none.
    wrench : str, optional
        Signal that forces are taken from; None for none.
    background : bool
        Whether each sensor must have a picture without contact.
    kept_bytes : int
        Largest size in bytes of pictures, and of displacements, that are kept in memory.

    Raises
    ------
    MissingSplit
        The store has no such split.
    StoreError
        The store has no mesh, or a sensor has no background.
    UnknownName
        The store has no such stream.
    UsageError
        No frame is left.
    """

    def __init__(
        self,
        location: str | os.PathLike[str],
        part: str,
        *,
        camera: str = "digit",
        size: Sequence[int] | None = None,
        mesh: str | None = None,
        wrench: str | None = None,
        background: bool = True,
        kept_bytes: int = KEPT_BYTES,
    ) -> None:
        mesh_stream = None if mesh is None else f"mesh/{mesh}" if mesh else "mesh"
        streams = [camera, wrench, mesh_stream, "background" if background else None]
        self.arrays = TactileArrays(
            location, part, [name for name in streams if name], missing="drop", image_dtype="uint8"
        )
        self.part, self.wrench = part, wrench
        self.size = None if size is None else (int(size[0]), int(size[1]))
        self._mesh = next((stream.mesh for stream in self.arrays.streams if stream.kind == "mesh"), None)
        self._kept_bytes = kept_bytes
        self._kept: dict[str, NDArray[Any]] = {}
        places = np.arange(len(self.arrays))
        self.rows = self.arrays.index.rows
        self.sensors = np.asarray(self.arrays.index.sensors(places), dtype=object)
        trajectory = self.arrays.index.trajectory[places]
        self.trajectories = np.asarray(self.arrays.index.uids[trajectory], dtype=object)
        self.indenters = np.asarray(self.arrays.index.indenters[trajectory], dtype=object)

    def __len__(self) -> int:
        return len(self.arrays)

    @property
    def fingerprint(self) -> str:
        """Digest of the frames, the pictures' size, the mesh and the wrench; equal for equal data."""
        mesh = "" if self._mesh is None else self.arrays.store.mesh(self._mesh).facts["digest"]
        return digest_of([self.arrays.fingerprint, self.size, mesh, self.wrench])

    @property
    def split_digest(self) -> str:
        """Digest of the split's table, which assigns trajectories to parts."""
        name = self.part.rpartition("/")[0]
        from tactiledata.splits.manifest import read_split

        return str(read_split(self.arrays.store, name).document["table"]["sha256"])

    def topology(self) -> Topology:
        """Topology of the mesh that displacements refer to."""
        return topology_of(self.arrays.store.mesh(self.mesh_name))

    def pictures(self, numbers: Sequence[int] | NDArray[np.int64]) -> PictureArray:
        """Pictures (n, h, w, 3), uint8 RGB, of frames by their number."""
        return self._get("pictures", self._read_pictures, numbers)

    def displacements(self, numbers: Sequence[int] | NDArray[np.int64]) -> NDArray[np.float32]:
        """Displacements (n, v, 3), m, gel frame, of frames by their number."""
        name = self.mesh_name
        return self._get("displacements", lambda rows: self.arrays.store.mesh(name).displacement(rows), numbers)

    def forces(self, numbers: Sequence[int] | NDArray[np.int64] | None = None) -> NDArray[np.float32]:
        """Contact forces (n, 3), N, gel frame, of frames by their number; of all frames unless given."""
        if self.wrench is None:
            raise UsageError("forces of frames that were opened without a wrench", "wrench='contact_wrench'")
        rows = self.rows if numbers is None else self.rows[np.asarray(numbers, np.int64)]
        return self.arrays.store.aligned(self.wrench, rows)[0][:, :3].astype(np.float32)

    def background(self, sensor: str) -> PictureArray:
        """Picture (h, w, 3), uint8 RGB, of a sensor without contact."""
        return self._sized(self.arrays.store.reference(sensor).image[None])[0]

    def backgrounds(self) -> dict[str, PictureArray]:
        """Pictures (h, w, 3) without contact by sensor, for the sensors of these frames that have one in the store."""
        held = self.arrays.store.manifest["references"]
        return {name: self.background(name) for name in self.sensor_names if name in held}

    @property
    def sensor_names(self) -> list[str]:
        """Sorted names of the sensors of these frames."""
        return sorted(set(self.sensors))

    @property
    def mesh_name(self) -> str:
        """The store's name of the mesh that displacements refer to."""
        if self._mesh is None:
            raise UsageError("meshes of frames that were opened without a mesh", "mesh='' or a mesh's name")
        return self._mesh

    def _read_pictures(self, rows: NDArray[np.int64]) -> PictureArray:
        """Pictures (n, h, w, 3) of rows of the store, scaled to `size`."""
        return self._sized(np.asarray(self.arrays.store.images(rows)))

    def _sized(self, pictures: PictureArray) -> PictureArray:
        """Pictures (n, h, w, 3) scaled by area to `size`."""
        if self.size is None or pictures.shape[1:3] == self.size:
            return pictures
        height, width = self.size
        return np.stack([cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA) for picture in pictures])

    def _get(
        self,
        kind: str,
        read: Callable[[NDArray[np.int64]], NDArray[Any]],
        numbers: Sequence[int] | NDArray[np.int64],
    ) -> NDArray[Any]:
        """Values (n, ...) of frames by their number: from memory where all of a kind fit, else read by ``read``."""
        places = np.asarray(numbers, np.int64)
        if kind not in self._kept:
            first = read(self.rows[:1])
            if first.nbytes * len(self) > self._kept_bytes:
                return read(self.rows[places])
            kept = np.empty((len(self), *first.shape[1:]), first.dtype)
            for start in range(0, len(self), CHUNK):
                kept[start : start + CHUNK] = read(self.rows[start : start + CHUNK])
            self._kept[kind] = kept
        return self._kept[kind][places]


LEAST_SHARE = 0.1
"""Least spread of a vertex, as a share of the root mean square of all vertices' spreads.

Bonded nodes, and vertices that no touch of the train part moves, would otherwise be scaled to huge values elsewhere."""


def vertex_scale(frames: TouchFrames) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and spread (v, 3), m, by which each vertex's displacement is scaled; the spread is bounded below.

    Raises
    ------
    UsageError
        No vertex moves in any frame.
    """
    mean, spread = vertex_moments(frames)
    least = LEAST_SHARE * float(np.sqrt(np.square(spread).mean()))
    if least == 0.0:
        raise UsageError(
            f"no vertex moves in any of the {len(frames)} frames of {frames.part}",
            "touches with deformed meshes",
            "Look at the replay's page, or take other bounds of the force.",
        )
    return mean, np.maximum(spread, least)


def vertex_moments(frames: TouchFrames) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and standard deviation (v, 3), m, of each vertex's displacement over all frames."""
    total: Any = 0.0
    squares: Any = 0.0
    for start in range(0, len(frames), CHUNK):
        moved = frames.displacements(range(start, min(start + CHUNK, len(frames)))).astype(np.float64)
        total, squares = total + moved.sum(axis=0), squares + (moved**2).sum(axis=0)
    mean = total / len(frames)
    return mean, np.sqrt(np.maximum(squares / len(frames) - mean**2, 0.0))

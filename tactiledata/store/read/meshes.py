"""Meshes that a replay attached to the frames: where they lie, what a row is, and how to read them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactiledata.store.layout.places import folder_name
from tactiledata.store.read.rows import Rows, checked_rows

HAS_MESH = (0, 1)
"""Statuses of frames with a mesh, in contact and in free air; every other one says why there is none."""

FRAME_ARRAYS: dict[str, tuple[str, float, tuple[str, ...]]] = {
    "displacement": ("<f4", np.nan, ("kept", "3")),
    "force": ("<f4", np.nan, ("surface", "3")),
    "contact": ("|u1", 255, ("corners",)),
    "wrench": ("<f8", np.nan, ("6",)),
    "residual": ("<f8", np.nan, ()),
    "status": ("|i1", -1, ()),
    "pad": ("<i2", -1, ()),
}
"""Type, fill and further axes of the arrays with a row a frame; an axis is a number or one of the mesh's sizes."""

PAD_ARRAYS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "vertices": ("<f8", "pads", ("vertices", "3")),
    "cells": ("<i8", "cells", ("cell_nodes",)),
    "triangles": ("<i8", "triangles", ("3",)),
    "kept": ("<i8", "kept", ()),
    "surface": ("<i8", "surface", ()),
    "corners": ("<i8", "corners", ()),
    "base": ("<i8", "base", ()),
}
"""Type, rows and further axes of the arrays that the mesh itself is."""

Facts = Mapping[str, Any]


def mesh_path(home: str, name: str, array: str) -> str:
    """One of the arrays of a mesh, below the folder of all numbers.

    Parameters
    ----------
    home : str
        Folder of all numbers with its ``/``, or empty, as `home_of` gives it.
    name : str
        Of the mesh.
    array : str
        One of ``FRAME_ARRAYS`` or ``PAD_ARRAYS``.
    """
    return f"{home}meshes/{folder_name(name)}/{array}"


def axes_of(facts: Facts, axes: tuple[str, ...]) -> tuple[int, ...]:
    """The further axes of an array of a mesh."""
    return tuple(int(axis) if axis.isdigit() else facts["sizes"][axis] for axis in axes)


def mesh_arrays(home: str, name: str, facts: Facts) -> Iterator[tuple[str, int]]:
    """Paths of the arrays of a mesh, with their lengths.

    Parameters
    ----------
    home : str
        Folder of all numbers with its ``/``, or empty, as `home_of` gives it.
    name : str
        Of the mesh.
    facts : dict
        What the manifest says of the mesh: ``rows`` and ``sizes``.
    """
    yield from ((mesh_path(home, name, array), facts["rows"]) for array in FRAME_ARRAYS)
    yield from ((mesh_path(home, name, array), facts["sizes"][rows]) for array, (_, rows, _) in PAD_ARRAYS.items())


@dataclass(frozen=True)
class PadArrays:
    """The mesh itself; node numbers are rows of ``vertices``.

    Parameters
    ----------
    vertices : (p, v, 3) m
        Undeformed, gel frame; one for each pad (``pads``), all of one numbering.
    cells : (c, 8) or (c, 10)
    triangles : (t, 3)
        The outer surface, outward.
    kept : (k,)
        Nodes that the rows of ``displacement`` belong to.
    surface : (s,)
        Nodes that the rows of ``force`` belong to.
    corners : (m,)
        Nodes that the rows of ``contact`` belong to.
    base : (b,)
        Nodes bonded to the rigid backing.
    """

    vertices: NDArray[np.float64]
    cells: NDArray[np.int64]
    triangles: NDArray[np.int64]
    kept: NDArray[np.int64]
    surface: NDArray[np.int64]
    corners: NDArray[np.int64]
    base: NDArray[np.int64]


class StoredMesh:
    """What one replay attached to the frames of a store.

    A frame that is not replayed yet, or has no mesh, has NaN; ``status`` and ``statuses`` say why.

    Parameters
    ----------
    name : str
    facts : dict
        Its entry in the manifest.
    n_frames : int
        Of the store.
    rows : callable
        Rows of an array, by path and length.
    home : str
    """

    def __init__(
        self, name: str, facts: Facts, n_frames: int, rows: Callable[[str, int], Rows], home: str = ""
    ) -> None:
        self.name, self.facts, self._n_frames = name, facts, n_frames
        self._rows = {path.rpartition("/")[2]: rows(path, length) for path, length in mesh_arrays(home, name, facts)}

    @property
    def settings(self) -> Facts:
        """Engine, fidelity, material and whatever else shaped it."""
        return self.facts["settings"]

    @property
    def statuses(self) -> Mapping[int, str]:
        """What each status means, in words."""
        return {int(status): words for status, words in self.facts["statuses"].items()}

    def pad(self) -> PadArrays:
        """The mesh itself."""
        return PadArrays(*(self._rows[array].take(None) for array in PAD_ARRAYS))

    def displacement(self, rows: ArrayLike | None = None) -> NDArray[np.float32]:
        """Displacements (n, k, 3), m, gel frame, of the kept nodes at frames."""
        return self._at("displacement", rows)

    def force(self, rows: ArrayLike | None = None) -> NDArray[np.float32]:
        """What the indenter exerts on each node of the surface (n, s, 3), N, gel frame."""
        return self._at("force", rows)

    def contact(self, rows: ArrayLike | None = None) -> NDArray[np.bool_]:
        """Whether each corner node of the surface is pressed (n, m); false also where there is no mesh."""
        return self._at("contact", rows) == 1

    def wrench(self, rows: ArrayLike | None = None) -> NDArray[np.float64]:
        """What the gel exerts on the indenter (n, 6), N and N m, gel frame, torque about its origin."""
        return self._at("wrench", rows)

    def residual(self, rows: ArrayLike | None = None) -> NDArray[np.float64]:
        """Largest unbalanced nodal force over the largest contact force (n,)."""
        return self._at("residual", rows)

    def status(self, rows: ArrayLike | None = None) -> NDArray[np.int8]:
        """Status (n,) of frames; -1 where a frame is not replayed yet."""
        return self._at("status", rows)

    def has_mesh(self, rows: ArrayLike | None = None) -> NDArray[np.bool_]:
        """Whether frames have a mesh (n,)."""
        return np.isin(self.status(rows), HAS_MESH)

    def pad_numbers(self, rows: ArrayLike | None = None) -> NDArray[np.int16]:
        """Return the number of the pad (n,) of each frame's sensor; -1 where there is no mesh."""
        return self._at("pad", rows)

    def _at(self, array: str, rows: ArrayLike | None) -> NDArray[Any]:
        wanted = np.arange(self._n_frames) if rows is None else checked_rows(rows, self._n_frames, "the frames")
        dtype, fill, axes = FRAME_ARRAYS[array]
        values = np.full((len(wanted), *axes_of(self.facts, axes)), fill, dtype)
        is_there = wanted < self.facts["rows"]
        if is_there.any():
            values[is_there] = self._rows[array].take(wanted[is_there])
        return values

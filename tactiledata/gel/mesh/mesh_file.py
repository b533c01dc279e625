"""Pad from a user's mesh file: read, checked, turned into the gel frame, with ten-node cells that do not lock."""

from __future__ import annotations

import struct
from pathlib import Path

import meshio
import numpy as np

from tactiledata.arrays import Array
from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.errors import MissingFile, SchemaError
from tactiledata.gel.mesh.mesh_frame import gel_axes
from tactiledata.gel.mesh.pad import Indices, PadMesh
from tactiledata.gel.mesh.tetrahedra import boundary_of, ten_node_cells
from tactiledata.units import TO_METRES, metres

READERS = {".mesh": meshio.medit.read, ".msh": meshio.gmsh.read, ".vtk": meshio.vtk.read}
"""Reader of each file suffix."""
MAX_MESH_BYTES = 256 * 2**20
"""Largest mesh file that is read, bytes."""
SMALLEST_PAD, LARGEST_PAD = 2e-3, 0.1
"""Limits of a pad's longest side, m; a size outside them means that the unit is wrong."""
FLAT_CELL = 1e-6
"""Volume of a cell, as a share of the median volume, up to which the cell counts as flat."""
ON_BASE = 1e-3
"""Largest distance from the base's plane, as a share of the pad's longest side, of nodes that lie on the base."""
_READER_FAULTS = (
    meshio.ReadError,
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    ArithmeticError,
    AssertionError,
    EOFError,
    MemoryError,
    struct.error,
)
"""Errors that meshio's readers raise on broken files."""


def pad_from_file(path: Path, unit: str, out: str | None = None, along: str | None = None) -> PadMesh:
    """Read a volume mesh of four-node tetrahedra as a pad of ten-node tetrahedra.

    The base is the lowest plane along ``out``; all other faces of the boundary are the outer surface. The origin lies
    at the height of the highest point, in the middle of the outline.

    Parameters
    ----------
    path : Path
        MEDIT ``.mesh``, Gmsh ``.msh`` or ``.vtk``; cells other than tetrahedra are left out.
    unit : str
        Unit of the file's numbers: ``"m"``, ``"mm"``, ``"um"``, ``"cm"`` or ``"in"``; mesh files do not state it.
    out, along : "+x", "-x", "+y", "-y", "+z" or "-z", optional
        Axes of the file that become +z and +y of the gel frame. Left out: the largest flat patch of the boundary is
        the base, y lies along the longer side of the outline, towards the end where the outline is narrower.

    Raises
    ------
    MissingFile
        No such file.
    SchemaError
        The file cannot be read, holds no tetrahedra, has cracks, cells turned inside out or no flat base, or has a
        size outside ``SMALLEST_PAD`` to ``LARGEST_PAD``.
    UnknownName
        An unknown unit.
    """
    # read and check
    scale = metres(1.0, unit)
    points, cells = _read(path)
    points = points * scale
    _check_size(points, unit, path)
    cells = _oriented(points, cells, path)
    faces = _closed_boundary(points, cells, path)
    # turn into the gel frame, origin on top in the middle
    points = (points - points.mean(axis=0)) @ gel_axes(points, faces, out, along, str(path)).T
    points[:, :2] -= (points[:, :2].max(axis=0) + points[:, :2].min(axis=0)) / 2
    points[:, 2] -= points[:, 2].max()
    # ten-node cells, base and outer surface
    vertices, tetrahedra, surface_faces = ten_node_cells(points, cells, faces)
    height = vertices[:, 2] - vertices[:, 2].min()
    is_base = height < ON_BASE * np.ptp(points, axis=0).max()
    is_outer = ~is_base[surface_faces].all(axis=1)
    return PadMesh(path.stem, "tetrahedron10", vertices, tetrahedra, np.flatnonzero(is_base), surface_faces[is_outer])


def _read(path: Path) -> tuple[Array, Indices]:
    """Read the points (v, 3) that cells use, in the file's unit, and the tetrahedra (c, 4)."""
    # refuse what is no mesh file before a reader sees it
    if not path.is_file():
        raise MissingFile(f"{path} does not exist", "a mesh file of the gel", path=str(path))
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise SchemaError(
            f"{path} is a {path.suffix or 'nameless'} file",
            f"one of {', '.join(READERS)}",
            "Convert it.",
            path=str(path),
        )
    if path.stat().st_size > MAX_MESH_BYTES:
        raise SchemaError(
            f"{path} has {path.stat().st_size} bytes",
            f"at most {MAX_MESH_BYTES}",
            "Take a coarser mesh.",
            path=str(path),
        )
    refuse_lfs_pointer(path)
    # meshio's readers raise many kinds of errors on broken files
    try:
        mesh = reader(str(path))
        points = np.asarray(mesh.points, dtype=np.float64)
        blocks = [block.data for block in mesh.cells if block.type in ("tetra", "tetra10") and len(block.data)]
    except _READER_FAULTS as error:
        raise SchemaError(
            f"{path} cannot be read as a mesh ({type(error).__name__}: {str(error)[:200]})",
            "a whole MEDIT, Gmsh or VTK file",
            "Export it again.",
            path=str(path),
        ) from error
    if not blocks or points.ndim != 2 or points.shape[1] != 3:
        kinds = ", ".join(sorted({block.type for block in mesh.cells if len(block.data)})) or "nothing"
        raise SchemaError(
            f"{path} holds no tetrahedra, only {kinds}",
            "a volume mesh of tetrahedra in three dimensions",
            "Fill the surface with cells first, with Gmsh or TetGen.",
            path=str(path),
        )
    cells = np.concatenate([np.asarray(block, dtype=np.int64)[:, :4] for block in blocks])
    if cells.min() < 0 or cells.max() >= len(points):
        raise SchemaError(
            f"cells of {path} name node {cells.max()}", f"0 to {len(points) - 1}", "Export it again.", path=str(path)
        )
    # drop points that no cell uses
    used, places = np.unique(cells, return_inverse=True)
    points = points[used]
    if not np.isfinite(points).all():
        raise SchemaError(
            f"{path} has nodes that are no finite numbers", "coordinates", "Export it again.", path=str(path)
        )
    return points, places.reshape(-1, 4).astype(np.int64)


def _check_size(points: Array, unit: str, path: Path) -> None:
    """Refuse points (v, 3), m, of a pad so small or large that the unit must be wrong; name units that fit."""
    longest = float(np.ptp(points, axis=0).max())
    if SMALLEST_PAD <= longest <= LARGEST_PAD:
        return
    length_in_file = longest / TO_METRES[unit]
    fits = [
        unit_name for unit_name, factor in TO_METRES.items() if SMALLEST_PAD <= length_in_file * factor <= LARGEST_PAD
    ]
    raise SchemaError(
        f"the gel in {path} is {longest:.4g} m long when its numbers are read as {unit}",
        f"{SMALLEST_PAD} to {LARGEST_PAD} m",
        f"Its numbers fit the unit {' or '.join(fits)}." if fits else "Check the file's scale.",
        path=str(path),
        extent=longest,
    )


def _oriented(points: Array, cells: Indices, path: Path) -> Indices:
    """Return the cells (c, 4) with nodes in the order of positive volume, which files mix; refuse flat cells."""
    corners = points[cells]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    n_flat = int((np.abs(volumes) <= FLAT_CELL * np.median(np.abs(volumes))).sum())
    if n_flat:
        raise SchemaError(
            f"{path}: {n_flat} of {len(cells)} cells are flat",
            "cells of positive volume",
            "Mesh the gel again, or optimise the mesh in Gmsh.",
            path=str(path),
            flat=n_flat,
        )
    return np.where(volumes[:, None] < 0, cells[:, [1, 0, 2, 3]], cells)


def _closed_boundary(points: Array, cells: Indices, path: Path) -> Indices:
    """Return the faces (f, 3) of the boundary, outward; refuse cells that do not join or are turned inside out.

    The boundary of a volume is always closed. A mesh that is not watertight therefore shows in nodes that are there
    twice, or in faces that more than two cells share.
    """
    boundary = boundary_of(cells)
    grid = np.round((points - points.min(axis=0)) / (1e-6 * np.ptp(points, axis=0).max()))
    n_double = len(points) - len(np.unique(grid, axis=0))
    if boundary.most_shared > 2 or n_double:
        raise SchemaError(
            f"{path} is not watertight: {n_double} nodes lie on others without being joined"
            + (f", and {boundary.most_shared} cells share one face" if boundary.most_shared > 2 else ""),
            "cells that join face to face",
            "Merge double nodes, or mesh the closed surface again.",
            path=str(path),
            double_nodes=n_double,
        )
    if boundary.folded:
        raise SchemaError(
            f"{path}: cells are turned inside out: {boundary.folded} faces have both of their cells on one side",
            "cells that do not overlap",
            "Mesh the gel again, or optimise the mesh in Gmsh.",
            path=str(path),
            folded=boundary.folded,
        )
    return boundary.faces

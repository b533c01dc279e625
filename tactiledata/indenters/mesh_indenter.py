"""Any solid, from a mesh file beside a log or a scenario."""

from __future__ import annotations

import io
import struct
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import igl
import numpy as np
import trimesh
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.contract.paths import path_inside
from tactiledata.errors import LostFile, SchemaError
from tactiledata.indenters.base import LARGEST_PART, SMALLEST_PART, Indenter
from tactiledata.units import metres

UNITS = ("m", "mm")
"""Units of length that a document may state for a mesh, as in ``schemas/log.json``."""
FILE_TYPES = ("stl", "obj", "ply")
"""Suffixes of formats that hold triangles and no code; materials and textures that they name are ignored."""
MAX_MESH_BYTES = 64 * 2**20
"""Largest size, bytes, of a mesh file that is read: about 1.3 million triangles of binary STL."""
RAY_SCALE = 1e5
"""Factor on lengths while rays are cast: below about 1e-7 in area a triangle counts as degenerate there."""
RAY_OFFSETS = 1e-9 * np.array([[0.1, 0.23], [-0.37, 0.11], [0.29, -0.41]])
"""Sideways shifts (3, 2), m, of the three rays at each place: a ray may slip between two triangles, three do not.
Their ratios are not simple, so that the rays do not all lie along one edge."""


class MeshIndenter(Indenter):
    """A solid given by its surface, in the frame of its file: the tip at the origin, the body towards +z.

    The mesh is taken as it lies; where the file has another origin or the tip points elsewhere, turn it in the CAD
    program. The distance is exact for the mesh (not for the curved part that it approximates).

    Parameters
    ----------
    surface : trimesh.Trimesh
        Watertight surface, m, indenter frame.
    file : str
        Path of the mesh as the document states it.
    unit : str
        Unit of the numbers in the file, one of ``UNITS``.

    Not to be confused with
    -----------------------
    The mesh of the gel, which is a volume and deforms.
    """

    shape = "mesh"
    title = "any solid, from a mesh file"

    def __init__(self, surface: trimesh.Trimesh, file: str = "", unit: str = "m") -> None:
        self._surface = surface
        self._file = file
        self._unit = unit

    @property
    def sizes(self) -> dict[str, float]:
        """An empty dict: a mesh has no sizes to set."""
        return {}

    @property
    def document(self) -> dict[str, Any]:
        """File and unit of the mesh, as ``log.yaml`` states them."""
        return {"mesh": self._file, "unit": self._unit}

    @cached_property
    def _arrays(self) -> tuple[Array, NDArray[np.int64]]:
        """Vertices (v, 3), m, and faces (f, 3) of the surface, as libigl takes them."""
        vertices = np.ascontiguousarray(self._surface.vertices, dtype=np.float64)
        return vertices, np.ascontiguousarray(self._surface.faces, dtype=np.int64)

    def signed_distance(self, points: Array) -> Array:
        """Signed distances (n,), m, of points (n, 3), by libigl: nearest triangle, sign from the winding number.

        Some 30,000 points a second for 32,768 triangles, on two busy cores. Each call builds a tree of boxes anew: ask
        for many points at once. Where closed parts overlap, the sign is right and the magnitude inside is a bound.
        """
        queries = np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 3)
        if not len(queries):
            return np.zeros(0)
        signed, _, nearest, _ = igl.signed_distance(
            queries, *self._arrays, sign_type=igl.SIGNED_DISTANCE_TYPE_WINDING_NUMBER
        )
        # only the sign is taken: the magnitude counts overlapping parts several times
        return np.copysign(np.linalg.norm(queries - nearest, axis=1), signed)

    def mesh(self) -> trimesh.Trimesh:
        return self._surface.copy()

    def height(self, x: Array, y: Array) -> Array:
        # rays from below each place; the lowest of three hits counts
        vertices, faces = self._arrays
        start = float(vertices[:, 2].min()) - SMALLEST_PART
        tree = igl.AABB()
        tree.init(vertices * RAY_SCALE, faces)
        places = np.stack([np.ravel(x), np.ravel(y)], axis=1).astype(np.float64)
        lowest = np.full(len(places), np.inf)
        up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
        for offset in RAY_OFFSETS if len(places) else []:
            origins = np.column_stack([places + offset, np.full(len(places), start)]) * RAY_SCALE
            triangle, distance, _ = tree.intersect_ray_first(vertices * RAY_SCALE, faces, origins, up)
            is_hit = triangle >= 0
            lowest[is_hit] = np.minimum(lowest[is_hit], start + distance[is_hit] / RAY_SCALE)
        return lowest.reshape(np.shape(x))


def load_mesh_indenter(entry: Mapping[str, Any], folder: Path | None, where: str) -> MeshIndenter:
    """Return the indenter of an entry ``{mesh, unit}`` of a log or a scenario.

    Parameters
    ----------
    entry : mapping
        ``mesh``, the path of a file, and ``unit``, that of its numbers.
    folder : Path, optional
        Folder to which the path is relative; ``None`` refuses every mesh.
    where : str
        Document and place in it, for messages.

    Raises
    ------
    SchemaError
        No unit, an unknown kind of file, a file that is too large or no mesh, a surface that is open or inconsistent,
        or a size that shows that the unit is wrong.
    LostFile, UnsafeContent
        A file that does not exist, or lies outside ``folder``.
    """
    # what the entry states
    name, unit = entry["mesh"], entry.get("unit")
    if not isinstance(name, str) or not name:
        raise SchemaError(f"{where} names the mesh {name!r}", "the path of a file", path=where)
    if unit is None:
        raise SchemaError(
            f"{where} names the mesh {name!r} without its unit",
            f"'unit', one of: {', '.join(UNITS)}",
            "Mesh files do not say their unit; CAD programs mostly write mm.",
            path=where,
        )
    if unit not in UNITS:
        raise SchemaError(
            f"{where} states the unit {unit!r} for the mesh {name!r}", f"one of: {', '.join(UNITS)}", path=where
        )
    if folder is None:
        raise SchemaError(
            f"{where} names the mesh {name!r} in a document without a folder",
            "the folder of the mesh files that recordings name",
            "A store holds no meshes of indenters: name the folder with --indenters FOLDER.",
            path=where,
        )
    # what the file holds
    path = path_inside(folder, name, where)
    with np.errstate(over="ignore", invalid="ignore"):  # absurd numbers are what the checks are for
        surface = _read(path, where)
        _check_surface(surface, path, where)
        surface.apply_scale(metres(1.0, unit))
        _check_size(surface, unit, path, where)
    return MeshIndenter(surface, name, unit)


def _read(path: Path, where: str) -> trimesh.Trimesh:
    """Return the triangles of a mesh file, in its own unit; refuse other kinds, large files and broken files."""
    kind = path.suffix.lower().lstrip(".")
    if kind not in FILE_TYPES:
        raise SchemaError(
            f"{where} names the mesh {path.name!r}",
            f"a file of kind {', '.join(FILE_TYPES)}",
            "Convert it.",
            path=where,
        )
    if not path.is_file():
        raise LostFile(f"{where} names the mesh {path}, which does not exist", "a file", path=str(path))
    size = path.stat().st_size
    if size > MAX_MESH_BYTES:
        raise SchemaError(
            f"{path} has {size} bytes", f"at most {MAX_MESH_BYTES}", "Reduce the number of its triangles.", path=where
        )
    refuse_lfs_pointer(path)
    # from bytes, not by name: so the loader cannot follow the names of further files inside it
    try:
        loaded = trimesh.load_mesh(io.BytesIO(path.read_bytes()), file_type=kind, skip_materials=True, process=True)
    except _LOADER_FAULTS as error:
        raise _not_a_mesh(path, where, f"{type(error).__name__}: {error}") from error
    if not isinstance(loaded, trimesh.Trimesh) or not len(loaded.faces):
        raise _not_a_mesh(path, where, "no triangles in it")
    if loaded.vertices.shape[1] != 3:
        raise _not_a_mesh(path, where, f"vertices with {loaded.vertices.shape[1]} coordinates")
    return loaded


_LOADER_FAULTS = (
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    ArithmeticError,
    EOFError,
    MemoryError,
    NotImplementedError,
    struct.error,
    trimesh.exchange.stl.HeaderError,
)
"""Errors that the loaders of trimesh have been seen to raise on broken files."""


def _not_a_mesh(path: Path, where: str, why: str) -> SchemaError:
    """Return the error of a file that cannot be read as a mesh, with the reason."""
    return SchemaError(
        f"{path} cannot be read as a mesh ({why[:200]})",
        "a whole STL, OBJ or PLY file",
        "Export it again from the CAD program.",
        path=where,
    )


def _check_surface(surface: trimesh.Trimesh, path: Path, where: str) -> None:
    """Refuse a surface that is not finite, open or inconsistent; turn one outward that faces inward everywhere."""
    vertices = surface.vertices[np.unique(surface.faces)]
    if not np.isfinite(vertices).all():
        raise SchemaError(
            f"{path} has vertices that are not finite numbers", "finite coordinates", "Export it again.", path=where
        )
    # an edge of an even number of triangles is closed: bodies may touch along it
    n_open = int((np.unique(surface.edges_sorted, axis=0, return_counts=True)[1] % 2).sum())
    if n_open:
        raise SchemaError(
            f"{path} is not watertight: {n_open} open edges",
            "a closed surface, every edge shared by two triangles",
            "Close it in the CAD program, or with 'make manifold' of Blender or MeshLab.",
            path=where,
            open_edges=n_open,
        )
    if not surface.is_winding_consistent:
        raise SchemaError(
            f"{path} has triangles that face both ways",
            "triangles that all face outward",
            "Recalculate the normals in the CAD program.",
            path=where,
        )
    if surface.volume < 0:  # all of them face inward: which side is inside is plain
        surface.invert()


def _check_size(surface: trimesh.Trimesh, unit: str, path: Path, where: str) -> None:
    """Refuse a surface, m, that is larger or smaller than any indenter, and name the unit that would fit."""
    largest = float(surface.extents.max())
    if SMALLEST_PART <= largest <= LARGEST_PART:
        return
    as_written = largest / metres(1.0, unit)
    fits = [other for other in UNITS if SMALLEST_PART <= metres(as_written, other) <= LARGEST_PART]
    raise SchemaError(
        f"{path} measures {largest:.4g} m when its numbers are read as {unit}",
        f"an indenter between {SMALLEST_PART} m and {LARGEST_PART} m",
        f"Its numbers fit the unit {' or '.join(fits)}: correct 'unit'." if fits else "Check the file's scale.",
        path=where,
        extent=largest,
    )

"""Watertight meshes of swept and revolved figures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactiledata.errors import UsageError

if TYPE_CHECKING:
    import trimesh

SECTIONS = 128
"""Segments of a full turn in meshes: chords are off the circle by 0.03 % of its radius."""


def sealed(vertices: ArrayLike, faces: ArrayLike) -> trimesh.Trimesh:
    """Return the mesh of vertices (v, 3), m, and faces (f, 3), normals outward; refuse a surface that is not closed."""
    import trimesh

    mesh = trimesh.Trimesh(np.asarray(vertices, dtype=float), np.asarray(faces), process=False)
    if mesh.volume < 0:
        mesh.invert()
    if not mesh.is_watertight:
        raise UsageError("the sizes give a surface that is not closed", "a solid", "Avoid sizes that nearly vanish.")
    return mesh


def prism_mesh(corners: ArrayLike, length: float) -> trimesh.Trimesh:
    """Return the prism over a polygon (m, 2), m, from z = 0 to ``length``; the origin must see the whole polygon."""
    ring = np.asarray(corners, dtype=float)
    n = len(ring)
    this = np.arange(n)
    following = (this + 1) % n
    bottom = np.column_stack([ring, np.zeros(n)])
    top = np.column_stack([ring, np.full(n, length)])
    vertices = np.concatenate([bottom, top, [[0.0, 0.0, 0.0], [0.0, 0.0, length]]])
    faces = np.concatenate(
        [
            np.column_stack([this, following, following + n]),
            np.column_stack([this, following + n, this + n]),
            np.column_stack([following, this, np.full(n, 2 * n)]),
            np.column_stack([this + n, following + n, np.full(n, 2 * n + 1)]),
        ]
    )
    return sealed(vertices, faces)


def lofted_faces(n_rings: int, sections: int, is_closed: bool = False) -> NDArray[np.int64]:
    """Faces (f, 3) between neighbouring rings of vertices.

    Vertex ``turn`` of a ring has the number ``ring * sections + turn``. Faces point outward where the rings run
    counter-clockwise about z and rise.

    Parameters
    ----------
    n_rings : int
        Number of rings.
    sections : int
        Vertices of each ring.
    is_closed : bool
        Whether the last ring is joined to the first.
    """
    turn = np.arange(sections)
    following = np.roll(turn, -1)
    faces = []
    for ring in range(n_rings if is_closed else n_rings - 1):
        low, high = ring * sections, (ring + 1) % n_rings * sections
        faces.append(np.column_stack([low + turn, low + following, high + following]))
        faces.append(np.column_stack([low + turn, high + following, high + turn]))
    return np.concatenate(faces)


def revolved_mesh(outline: ArrayLike, is_closed: bool = False) -> trimesh.Trimesh:
    """Return the body that an outline of (radius, z) sweeps about the z axis.

    Parameters
    ----------
    outline : (m, 2), m
        Points from axis to axis, bottom to top. Those of a closed outline run counter-clockwise and do not touch the
        axis.
    is_closed : bool
        Whether the outline returns from its last point to its first.
    """
    profile = np.asarray(outline, dtype=float)
    if is_closed:
        return sealed(_rings(profile), lofted_faces(len(profile), SECTIONS, is_closed=True))
    rings = _rings(profile[1:-1])
    # the rings without both ends, which are fans about the axis
    n, turn = len(rings), np.arange(SECTIONS)
    vertices = np.concatenate([rings, [[0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]]])
    bottom = np.column_stack([np.roll(turn, -1), turn, np.full(SECTIONS, n)])
    top = np.column_stack([turn, np.roll(turn, -1), np.full(SECTIONS, n + 1)])
    top[:, :2] += n - SECTIONS
    return sealed(vertices, np.concatenate([bottom, lofted_faces(len(profile) - 2, SECTIONS), top]))


def _rings(profile: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vertices (m * SECTIONS, 3) of the rings that points (m, 2) of (radius, z) sweep about the z axis."""
    around = circle(1.0)
    return np.concatenate([np.column_stack([radius * around, np.full(SECTIONS, z)]) for radius, z in profile])


def circle(radius: float, sections: int = SECTIONS) -> NDArray[np.float64]:
    """Corners (sections, 2) on a circle, in the unit of its radius, counter-clockwise from the x axis."""
    angles = 2 * np.pi * np.arange(sections) / sections
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)

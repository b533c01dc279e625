"""How far each patch of the gel's surface is from an indenter, and which way the indenter faces there."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
from tactiledata.gel.contact.relief import PITCH, IndenterRelief
from tactiledata.gel.mesh.surface import ContactSurface

LEAST_COVER = 0.1
"""Share of a patch that must lie under the indenter for the patch to take part."""
APART = 1.0
"""m: the gap of patches that the indenter does not cover."""


def patch_gaps(
    surface: ContactSurface,
    faces: Indices,
    positions: Array,
    relief: IndenterRelief,
    pose: Array,
    under: NDArray[np.int8],
) -> tuple[Array, Array, Array]:
    """Mean gaps (m,), m, negative where they overlap, unit normals (m, 3) out of the indenter, and covers (m,).

    A patch's cover is the share of it that lies under the indenter; only those points count. Patches of which less
    than ``LEAST_COVER`` is covered, and those outside ``faces``, have the gap ``APART``.

    Parameters
    ----------
    faces : (k,)
        Where to look.
    positions : (s, 3) m
        Surface nodes, displaced, gel frame.
    pose : (4, 4)
        gel_from_indenter.
    under : (k, q) int8
        Whether each point of the faces is under the indenter: 1 or 0, or -1 for those that are to be found out now;
        the answer is written there.
    """
    count = len(surface.patch_areas)
    gaps, covers, normals = np.zeros(count), np.zeros(count), np.zeros((count, 3))
    _gather_gaps(
        faces,
        surface.faces,
        surface.face_corners,
        surface.shapes,
        surface.corner_shapes,
        surface.areas,
        positions,
        relief.origin[0],
        relief.origin[1],
        relief.heights,
        relief.covered,
        np.ascontiguousarray(pose[:3, :3]),
        np.ascontiguousarray(pose[:3, 3]),
        under,
        gaps,
        covers,
        normals,
    )
    shares = covers / surface.patch_areas
    is_covered = shares > LEAST_COVER
    gaps = np.where(is_covered, gaps / np.where(is_covered, covers, 1.0), APART)
    lengths = np.linalg.norm(normals, axis=1)
    normals[lengths > 0] /= lengths[lengths > 0, None]
    normals[lengths == 0] = -pose[:3, 2]
    return gaps, normals, shares


def height_above(positions: Array, relief: IndenterRelief, pose: Array) -> Array:
    """Gaps (n,), m, along the indenter's axis at positions (n, 3), gel frame; ``APART`` where it is not above."""
    inside = (positions - pose[:3, 3]) @ pose[:3, :3]
    i = np.rint((inside[:, 0] - relief.origin[0]) / PITCH).astype(np.int64)
    j = np.rint((inside[:, 1] - relief.origin[1]) / PITCH).astype(np.int64)
    rows, columns = relief.heights.shape
    is_near = (i >= 0) & (i < rows) & (j >= 0) & (j < columns)
    i, j = np.clip(i, 0, rows - 1), np.clip(j, 0, columns - 1)
    return np.where(is_near & relief.covered[i, j], relief.heights[i, j] - inside[:, 2], APART)


@njit(nogil=True, cache=True)
def _gather_gaps(
    looked_at: Indices,
    faces: Indices,
    face_corners: Indices,
    shapes: Array,
    corner_shapes: Array,
    areas: Array,
    positions: Array,
    origin_x: float,
    origin_y: float,
    heights: Array,
    covered: NDArray[np.bool_],
    rotation: Array,
    tip: Array,
    under: NDArray[np.int8],
    gaps: Array,
    covers: Array,
    normals: Array,
) -> None:
    points, nodes = shapes.shape
    corners = corner_shapes.shape[1]
    rows, columns = heights.shape
    for place_of_face, face in enumerate(looked_at):
        for q in range(points):
            if under[place_of_face, q] == 0:
                continue
            x = y = z = 0.0
            for n in range(nodes):
                place = positions[faces[face, n]]
                x += shapes[q, n] * place[0]
                y += shapes[q, n] * place[1]
                z += shapes[q, n] * place[2]
            x -= tip[0]
            y -= tip[1]
            z -= tip[2]
            across = (rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z - origin_x) / PITCH
            along = (rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z - origin_y) / PITCH
            is_near = 0.0 <= across < rows - 1 and 0.0 <= along < columns - 1
            if under[place_of_face, q] < 0:
                is_under = is_near and covered[int(across + 0.5), int(along + 0.5)]
                under[place_of_face, q] = 1 if is_under else 0
                if not is_under:
                    continue
            if not is_near:
                across = min(max(across, 0.0), rows - 1.001)
                along = min(max(along, 0.0), columns - 1.001)
            i, j = int(across), int(along)
            a, b = across - i, along - j
            h00, h10, h01, h11 = heights[i, j], heights[i + 1, j], heights[i, j + 1], heights[i + 1, j + 1]
            height = (1 - a) * ((1 - b) * h00 + b * h01) + a * ((1 - b) * h10 + b * h11)
            slope_x = ((1 - b) * (h10 - h00) + b * (h11 - h01)) / PITCH
            slope_y = ((1 - a) * (h01 - h00) + a * (h11 - h10)) / PITCH
            down = 1.0 / np.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
            depth = rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z
            gap = (height - depth) * down
            n0, n1, n2 = slope_x * down, slope_y * down, -down
            for c in range(corners):
                patch = face_corners[face, c]
                weight = areas[face, q] * corner_shapes[q, c]
                covers[patch] += weight
                gaps[patch] += weight * gap
                for axis in range(3):
                    normals[patch, axis] += weight * (
                        rotation[axis, 0] * n0 + rotation[axis, 1] * n1 + rotation[axis, 2] * n2
                    )

"""Distance of each patch of the gel's surface from an indenter, and the indenter's normal there."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
from tactiledata.gel.contact.relief import PITCH, IndenterRelief
from tactiledata.gel.mesh.surface import ContactSurface

LEAST_COVER = 0.1
"""Smallest share of a patch under the indenter at which the patch can touch."""
APART = 1.0
"""Gap, m, that stands for no contact: that of patches which the indenter does not cover."""


def patch_gaps(
    surface: ContactSurface,
    faces: Indices,
    positions: Array,
    relief: IndenterRelief,
    pose: Array,
    under: NDArray[np.int8],
) -> tuple[Array, Array, Array]:
    """Return mean gaps (m,), m, unit normals (m, 3) out of the indenter, and covers (m,) of all patches.

    Gaps are negative where gel and indenter overlap. A patch's cover is the share of it that lies under the indenter;
    only covered points enter its gap. Patches of which less than ``LEAST_COVER`` is covered, and those outside
    ``faces``, have the gap ``APART``.

    Parameters
    ----------
    surface : ContactSurface
        Faces, patches and integration points.
    faces : (k,)
        Numbers of the faces that are searched.
    positions : (s, 3) m
        Displaced surface nodes, gel frame.
    relief : IndenterRelief
        Underside of the indenter.
    pose : (4, 4)
        gel_from_indenter, metres.
    under : (k, q) int8
        Whether each point of the faces is under the indenter: 1 or 0; a point marked -1 is decided now, and the answer
        is written there.
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
    # from sums over points to means over the covered part of each patch
    shares = covers / surface.patch_areas
    is_covered = shares > LEAST_COVER
    gaps = np.where(is_covered, gaps / np.where(is_covered, covers, 1.0), APART)
    lengths = np.linalg.norm(normals, axis=1)
    normals[lengths > 0] /= lengths[lengths > 0, None]
    normals[lengths == 0] = -pose[:3, 2]
    return gaps, normals, shares


def height_above(positions: Array, relief: IndenterRelief, pose: Array) -> Array:
    """Distance (n,), m, from positions (n, 3), gel frame, up to the indenter along its axis.

    It is negative inside the indenter, and ``APART`` where the indenter is not above.

    Parameters
    ----------
    positions : (n, 3) m
        Points in the gel frame.
    relief : IndenterRelief
        Underside of the indenter.
    pose : (4, 4)
        gel_from_indenter, metres.
    """
    local = (positions - pose[:3, 3]) @ pose[:3, :3]
    i = np.rint((local[:, 0] - relief.origin[0]) / PITCH).astype(np.int64)
    j = np.rint((local[:, 1] - relief.origin[1]) / PITCH).astype(np.int64)
    rows, columns = relief.heights.shape
    is_near = (i >= 0) & (i < rows) & (j >= 0) & (j < columns)
    i, j = np.clip(i, 0, rows - 1), np.clip(j, 0, columns - 1)
    return np.where(is_near & relief.covered[i, j], relief.heights[i, j] - local[:, 2], APART)


@njit(nogil=True, cache=True)
def _gather_gaps(
    searched: Indices,
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
    origin: Array,
    under: NDArray[np.int8],
    gaps: Array,
    covers: Array,
    normals: Array,
) -> None:
    """Add area, area times gap and area times normal of each covered point to the patches of its face."""
    points, nodes = shapes.shape
    corners = corner_shapes.shape[1]
    rows, columns = heights.shape
    local = np.empty((nodes, 3))
    normal = np.empty(3)
    for row, face in enumerate(searched):
        # the nodes of the face in the indenter's frame
        for n in range(nodes):
            position = positions[faces[face, n]]
            for axis in range(3):
                local[n, axis] = (
                    rotation[0, axis] * (position[0] - origin[0])
                    + rotation[1, axis] * (position[1] - origin[1])
                    + rotation[2, axis] * (position[2] - origin[2])
                )
        for q in range(points):
            if under[row, q] == 0:
                continue
            # the point, in units of the relief's grid
            across = along = depth = 0.0
            for n in range(nodes):
                across += shapes[q, n] * local[n, 0]
                along += shapes[q, n] * local[n, 1]
                depth += shapes[q, n] * local[n, 2]
            across = (across - origin_x) / PITCH
            along = (along - origin_y) / PITCH
            is_near = 0.0 <= across < rows - 1 and 0.0 <= along < columns - 1
            if under[row, q] < 0:
                is_under = is_near and covered[int(across + 0.5), int(along + 0.5)]
                under[row, q] = 1 if is_under else 0
                if not is_under:
                    continue
            if not is_near:
                across = min(max(across, 0.0), rows - 1.001)
                along = min(max(along, 0.0), columns - 1.001)
            i, j = int(across), int(along)
            a, b = across - i, along - j
            # height and slope of the relief, bilinear
            h00, h10, h01, h11 = heights[i, j], heights[i + 1, j], heights[i, j + 1], heights[i + 1, j + 1]
            height = (1 - a) * ((1 - b) * h00 + b * h01) + a * ((1 - b) * h10 + b * h11)
            slope_x = ((1 - b) * (h10 - h00) + b * (h11 - h01)) / PITCH
            slope_y = ((1 - a) * (h01 - h00) + a * (h11 - h10)) / PITCH
            down = 1.0 / np.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
            gap = (height - depth) * down
            for axis in range(3):
                normal[axis] = (rotation[axis, 0] * slope_x + rotation[axis, 1] * slope_y - rotation[axis, 2]) * down
            for c in range(corners):
                patch = face_corners[face, c]
                weight = areas[face, q] * corner_shapes[q, c]
                covers[patch] += weight
                gaps[patch] += weight * gap
                for axis in range(3):
                    normals[patch, axis] += weight * normal[axis]

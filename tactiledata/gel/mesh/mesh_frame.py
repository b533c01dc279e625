"""Orientation of a pad from a file: its flat base, and the longer side of its outline."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from tactiledata.arrays import Array
from tactiledata.errors import SchemaError, UsageError
from tactiledata.gel.mesh.pad import Indices

AXES = {f"{sign}{name}": float(f"{sign}1") * np.eye(3)[row] for row, name in enumerate("xyz") for sign in "+-"}
CANDIDATES = 300
"""Number of faces, the largest ones, whose planes are tried as the base."""
FLAT = 2e-4
"""Largest distance of a flat patch from its plane, as a share of the pad's longest side."""
LEAST_BASE = 0.15
"""Smallest share of the boundary's area that a base has; that of a slab is nearly half."""
END = 0.1
"""Share of the length, at each end, in which the width is measured."""


def gel_axes(points: Array, faces: Indices, out: str | None, along: str | None, where: str) -> Array:
    """Return the rotation (3, 3) into the gel frame: rows are the gel's x, y and z axes in the file's frame.

    Parameters
    ----------
    points : (v, 3)
        Nodes in the file's frame.
    faces : (f, 3)
        Faces of the boundary, outward.
    out, along : str or None
        Keys of ``AXES`` that become +z and +y; ``None`` derives them from the shape.
    where : str
        Name of the file, for messages.

    Raises
    ------
    SchemaError
        No flat patch is large enough to be the base.
    UsageError
        An unknown axis, or two axes that are not at right angles.
    """
    z = _base_normal(points, faces, where) if out is None else _axis(out)
    y = _long_side(points, z) if along is None else _axis(along)
    if abs(float(y @ z)) > 1e-3:
        raise UsageError(
            f"out {out} and along {along}", "two axes at right angles", "out leads out of the gel, along its length."
        )
    y = y - (y @ z) * z
    y /= np.linalg.norm(y)
    return np.stack([np.cross(y, z), y, z])


def _axis(name: str) -> Array:
    """Unit vector (3,) of an axis such as "-y"; refuse another name."""
    if name not in AXES:
        raise UsageError(f"axis {name!r}", f"one of {', '.join(AXES)}", "")
    return AXES[name]


def _base_normal(points: Array, faces: Indices, where: str) -> Array:
    """Unit normal (3,) of the largest flat patch of the boundary, pointing into the pad; refuse a small one."""
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(areas, 1e-300)[:, None]
    size = np.ptp(points, axis=0).max()
    best, largest_area = normals[0], 0.0
    for face in np.argsort(areas)[: -CANDIDATES - 1 : -1]:
        is_on = (np.abs((corners - corners[face, 0]) @ normals[face]) < FLAT * size).all(axis=1)
        area = float(areas[is_on].sum())
        if area > largest_area:
            # the mean normal of the patch is more exact than that of one face
            best, largest_area = (areas[is_on, None] * normals[is_on]).sum(axis=0), area
    if largest_area < LEAST_BASE * areas.sum():
        raise SchemaError(
            f"the largest flat patch of {where} is {100 * largest_area / areas.sum():.0f} % of its boundary",
            f"a flat base of at least {100 * LEAST_BASE:.0f} %",
            "State which way is out: out='-y', along='-x', for example.",
        )
    return -best / np.linalg.norm(best)


def _long_side(points: Array, z: Array) -> Array:
    """Unit vector (3,) along the longer side of the smallest rectangle around the outline, to the narrower end."""
    u = np.cross(z, AXES["+x"] if abs(z[0]) < 0.9 else AXES["+y"])
    u /= np.linalg.norm(u)
    plane = np.stack([u, np.cross(z, u)])
    outline = points @ plane.T
    outline = outline[ConvexHull(outline).vertices]
    # the smallest rectangle has a side along one side of the convex outline
    sides = np.roll(outline, -1, axis=0) - outline
    directions = sides / np.linalg.norm(sides, axis=1)[:, None]
    across = np.stack([-directions[:, 1], directions[:, 0]], axis=1)
    lengths, widths = np.ptp(outline @ directions.T, axis=0), np.ptp(outline @ across.T, axis=0)
    best = int(np.argmin(lengths * widths))
    long, wide = (directions, across) if lengths[best] >= widths[best] else (across, directions)
    place, side = (points @ plane.T) @ long[best], (points @ plane.T) @ wide[best]
    # compare the widths of both ends
    share = (place - place.min()) / np.ptp(place)
    sign = 1.0 if np.ptp(side[share > 1 - END]) <= np.ptp(side[share < END]) else -1.0
    direction: Array = sign * long[best] @ plane
    return direction

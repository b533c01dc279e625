"""Which way a pad from a file lies: its flat base, and the longer side of its outline."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from tactiledata.arrays import Array
from tactiledata.errors import SchemaError, UsageError
from tactiledata.gel.mesh.pad import Indices

AXES = {f"{sign}{name}": float(f"{sign}1") * np.eye(3)[row] for row, name in enumerate("xyz") for sign in "+-"}
CANDIDATES = 300
"""Of the largest faces, planes that may be the base."""
FLAT = 2e-4
"""Share of the pad's longest side that a flat patch may deviate from its plane."""
LEAST_BASE = 0.15
"""Share of the boundary that the base has at least; a slab's is nearly half."""
END = 0.1
"""Share of the length in which an end's width is looked at."""


def gel_axes(points: Array, faces: Indices, out: str | None, along: str | None, where: str) -> Array:
    """Rotation (3, 3) into the gel's axes: rows are x, y and z of the gel frame in the file's.

    Raises
    ------
    SchemaError
        No flat patch that could be the base.
    UsageError
        Axes that do not exist, or that are not at right angles.
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
    if name not in AXES:
        raise UsageError(f"axis {name!r}", f"one of {', '.join(AXES)}", "")
    return AXES[name]


def _base_normal(points: Array, faces: Indices, where: str) -> Array:
    """Out of the base into the pad."""
    corners = points[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    normals /= np.maximum(areas, 1e-300)[:, None]
    size = np.ptp(points, axis=0).max()
    best, most = normals[0], 0.0
    for face in np.argsort(areas)[: -CANDIDATES - 1 : -1]:
        is_on = (np.abs((corners - corners[face, 0]) @ normals[face]) < FLAT * size).all(axis=1)
        area = float(areas[is_on].sum())
        if area > most:
            # what all of its faces say together is better than what one does
            best, most = (areas[is_on, None] * normals[is_on]).sum(axis=0), area
    if most < LEAST_BASE * areas.sum():
        raise SchemaError(
            f"the largest flat patch of {where} is {100 * most / areas.sum():.0f} % of its boundary",
            f"a flat base of at least {100 * LEAST_BASE:.0f} %",
            "State which way is out: out='-y', along='-x', for example.",
        )
    return -best / np.linalg.norm(best)


def _long_side(points: Array, z: Array) -> Array:
    """Along the longer side of the smallest rectangle around the outline, towards the narrower end."""
    u = np.cross(z, AXES["+x"] if abs(z[0]) < 0.9 else AXES["+y"])
    u /= np.linalg.norm(u)
    plane = np.stack([u, np.cross(z, u)])
    outline = points @ plane.T
    outline = outline[ConvexHull(outline).vertices]
    sides = np.roll(outline, -1, axis=0) - outline
    directions = sides / np.linalg.norm(sides, axis=1)[:, None]
    across = np.stack([-directions[:, 1], directions[:, 0]], axis=1)
    lengths, widths = np.ptp(outline @ directions.T, axis=0), np.ptp(outline @ across.T, axis=0)
    best = int(np.argmin(lengths * widths))
    long, wide = (directions, across) if lengths[best] >= widths[best] else (across, directions)
    place, side = (points @ plane.T) @ long[best], (points @ plane.T) @ wide[best]
    share = (place - place.min()) / np.ptp(place)
    towards = 1.0 if np.ptp(side[share > 1 - END]) <= np.ptp(side[share < END]) else -1.0
    direction: Array = towards * long[best] @ plane
    return direction

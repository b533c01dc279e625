"""Exact signed distances to plane figures, and to the solids that they sweep."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from tactiledata.arrays import Array


def polygon_distance(points: Array, corners: ArrayLike) -> Array:
    """Signed distances (n,) of points (n, 2) to a simple polygon (m, 2), negative inside; exact on both sides.

    Examples
    --------
    >>> polygon_distance(np.array([[0.0, 0.0], [3.0, 0.0]]), [[-1, -1], [1, -1], [1, 1], [-1, 1]]).tolist()
    [-1.0, 2.0]
    """
    ends = np.asarray(corners, dtype=float)
    squared = np.full(len(points), np.inf)
    is_inside = np.zeros(len(points), dtype=bool)
    # edge by edge: few edges, many points, so that memory stays at one column
    for start, end in zip(ends, np.roll(ends, -1, axis=0), strict=True):
        edge = end - start
        to_point = points - start
        along = np.clip(to_point @ edge / (edge @ edge), 0.0, 1.0)
        squared = np.minimum(squared, ((to_point - along[:, None] * edge) ** 2).sum(axis=1))
        crosses = (start[1] <= points[:, 1]) != (end[1] <= points[:, 1])
        side = edge[0] * to_point[:, 1] - edge[1] * to_point[:, 0]
        is_inside ^= crosses & ((side > 0) == (edge[1] > 0))
    return np.where(is_inside, -1.0, 1.0) * np.sqrt(squared)


def swept_distance(section: Array, along: Array, half_length: float) -> Array:
    """Signed distances (n,) to a prism: a figure swept along the normal of its plane, both ends flat.

    Exact wherever ``section`` is, inside and outside.

    Parameters
    ----------
    section : (n,)
        Signed distance to the figure in its plane.
    along : (n,)
        Coordinate along the sweep, from the middle of the prism, in the same unit.
    half_length : float
        Half the length of the prism, in the same unit.
    """
    cap = np.abs(along) - half_length
    outside = np.hypot(np.maximum(section, 0.0), np.maximum(cap, 0.0))
    return np.minimum(np.maximum(section, cap), 0.0) + outside


def radius_of(points: Array) -> Array:
    """Distances (n,), m, of points (n, 3), m, from the z axis."""
    return np.hypot(points[:, 0], points[:, 1])


def rounded_wedge(half_angle: float, tip_radius: float, top: float) -> tuple[Array, float]:
    """Return the core triangle (3, 2), m, of a wedge with rounded corners, tip down at the origin, and half its width.

    The figure is the triangle grown by ``tip_radius``: convex, so ``polygon_distance(...) - tip_radius`` is exact on
    both sides. Coordinates are (across, z); the figure spans z from 0 to ``top``.

    Parameters
    ----------
    half_angle : float
        Angle between axis and flank, rad.
    tip_radius : float
        Radius of the three corners, m.
    top : float
        Height of the figure, m.
    """
    half_width = (top - 2.0 * tip_radius) * np.tan(half_angle)
    core = np.array([[0.0, tip_radius], [half_width, top - tip_radius], [-half_width, top - tip_radius]])
    return core, float(half_width)


def rounded_wedge_height(across: Array, half_angle: float, tip_radius: float, top: float) -> Array:
    """Lowest z, m, of the rounded wedge at distances from its middle; ``inf`` beyond it.

    Parameters
    ----------
    across : array, m
        Distances from the middle, not negative.
    half_angle, tip_radius, top : float
        As in `rounded_wedge`.
    """
    # three pieces: the arc of the tip, the flank, the arc of the rim
    _, half_width = rounded_wedge(half_angle, tip_radius, top)
    flank_start = tip_radius * np.cos(half_angle)
    flank = tip_radius * (1.0 - np.sin(half_angle)) + (across - flank_start) / np.tan(half_angle)
    tip = tip_radius - np.sqrt(np.maximum(tip_radius**2 - across**2, 0.0))
    rim = (top - tip_radius) - np.sqrt(np.maximum(tip_radius**2 - (across - half_width) ** 2, 0.0))
    lower = np.where(across < flank_start, tip, np.where(across < half_width + flank_start, flank, rim))
    return np.where(across <= half_width + tip_radius, lower, np.inf)


def rounded_wedge_outline(half_angle: float, tip_radius: float, top: float, arc_points: int) -> Array:
    """Points (m, 2), m, along the right half of the rounded wedge, from the tip to the middle of its top.

    Parameters
    ----------
    half_angle, tip_radius, top : float
        As in `rounded_wedge`.
    arc_points : int
        Points on the arc of the tip; the arc of the rim has three times as many.
    """
    core, _ = rounded_wedge(half_angle, tip_radius, top)
    # directions of the outward normal, from straight down at the tip to straight up at the top
    tip_arc = np.linspace(-np.pi / 2, -half_angle, arc_points)
    rim_arc = np.linspace(-half_angle, np.pi / 2, 3 * arc_points)
    tip = core[0] + tip_radius * np.stack([np.cos(tip_arc), np.sin(tip_arc)], axis=1)
    rim = core[1] + tip_radius * np.stack([np.cos(rim_arc), np.sin(rim_arc)], axis=1)
    outline = np.concatenate([tip, rim, [[0.0, top]]])
    outline[0, 0] = 0.0
    return outline

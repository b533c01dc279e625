"""Rigid indenters as distances: how far a point is from the body, and the direction away from it, in mm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from element_world.pad import Array

Distance = Callable[[Array], Array]
"""Function that gives signed distances (n,), negative inside, of points (n, 3) in the indenter's frame, both mm."""
NEARBY = 1e-4
"""Distance, mm, over which a direction is found by differences."""


def _box(points: Array, half: tuple[float, ...]) -> Array:
    """Return the distance of points (n, k) from a box of half sides (k,) about the origin."""
    beyond = np.abs(points) - half
    outside = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=1))
    return outside + np.minimum(beyond.max(axis=1), 0.0)


def _ball(radius: float) -> Distance:
    return lambda p: np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2 + (p[:, 2] - radius) ** 2) - radius


def _standing(radius: float, length: float) -> Distance:
    def distance(p: Array) -> Array:
        around = np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2)
        return _box(np.column_stack([around, p[:, 2] - 0.5 * length]), (radius, 0.5 * length))

    return distance


def _lying(radius: float, width: float) -> Distance:
    def distance(p: Array) -> Array:
        around = np.sqrt(p[:, 1] ** 2 + (p[:, 2] - radius) ** 2)
        return _box(np.column_stack([around, p[:, 0]]), (radius, 0.5 * width))

    return distance


def _brick(width: float, breadth: float, length: float) -> Distance:
    return lambda p: _box(p - [0.0, 0.0, 0.5 * length], (0.5 * width, 0.5 * breadth, 0.5 * length))


def _cone(half_angle: float, tip_radius: float, length: float) -> Distance:
    """Return the distance of a sharp cone, tip down, that is swollen by the tip's radius.

    Its upper rim is far above every gel: there the cone ends in a plane.
    """
    sine, cosine = np.sin(half_angle), np.cos(half_angle)

    def distance(p: Array) -> Array:
        around, over = np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2), p[:, 2] - tip_radius
        along = around * sine + over * cosine
        flank = around * cosine - over * sine
        core = np.where(along < 0.0, np.sqrt(around**2 + over**2), flank)
        return np.maximum(core - tip_radius, p[:, 2] - length)

    return distance


def _dome(curvature_radius: float, radius: float, length: float) -> Distance:
    """Return the larger of the distances of a ball and of a cylinder, which is exact but beside the rim."""
    ball, rod = _ball(curvature_radius), _standing(radius, length)

    def distance(p: Array) -> Array:
        above = p[:, 2] > curvature_radius
        return np.maximum(np.where(above, -np.inf, ball(p)), rod(p))

    return distance


BODIES: dict[str, tuple[Callable[..., Distance], dict[str, float]]] = {
    "sphere": (_ball, {"radius": 4.0}),
    "cylinder_flat": (_standing, {"radius": 3.0, "length": 10.0}),
    "cylinder_side": (_lying, {"radius": 3.0, "width": 10.0}),
    "box": (_brick, {"width": 8.0, "breadth": 8.0, "length": 8.0}),
    "cone": (_cone, {"half_angle": 0.7, "tip_radius": 0.5, "length": 8.0}),
    "dome": (_dome, {"curvature_radius": 10.0, "radius": 5.0, "length": 10.0}),
}
"""Shapes with their usual sizes: mm, and rad for an angle."""


def body_of(shape: str, sizes: Mapping[str, Any]) -> Distance:
    """Return the distance from a shape, tip at the origin and body above it, of sizes in m and rad."""
    if shape not in BODIES:
        raise ValueError(f"an indenter of shape {shape!r}; this generator knows {', '.join(BODIES)}")
    make, usual = BODIES[shape]
    given = {name: float(sizes[name]) * (1.0 if name == "half_angle" else 1e3) for name in usual if name in sizes}
    return make(**{**usual, **given})


def directions(distance: Distance, points: Array, at: Array) -> Array:
    """Return the directions (n, 3) away from a body at points (n, 3), mm, whose distances are ``at`` (n,)."""
    found = np.empty_like(points)
    for axis in range(3):
        beside = points.copy()
        beside[:, axis] += NEARBY
        found[:, axis] = distance(beside) - at
    return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-12)

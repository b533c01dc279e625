"""Rigid indenters as distances: how far a point is from the body, and the direction away from it, in mm."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactiledata.prove.element_world.pad import Array

Distance = Callable[[Array], Array]
"""Function that gives signed distances (n,), negative inside, of points (n, 3) in the indenter's frame, both mm."""
RIM = 0.15
"""Width, mm, of the rim of a flat face over which its springs grow from nothing.

The gel that springs let into a sharp body at its rim is pressed by the face, never by the wall, which would plough.
"""
NEARBY = 1e-4
"""Distance, mm, over which a direction is found by differences."""


def _pressing(face: Array, wall: Array) -> Array:
    """Return distances (n,) from a body with a face and a side wall, given those from each without the other.

    Inside, the depth below the face counts, and fades towards the wall.
    """
    outside = np.sqrt(np.maximum(face, 0.0) ** 2 + np.maximum(wall, 0.0) ** 2)
    share = np.clip(-wall / RIM, 0.0, 1.0)
    return outside + np.minimum(face, 0.0) * share * share * (3.0 - 2.0 * share)


def _ball(radius: float) -> Distance:
    return lambda p: np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2 + (p[:, 2] - radius) ** 2) - radius


def _standing(radius: float) -> Distance:
    return lambda p: _pressing(-p[:, 2], np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2) - radius)


def _lying(radius: float, width: float) -> Distance:
    around = _around(radius)
    return lambda p: _pressing(around(p), np.abs(p[:, 0]) - 0.5 * width)


def _around(radius: float) -> Distance:
    return lambda p: np.sqrt(p[:, 1] ** 2 + (p[:, 2] - radius) ** 2) - radius


def _brick(width: float, breadth: float) -> Distance:
    half = (0.5 * width, 0.5 * breadth)

    def distance(p: Array) -> Array:
        beyond = np.abs(p[:, :2]) - half
        wall = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=1)) + np.minimum(beyond.max(axis=1), 0.0)
        return _pressing(-p[:, 2], wall)

    return distance


def _cone(half_angle: float, tip_radius: float) -> Distance:
    """Return the distance of an endless sharp cone, tip down, that is swollen by the tip's radius."""
    sine, cosine = np.sin(half_angle), np.cos(half_angle)

    def distance(p: Array) -> Array:
        around, over = np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2), p[:, 2] - tip_radius
        along = around * sine + over * cosine
        flank = around * cosine - over * sine
        return np.where(along < 0.0, np.sqrt(around**2 + over**2), flank) - tip_radius

    return distance


def _dome(curvature_radius: float, radius: float) -> Distance:
    ball = _ball(curvature_radius)
    return lambda p: _pressing(ball(p), np.sqrt(p[:, 0] ** 2 + p[:, 1] ** 2) - radius)


@dataclass(frozen=True)
class RigidBody:
    """A rigid indenter: the lower part of it, which is all that a gel meets.

    Parameters
    ----------
    distance : callable
        From the body.
    face : callable
        Distance from a body without side walls: what presses is its face.
    """

    distance: Distance
    face: Distance

    def directions(self, points: Array, at: Array) -> tuple[Array, Array]:
        """Return how distances grow (n, 3), and the directions (n, 3) in which points are pressed.

        Parameters
        ----------
        points : (n, 3), mm
            In the indenter's frame.
        at : (n,), mm
            Their distances from the body.
        """
        push = _growth(self.face, points, self.face(points))
        push /= np.maximum(np.linalg.norm(push, axis=1, keepdims=True), 1e-12)
        return _growth(self.distance, points, at), push


def _flat(p: Array) -> Array:
    """Return the distances (n,) from the half space above the tip."""
    return -p[:, 2]


_MAKERS: dict[str, Callable[..., RigidBody]] = {
    "sphere": lambda radius: RigidBody(_ball(radius), _ball(radius)),
    "cylinder_flat": lambda radius: RigidBody(_standing(radius), _flat),
    "cylinder_side": lambda radius, width: RigidBody(_lying(radius, width), _around(radius)),
    "box": lambda width, breadth: RigidBody(_brick(width, breadth), _flat),
    "cone": lambda half_angle, tip_radius: RigidBody(_cone(half_angle, tip_radius), _cone(half_angle, tip_radius)),
    "dome": lambda curvature_radius, radius: RigidBody(_dome(curvature_radius, radius), _ball(curvature_radius)),
}
BODIES: dict[str, dict[str, float]] = {
    "sphere": {"radius": 4.0},
    "cylinder_flat": {"radius": 3.0},
    "cylinder_side": {"radius": 3.0, "width": 10.0},
    "box": {"width": 8.0, "breadth": 8.0},
    "cone": {"half_angle": 0.7, "tip_radius": 0.5},
    "dome": {"curvature_radius": 10.0, "radius": 5.0},
}
"""Shapes with the sizes that count and their usual values: mm, and rad for an angle."""


def body_of(shape: str, sizes: Mapping[str, Any]) -> RigidBody:
    """Return a body of a shape, tip at the origin and body above it, of sizes in m and rad."""
    if shape not in BODIES:
        raise ValueError(f"an indenter of shape {shape!r}; this generator knows {', '.join(BODIES)}")
    usual = BODIES[shape]
    given = {name: float(sizes[name]) * (1.0 if name == "half_angle" else 1e3) for name in usual if name in sizes}
    return _MAKERS[shape](**{**usual, **given})


def _growth(distance: Distance, points: Array, at: Array) -> Array:
    """Return the gradient (n, 3) of a distance at points (n, 3), mm, where it is ``at`` (n,)."""
    found = np.empty_like(points)
    for axis in range(3):
        beside = points.copy()
        beside[:, axis] += NEARBY
        found[:, axis] = (distance(beside) - at) / NEARBY
    return found

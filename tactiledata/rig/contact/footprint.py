"""The rigid side of a contact: the height of a turned indenter over each point of the gel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.indenters.base import Indenter
from tactiledata.rig.scenario.scenario import Gel

PITCH = 8e-5
"""Spacing of the grid, m; about a pixel and a half of the picture."""
MARGIN = 2e-3
"""Width of the grid beyond the pad on each side, m: a sheared footprint slides in from there."""
CEILING = 3e-3
"""Largest height over the lowest point that is computed, m: no press is that deep."""
HIT = 1e-6
"""Distance to the body, m, below which a ray has met it."""
MAX_MARCHES = 60
"""Largest number of steps of a ray."""
BELOW = 5e-5
"""Distance below the lowest corner of the mesh at which rays start, m: meshes of round bodies lie inside them."""
COARSE = 4
"""Stride of the rays that are traced first, to give their neighbours a start."""


@dataclass(frozen=True)
class GelGrid:
    """A grid over the pad's undeformed surface and 2 mm beyond it: x (n_x,) and y (n_y,), metres, gel frame.

    Maps on it are (n_y, n_x); ``on_pad`` masks the points of the pad itself.
    """

    x: RealArray
    y: RealArray
    outline: tuple[float, float]

    @classmethod
    def of(cls, gel: Gel) -> GelGrid:
        """Return the grid of a pad, symmetric about the gel's origin."""
        half = [round((side / 2 + MARGIN) / PITCH) for side in gel.outline]
        return cls(np.arange(-half[0], half[0] + 1) * PITCH, np.arange(-half[1], half[1] + 1) * PITCH, gel.outline)

    @property
    def on_pad(self) -> NDArray[np.bool_]:
        """Mask (n_y, n_x) of the points that belong to the pad."""
        return (np.abs(self.y) <= self.outline[1] / 2)[:, None] & (np.abs(self.x) <= self.outline[0] / 2)


@dataclass(frozen=True)
class Footprint:
    """An indenter over the gel, turned but not yet pressed.

    Parameters
    ----------
    grid : GelGrid
        Points of the gel.
    heights : (n_y, n_x), metres
        Gap between the body and a plane through its lowest point, at ``position``; at most ``CEILING``.
    position : (2,), metres
        Place of the indenter's tip over the gel.
    lowest : metres
        Height of the lowest point over the tip, along gel z; at most 0.
    """

    grid: GelGrid
    heights: RealArray
    position: tuple[float, float]
    lowest: float


def make_footprint(indenter: Indenter, rotation: RealArray, position: tuple[float, float], grid: GelGrid) -> Footprint:
    """Return the footprint of a turned indenter over the gel.

    Parameters
    ----------
    indenter : Indenter
        The body.
    rotation : (3, 3)
        Orientation of the indenter, gel_from_indenter.
    position : (2,), metres
        Place of the indenter's tip over the gel.
    grid : GelGrid
        Points of the gel.
    """
    x, y = np.meshgrid(grid.x - position[0], grid.y - position[1])
    heights: RealArray
    if rotation[2, 2] > 1.0 - 1e-12:
        # head-on: turned about the common axis only
        heights = indenter.height(rotation[0, 0] * x + rotation[1, 0] * y, rotation[0, 1] * x + rotation[1, 1] * y)
        lowest = 0.0
    else:
        corner = float((np.asarray(indenter.mesh().vertices) @ rotation[2]).min())
        heights = _march(indenter, rotation, x, y, corner - BELOW)
        # a mesh lies a little inside a round body and has the corners that the grid misses
        lowest = min(corner, float(heights.min()))
    return Footprint(grid, np.clip(heights - lowest, 0.0, CEILING), position, lowest)


def moved_heights(footprint: Footprint, offset: tuple[float, float]) -> NDArray[np.float32]:
    """Return the heights (n_y, n_x), m, with the indenter moved by ``offset`` (2,), m, over the gel."""
    return shifted(
        footprint.heights.astype(np.float32),
        offset,
        float(footprint.grid.x[1] - footprint.grid.x[0]),
    )


def shifted(values: NDArray[Any], offset: tuple[float, float], pitch: float) -> NDArray[Any]:
    """Return a map moved over its grid; its edge values fill the rim that comes in.

    Parameters
    ----------
    values : (n_y, n_x), float32
        The map.
    offset : (2,), metres
        Move along x and y.
    pitch : metres
        Spacing of the grid.
    """
    if not any(offset):
        return values
    move = np.array([[1, 0, offset[0] / pitch], [0, 1, offset[1] / pitch]], dtype=np.float32)
    size = (values.shape[1], values.shape[0])
    return cv2.warpAffine(values, move, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _march(indenter: Indenter, rotation: RealArray, x: RealArray, y: RealArray, lowest: float) -> RealArray:
    """Return the lowest z (n_y, n_x), m, of the turned body above each point, by sphere tracing; ``inf`` where none.

    Every ``COARSE``-th ray is first traced to where its neighbours could meet the body; they start from there.
    """
    reach = COARSE * PITCH / np.sqrt(2.0)
    rows, columns = (np.append(np.arange(0, size, COARSE), size - 1) for size in x.shape)
    few = np.ix_(rows, columns)
    safe = _trace(indenter, rotation, x[few].ravel(), y[few].ravel(), np.full(x[few].size, lowest), lowest, reach)
    safe = safe.reshape(x[few].shape)
    pairs = zip(x.shape, (rows, columns), strict=True)
    nearest = [np.abs(np.arange(size)[:, None] - kept).argmin(axis=1) for size, kept in pairs]
    start = safe[np.ix_(*nearest)].ravel()
    heights = np.full(x.size, np.inf)
    near = np.flatnonzero(np.isfinite(start))
    heights[near] = _trace(indenter, rotation, x.ravel()[near], y.ravel()[near], start[near], lowest, HIT)
    return heights.reshape(x.shape)


def _trace(
    indenter: Indenter, rotation: RealArray, x: RealArray, y: RealArray, start: RealArray, lowest: float, reach: float
) -> RealArray:
    """Return the height (n,), m, at which each ray is first within ``reach`` of the body; ``inf`` where it never is.

    Rays run along gel z from heights ``start`` (n,) over places x, y (n,), m.
    """
    heights = np.full(len(x), np.inf)
    alive = np.arange(len(x))
    points = np.stack([x, y, start], axis=1)
    for _ in range(MAX_MARCHES):
        # row vectors: p_indenter = rotationᵀ p_gel
        distance = indenter.signed_distance(points @ rotation)
        hit = distance < reach
        heights[alive[hit]] = points[hit, 2]
        points[:, 2] += np.maximum(distance - reach, 0.0) + HIT
        keep = ~hit & (points[:, 2] < lowest + CEILING)
        alive, points = alive[keep], points[keep]
        if not len(alive):
            break
    # rays that still graze the body run along a wall: where they are is close enough
    heights[alive] = points[:, 2]
    return heights

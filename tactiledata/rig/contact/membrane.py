"""The shape of the gel's outer surface in a contact: the indenter's shape inside it, a smooth bed around it."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.contact.footprint import Footprint, moved_heights, shifted

Map = NDArray[Any]
"""A float32 map; OpenCV's annotations do not state the type."""

COARSE = 2
"""Stride of the grid's points on which the smooth parts are computed."""
REACH = (4.5e-4, 1.4e-3)
"""Standard deviations, m, of the two Gaussians that model the decay of the bed around a contact."""
REACH_SHARE = (0.62, 0.34)
"""Weights of the two Gaussians; their sum is below 1, so that the bed stays under a flat face."""
PILE_UP_REACH = 2.8e-3
"""Standard deviation, m, of the wide Gaussian by which displaced gel piles up around a contact."""
PILE_UP = 0.3
"""Share of the displaced volume that piles up."""
DRAG_LIFT = 0.3
"""Height of the bulge before and the hollow behind a dragged contact, over thickness times divergence of the drag."""
CREASE = 1.2e-5
"""Length, m, over which the bed joins the indenter."""


def surface(
    footprint: Footprint, offset: tuple[float, float], depth: float, drag: tuple[float, float], h: float
) -> Map:
    """Return the height (n_y, n_x), metres, gel z, of the deformed surface at the points of the footprint's grid.

    It is 0 where the gel is at rest, negative where the gel is pressed in, and positive where displaced gel piles up.

    Parameters
    ----------
    footprint : Footprint
        The turned indenter over the gel, and the grid of points.
    offset : (2,), metres
        Move of the indenter over the gel since the footprint was taken.
    depth : metres
        Depth of the indenter's lowest point below the undeformed surface; zero or less gives a flat surface.
    drag : (2,), metres
        Displacement of the surface by friction.
    h : metres
        The gel's thickness.
    """
    grid = footprint.grid
    shape = (len(grid.y), len(grid.x))
    if depth <= 0:
        return np.zeros(shape, np.float32)
    pitch = float(grid.x[1] - grid.x[0])
    sink = np.float32(depth) - moved_heights(footprint, offset)
    # the bed around the contact, on a coarser grid
    small = (shape[1] // COARSE, shape[0] // COARSE)
    pressed = cv2.resize(np.maximum(sink, 0.0), small, interpolation=cv2.INTER_AREA)
    bells = [cv2.GaussianBlur(pressed, (0, 0), reach / (pitch * COARSE)) for reach in REACH]
    bed = REACH_SHARE[0] * bells[0] + REACH_SHARE[1] * bells[1]
    bed -= PILE_UP * _wide_bell(pressed, PILE_UP_REACH / (pitch * COARSE))
    if any(drag):
        bed = _dragged(bed, bells[1], drag, depth, h, pitch * COARSE)
    bed = cv2.resize(bed, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
    # a smooth maximum: the indenter where it is deeper than the bed
    gap = sink - bed
    return -0.5 * (sink + bed + cv2.sqrt(gap * gap + np.float32(CREASE**2)))


def _wide_bell(pressed: Map, sigma: float) -> Map:
    """Return a map blurred by a wide Gaussian; on every fourth point, since the result has no fine detail."""
    tiny = cv2.resize(pressed, (pressed.shape[1] // 4, pressed.shape[0] // 4), interpolation=cv2.INTER_AREA)
    return cv2.resize(cv2.GaussianBlur(tiny, (0, 0), sigma / 4), pressed.shape[::-1], interpolation=cv2.INTER_LINEAR)


def _dragged(bed: Map, bell: Map, drag: tuple[float, float], depth: float, h: float, pitch: float) -> Map:
    """Return the bed, moved along by friction, raised before the contact and hollow behind it."""
    share = bell / max(float(bell.max()), 1e-12)
    moved = shifted(bed, drag, pitch)
    carried = bed + share * (moved - bed)
    slope_x = cv2.Sobel(share, cv2.CV_32F, 1, 0, ksize=3, scale=1 / (8 * pitch))
    slope_y = cv2.Sobel(share, cv2.CV_32F, 0, 1, ksize=3, scale=1 / (8 * pitch))
    # the layer keeps its volume: where the drag converges, the surface rises (the bed is counted downwards)
    return carried + np.float32(DRAG_LIFT * h) * (np.float32(drag[0]) * slope_x + np.float32(drag[1]) * slope_y)

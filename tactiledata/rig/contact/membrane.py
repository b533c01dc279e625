"""The shape of the gel's outer surface in a contact: the indenter's inside it, a smooth bed around it."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.contact.footprint import Footprint, moved_heights, shifted

Map = NDArray[Any]
"""float32; OpenCV's annotations say less."""

COARSE = 2
"""The smooth parts are computed on every second point of the grid."""
REACH = (4.5e-4, 1.4e-3)
"""m: standard deviations of the two bells that stand in for the decay of the bed around a contact."""
REACH_SHARE = (0.62, 0.34)
"""Their shares; below 1 together, so that the bed stays under a flat face."""
PILE_UP_REACH = 2.8e-3
PILE_UP = 0.3
"""What is pushed away comes up around: a wide bell that takes back this share of the volume."""
DRAG_LIFT = 0.3
"""Bulge before and hollow behind a dragged contact, relative to thickness times divergence of the drag."""
CREASE = 1.2e-5
"""m over which the bed joins the indenter."""


def surface(
    footprint: Footprint, offset: tuple[float, float], depth: float, drag: tuple[float, float], h: float
) -> Map:
    """Height (n_y, n_x), metres, gel z, of the deformed surface; zero where the gel is at rest.

    Parameters
    ----------
    footprint : Footprint
    offset : (2,), metres
        How far the indenter has moved over the gel since the footprint was taken.
    depth : metres
        Of the indenter's lowest point below the undeformed surface; zero or less gives a flat surface.
    drag : (2,), metres
        How far friction has pulled the surface along.
    h : metres
        The gel's thickness.
    """
    grid = footprint.grid
    shape = (len(grid.y), len(grid.x))
    if depth <= 0:
        return np.zeros(shape, np.float32)
    pitch = float(grid.x[1] - grid.x[0])
    sink = np.float32(depth) - moved_heights(footprint, offset)
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
    """A wide blur, on a quarter of the points: nothing in it is fine."""
    tiny = cv2.resize(pressed, (pressed.shape[1] // 4, pressed.shape[0] // 4), interpolation=cv2.INTER_AREA)
    return cv2.resize(cv2.GaussianBlur(tiny, (0, 0), sigma / 4), pressed.shape[::-1], interpolation=cv2.INTER_LINEAR)


def _dragged(bed: Map, bell: Map, drag: tuple[float, float], depth: float, h: float, pitch: float) -> Map:
    """The bed carried along by friction, raised before the contact and hollow behind it."""
    share = bell / max(float(bell.max()), 1e-12)
    moved = shifted(bed, drag, pitch)
    carried = bed + share * (moved - bed)
    slope_x = cv2.Sobel(share, cv2.CV_32F, 1, 0, ksize=3, scale=1 / (8 * pitch))
    slope_y = cv2.Sobel(share, cv2.CV_32F, 0, 1, ksize=3, scale=1 / (8 * pitch))
    # the layer keeps its volume: where the drag converges, the surface rises (the bed is counted downwards)
    return carried + np.float32(DRAG_LIFT * h) * (np.float32(drag[0]) * slope_x + np.float32(drag[1]) * slope_y)

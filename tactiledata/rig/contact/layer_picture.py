"""The surface that a camera sees: the layer solver's, on the picture's finer points."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.contact.footprint import Footprint, moved_heights
from tactiledata.rig.layer.grid import LayerGrid

Map = NDArray[Any]
"""float32; OpenCV's annotations say less."""

CLOSED = 0.1
"""Gaps below this share of the layer's pitch are less than the layer can tell."""
SMOOTH = 0.5
"""Standard deviation, in pitches, of the bell that takes the cells out of the bed; the indenter stays sharp."""
ROUNDS = 3
"""Rounds in which it is found which point of the gel has come to lie where."""


def drawn_surface(
    displacement: Map,
    grid: LayerGrid,
    footprint: Footprint,
    moved: tuple[float, float],
    depth: float,
    fall: Map,
) -> Map:
    """Height (n_y, n_x), m, of the deformed surface over that at rest, at the points of the footprint's grid.

    Parameters
    ----------
    displacement : (3, rows, columns), m, float32
        Of the layer's surface, on its own grid.
    moved : (2,), metres
        How far the indenter has moved over the gel since the footprint was taken.
    depth : metres
        Of the indenter's lowest point below the undeformed surface, which lies lower by ``fall`` (n_y, n_x), m.
    """
    fine = footprint.grid
    if not displacement.any():
        return np.zeros((len(fine.y), len(fine.x)), np.float32)
    column, row = (
        part.astype(np.float32)
        for part in np.meshgrid((fine.x - grid.x[0]) / grid.pitch, (fine.y - grid.y[0]) / grid.pitch)
    )
    pitch = np.float32(grid.pitch)
    # the point now over (x, y) was at (x, y) less its own displacement
    from_column, from_row = column, row
    for _ in range(ROUNDS):
        from_column = column - _read(displacement[0], from_column, from_row) / pitch
        from_row = row - _read(displacement[1], from_column, from_row) / pitch
    bed = -_read(displacement[2], from_column, from_row)
    # a rim runs across the coarse cells in steps that no gel has
    bed = cv2.GaussianBlur(bed, (0, 0), SMOOTH * grid.pitch / float(fine.x[1] - fine.x[0]))
    if depth <= fall.min():
        return -bed
    # on the coarse surface a touching face is only nearly touched: small gaps are closed, and none is pierced
    sink = np.float32(depth) - moved_heights(footprint, moved) - fall
    gap = np.maximum(bed - sink, 0.0)
    told = np.clip(gap / np.float32(CLOSED * grid.pitch), 0.0, 1.0)
    return -(sink + gap * told * told * (3.0 - 2.0 * told))


def _read(values: Map, columns: Map, rows: Map) -> Map:
    return cv2.remap(values, columns, rows, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)

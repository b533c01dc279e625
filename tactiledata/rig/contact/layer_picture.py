"""The surface that a camera sees: the layer solver's surface, interpolated to the picture's finer points."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tactiledata.rig.contact.footprint import Footprint, moved_heights
from tactiledata.rig.layer.grid import LayerGrid

Map = NDArray[Any]
"""A float32 map; OpenCV's annotations do not state the type."""

CLOSED = 0.1
"""Gap, as a share of the layer's pitch, below which the layer cannot resolve it: such gaps are closed."""
SMOOTH = 0.5
"""Standard deviation, in pitches, of the Gaussian that smooths the cells of the bed; the indenter stays sharp."""
ROUNDS = 3
"""Fixed-point iterations that find which point of the gel has moved to a place."""


def drawn_surface(
    displacement: Map,
    grid: LayerGrid,
    footprint: Footprint,
    moved: tuple[float, float],
    depth: float,
    fall: Map,
) -> Map:
    """Return the height (n_y, n_x), m, float32, of the deformed surface over that at rest, on the footprint's grid.

    Rows are y and columns x of the gel frame; the grid stays with the gel. The height is negative where the gel is
    pressed in, and is counted from the undeformed surface at the same x and y, that of the dome where there is one.

    The solver's surface, moved sideways as well, is interpolated by cubics and slightly smoothed. It may not pierce the
    indenter: where it would, it is laid onto it, and gaps below ``CLOSED`` pitches of the layer are narrowed. Points
    beyond the layer's grid have the values of its edge. Where the indenter does not reach the gel (``depth`` at most
    the least ``fall``), only the solver's surface is drawn, and without any displacement all is 0.

    Parameters
    ----------
    displacement : (3, rows, columns), m, float32
        Displacement of the layer's surface along x, y and z of the gel frame, on its own grid.
    grid : LayerGrid
        Grid of the layer.
    footprint : Footprint
        The turned indenter over the gel: heights over its lowest point, m, along gel z, on the grid of the picture.
    moved : (2,), metres
        Move of the indenter along x and y over the gel since the footprint was taken.
    depth : metres
        Depth of the indenter's lowest point below the undeformed surface at the touch's position; negative above it.
    fall : (n_y, n_x), m
        Depth of a dome's undeformed surface below that at the touch's position; zero for a flat gel.
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
    openness = np.clip(gap / np.float32(CLOSED * grid.pitch), 0.0, 1.0)
    return -(sink + gap * openness * openness * (3.0 - 2.0 * openness))


def _read(values: Map, columns: Map, rows: Map) -> Map:
    """Return a map, interpolated by cubics at fractional columns and rows."""
    return cv2.remap(values, columns, rows, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)

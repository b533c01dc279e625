"""Height, indentation, contact mask and slopes of the gel's surface at a picture's pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View

Map = NDArray[np.float32]

CONTACT_DEPTH = 5e-5
"""Smallest indentation, m, that counts as contact: half of the step between two pictures."""
EDGE = 1e-9
"""Tolerance of barycentric shares, so that rounding does not exclude a pixel on a triangle's border."""


def height_map(surface: GelSurface, displacement: NDArray[np.floating], view: View) -> Map:
    """Height (rows, columns), metres, gel z, of the deformed surface at each pixel; NaN where there is no gel.

    Heights are linear within triangles. Where the surface folds over itself the lowest part counts, because the camera
    looks from behind, along +z.

    Parameters
    ----------
    surface : GelSurface
        Undeformed surface of k nodes.
    displacement : (k, 3) m
        Displacement of the nodes, gel frame.
    view : View
        The camera.
    """
    places = surface.deformed(displacement)
    return rasterise(view.pixels_at(places[:, :2]), places[:, 2], surface.triangles, view.shape)


def rasterise(
    corners: NDArray[np.float64], heights: NDArray[np.float64], triangles: NDArray[np.int64], shape: tuple[int, int]
) -> Map:
    """Return the lowest height at each pixel (rows, columns); NaN where no triangle covers its centre.

    Parameters
    ----------
    corners : (k, 2)
        Column and row of each node, px.
    heights : (k,) m
        Height of each node.
    triangles : (t, 3)
        Nodes of each triangle.
    shape : (rows, columns)
        Size of the picture.
    """
    pixel, triangle, shares = covered(corners, triangles, shape)
    lowest = np.full(shape[0] * shape[1], np.inf)
    np.minimum.at(lowest, pixel, (shares * heights[triangles[triangle]]).sum(axis=1))
    lowest[np.isinf(lowest)] = np.nan
    return lowest.reshape(shape).astype(np.float32)


def covered(
    corners: NDArray[np.float64], triangles: NDArray[np.int64], shape: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Return all pairs of a triangle and a pixel that it covers: pixels (m,), triangles (m,) and shares (m, 3).

    Pixels are counted row by row. Shares are barycentric: the pixel's centre is the sum of the triangle's corners,
    weighted by them.

    Parameters
    ----------
    corners : (k, 2)
        Column and row of each node, px.
    triangles : (t, 3)
        Nodes of each triangle.
    shape : (rows, columns)
        Size of the picture.
    """
    functions = _share_functions(corners[triangles])
    # the rows that each triangle crosses; a triangle without area crosses none
    rows = corners[triangles, 1]
    first = np.ceil(rows.min(axis=1) - EDGE).astype(np.int64).clip(0)
    last = np.minimum(np.floor(rows.max(axis=1) + EDGE).astype(np.int64), shape[0] - 1)
    triangle, row = _expanded(first, np.where(np.isfinite(functions).all(axis=(1, 2)), last - first + 1, 0))
    # in a row a share is linear in the column, and none of the three may be negative
    slope, constant = functions[triangle, :, 0], functions[triangle, :, 1] * row[:, None] + functions[triangle, :, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = -(constant + EDGE) / slope
    left = np.where(slope > 0, bound, -np.inf).max(axis=1)
    right = np.where(slope < 0, bound, np.inf).min(axis=1)
    right[((slope == 0) & (constant < -EDGE)).any(axis=1)] = -1.0
    first = np.ceil(left.clip(0, shape[1])).astype(np.int64)
    last = np.floor(right.clip(-1, shape[1] - 1)).astype(np.int64)
    # the columns between both bounds
    span, column = _expanded(first, last - first + 1)
    return row[span] * shape[1] + column, triangle[span], slope[span] * column[:, None] + constant[span]


def _share_functions(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients (t, 3, 3) of the barycentric shares of triangles (t, 3, 2), not finite without area.

    A share is f0 column + f1 row + f2; the second axis is the corner.
    """
    a, b, c = (corner[:, index] for index in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    functions = np.empty((len(corner), 3, 3))
    with np.errstate(divide="ignore", invalid="ignore"):
        for index, (start, end) in enumerate(((b, c), (c, a), (a, b))):
            functions[:, index, 0] = (start[:, 1] - end[:, 1]) / area
            functions[:, index, 1] = (end[:, 0] - start[:, 0]) / area
            functions[:, index, 2] = (start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]) / area
    return functions


def _expanded(first: NDArray[np.int64], counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return every number from ``first[i]`` to ``first[i] + counts[i] - 1``, preceded by the index i of each."""
    counts = counts.clip(0)
    index = np.repeat(np.arange(len(first)), counts)
    return index, np.arange(len(index)) - np.repeat(np.cumsum(counts) - counts, counts) + first[index]


class Indentation:
    """Depth by which the gel is pressed in at each pixel; the height at rest is computed once.

    Parameters
    ----------
    surface : GelSurface
        Undeformed surface of k nodes.
    view : View
        The camera.

    Raises
    ------
    UsageError
        The view shows nothing of the gel.
    """

    def __init__(self, surface: GelSurface, view: View) -> None:
        self.surface, self.view = surface, view
        self._rest = height_map(surface, np.zeros_like(surface.places), view)
        if np.isnan(self._rest).all():
            raise UsageError("a view that sees nothing of the gel", "a view onto the pad", "Are its units metres?")

    def of(self, displacement: NDArray[np.floating]) -> Map:
        """Indentation (rows, columns), m, under a displacement (k, 3), m: negative where gel bulges, 0 off the gel."""
        depth = self._rest - height_map(self.surface, displacement, self.view)
        return np.nan_to_num(depth, copy=False, nan=0.0)

    def of_batch(self, displacements: NDArray[np.floating]) -> Map:
        """Indentations (n, rows, columns), m, under displacements (n, k, 3), m."""
        batch = np.empty((len(displacements), *self.view.shape), np.float32)
        for row, displacement in enumerate(displacements):
            batch[row] = self.of(displacement)
        return batch


def contact_mask(indentation: Any, threshold: float = CONTACT_DEPTH) -> NDArray[np.bool_]:
    """Mask of pixels (..., rows, columns) at which the indentation, m, exceeds a threshold, m.

    The gel also sinks around an indenter, so that the mask is a little larger than the area of contact. It includes
    the slopes, where pictures change most.
    """
    mask: NDArray[np.bool_] = np.asarray(indentation) > threshold
    return mask


def slopes(indentation: Any, view: View) -> Map:
    """Slopes (..., rows, columns, 2), m/m, of indentations (..., rows, columns), m: to the next column and next row.

    Differences are central, and one-sided at the border.
    """
    across, down = view.pitches
    along_rows, along_columns = np.gradient(np.asarray(indentation, np.float32), down, across, axis=(-2, -1))
    return np.stack([along_columns, along_rows], axis=-1).astype(np.float32)

"""Height maps of the gel's surface on a picture's pixels, and the contact in them; no graphics library."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.optics.surface import GelSurface
from tactiledata.optics.view import View

Map = NDArray[np.float32]

CONTACT_DEPTH = 5e-5
"""m by which the gel must be pressed in to count as contact: half of the step between two pictures."""
EDGE = 1e-9
"""Share of a triangle by which a pixel on its border may seem outside by rounding."""


def height_map(surface: GelSurface, displacement: NDArray[np.floating], view: View) -> Map:
    """Height (rows, columns), metres, gel z, of the deformed surface at each pixel; NaN where there is no gel.

    Triangles are drawn with the heights of their corners, linear in between. Where the surface folds over itself the
    lowest part counts: the camera looks from behind, along +z.

    Parameters
    ----------
    surface : GelSurface
    displacement : (k, 3), metres, gel frame
    view : View
    """
    places = surface.deformed(displacement)
    return rasterise(view.pixels_at(places[:, :2]), places[:, 2], surface.triangles, view.shape)


def rasterise(
    corners: NDArray[np.float64], heights: NDArray[np.float64], triangles: NDArray[np.int64], shape: tuple[int, int]
) -> Map:
    """The lowest height at each pixel (rows, columns); NaN where no triangle covers its centre.

    Parameters
    ----------
    corners : (k, 2)
        Column and row of each node.
    heights : (k,)
    triangles : (t, 3)
    shape : (rows, columns)
    """
    pixel, which, shares = covered(corners, triangles, shape)
    drawn = np.full(shape[0] * shape[1], np.inf)
    np.minimum.at(drawn, pixel, (shares * heights[triangles[which]]).sum(axis=1))
    drawn[np.isinf(drawn)] = np.nan
    return drawn.reshape(shape).astype(np.float32)


def covered(
    corners: NDArray[np.float64], triangles: NDArray[np.int64], shape: tuple[int, int]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]:
    """Which triangles cover which pixels: pixel (m,), counted row by row, triangle (m,), and shares (m, 3).

    Shares are barycentric: the pixel's centre is that sum of the triangle's corners.
    """
    functions = _share_functions(corners[triangles])
    rows = corners[triangles, 1]
    first = np.ceil(rows.min(axis=1) - EDGE).astype(np.int64).clip(0)
    last = np.minimum(np.floor(rows.max(axis=1) + EDGE).astype(np.int64), shape[0] - 1)
    which, row = _expanded(first, np.where(np.isfinite(functions).all(axis=(1, 2)), last - first + 1, 0))
    # in a row a share is linear in the column, and none of the three may be negative
    slope, rest = functions[which, :, 0], functions[which, :, 1] * row[:, None] + functions[which, :, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = -(rest + EDGE) / slope
    left = np.where(slope > 0, bound, -np.inf).max(axis=1)
    right = np.where(slope < 0, bound, np.inf).min(axis=1)
    right[((slope == 0) & (rest < -EDGE)).any(axis=1)] = -1.0
    first = np.ceil(left.clip(0, shape[1])).astype(np.int64)
    last = np.floor(right.clip(-1, shape[1] - 1)).astype(np.int64)
    span, column = _expanded(first, last - first + 1)
    return row[span] * shape[1] + column, which[span], slope[span] * column[:, None] + rest[span]


def _share_functions(corner: NDArray[np.float64]) -> NDArray[np.float64]:
    """Barycentric shares (t, 3, 3) of triangles (t, 3, 2): each is f0 column + f1 row + f2; not finite without area."""
    a, b, c = (corner[:, index] for index in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    found = np.empty((len(corner), 3, 3))
    with np.errstate(divide="ignore", invalid="ignore"):
        for index, (one, other) in enumerate(((b, c), (c, a), (a, b))):
            found[:, index, 0] = (one[:, 1] - other[:, 1]) / area
            found[:, index, 1] = (other[:, 0] - one[:, 0]) / area
            found[:, index, 2] = (one[:, 0] * other[:, 1] - other[:, 0] * one[:, 1]) / area
    return found


def _expanded(first: NDArray[np.int64], counts: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Index and number of every number from ``first`` on, so many each."""
    counts = counts.clip(0)
    which = np.repeat(np.arange(len(first)), counts)
    return which, np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts) + first[which]


class Indentation:
    """How deep the gel is pressed at each pixel; the map at rest is drawn once.

    Parameters
    ----------
    surface : GelSurface
    view : View

    Raises
    ------
    UsageError
        The picture sees nothing of the gel.
    """

    def __init__(self, surface: GelSurface, view: View) -> None:
        self.surface, self.view = surface, view
        self._rest = height_map(surface, np.zeros_like(surface.places), view)
        if np.isnan(self._rest).all():
            raise UsageError("a view that sees nothing of the gel", "a view onto the pad", "Are its units metres?")

    def of(self, displacement: NDArray[np.floating]) -> Map:
        """Indentation (rows, columns), metres: positive where pressed in, negative where it bulges, 0 off the gel."""
        depth = self._rest - height_map(self.surface, displacement, self.view)
        return np.nan_to_num(depth, copy=False, nan=0.0)

    def of_batch(self, displacements: NDArray[np.floating]) -> Map:
        """Indentations (n, rows, columns) of displacements (n, k, 3)."""
        batch = np.empty((len(displacements), *self.view.shape), np.float32)
        for row, displacement in enumerate(displacements):
            batch[row] = self.of(displacement)
        return batch


def contact_mask(indentation: Any, threshold: float = CONTACT_DEPTH) -> NDArray[np.bool_]:
    """Where the gel is pressed in by more than a threshold (..., rows, columns), metres.

    The gel sinks around an indenter, too, so that the mask is a little larger than the area of contact: it holds the
    slopes, where pictures change most.
    """
    mask: NDArray[np.bool_] = np.asarray(indentation) > threshold
    return mask


def slopes(indentation: Any, view: View) -> Map:
    """Slopes (..., rows, columns, 2) of indentations (..., rows, columns), m/m: along columns, then along rows.

    Central differences; one-sided at the border.
    """
    across, down = view.pitches
    along_rows, along_columns = np.gradient(np.asarray(indentation, np.float32), down, across, axis=(-2, -1))
    return np.stack([along_columns, along_rows], axis=-1).astype(np.float32)

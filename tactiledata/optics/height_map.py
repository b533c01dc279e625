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
    corner = corners[triangles]
    first = np.ceil(corner.min(axis=1) - EDGE).astype(np.int64).clip(0)
    last = np.floor(corner.max(axis=1) + EDGE).astype(np.int64)
    last = np.minimum(last, [shape[1] - 1, shape[0] - 1])
    which, column, row = _candidates(first, (last - first + 1).clip(0))
    # twice the areas that a pixel spans with each side, over that of the triangle
    a, b, c = (corner[:, index] for index in range(3))
    area = _cross(b - a, c - a)
    is_flat = area == 0
    scale = np.divide(1.0, area, out=np.zeros_like(area), where=~is_flat)[which]
    centre = np.stack([column, row], axis=1) - a[which]
    share_b = _cross(centre, (c - a)[which]) * scale
    share_c = _cross((b - a)[which], centre) * scale
    shares = np.stack([1.0 - share_b - share_c, share_b, share_c], axis=1)
    is_inside = (shares.min(axis=1) >= -EDGE) & ~is_flat[which]
    return (row * shape[1] + column)[is_inside], which[is_inside], shares[is_inside]


def _candidates(
    first: NDArray[np.int64], sides: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Triangle, column and row of every pixel in the box around every triangle."""
    counts = sides[:, 0] * sides[:, 1]
    which = np.repeat(np.arange(len(first)), counts)
    place = np.arange(len(which)) - np.repeat(np.cumsum(counts) - counts, counts)
    width = sides[which, 0]
    return which, first[which, 0] + place % width, first[which, 1] + place // width


def _cross(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


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

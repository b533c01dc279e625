"""Height map of an indenter's underside on a fine grid, for fast distances."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from tactiledata.arrays import Array
from tactiledata.errors import UsageError
from tactiledata.indenters.base import Indenter

PITCH = 2e-5
"""Spacing of the grid, m: interpolation errs by 0.03 micrometres for a ball of 2 mm radius."""
REACH = 3e-3
"""Height above the tip, m, beyond which a body never touches: no gel is pressed deeper than its thickness."""
WIDEST = 15e-3
"""Largest distance from the tip along x and y, m, that is mapped: it is beyond the largest pad."""
KEPT = 16
"""Reliefs that are kept for the next engine that presses the same indenter: more than the indenters of most stores."""


@dataclass(frozen=True)
class IndenterRelief:
    """Height map of an indenter's underside in its own frame, tip at the origin and z into the body.

    Parameters
    ----------
    origin : (x, y) m
        Place of the first grid point.
    heights : (n, m) m
        Lowest z of the body, rows over x and columns over y, continued flat beyond its outline.
    covered : (n, m) bool
        Whether the body is above the point at all.
    """

    origin: tuple[float, float]
    heights: Array
    covered: NDArray[np.bool_]


@lru_cache(KEPT)
def indenter_relief(indenter: Indenter) -> IndenterRelief:
    """Return the height map of an indenter's underside.

    The grid has a spacing of ``PITCH``, in the indenter's frame with the tip at the origin. Only surfaces visible from
    below count: undercuts and vertical walls take no pressure. Beside the body, the height of the nearest point of it
    goes on, and ``covered`` says that there is none.

    Parameters
    ----------
    indenter : Indenter
        The indenter.

    Raises
    ------
    UsageError
        Nothing of the indenter lies near its tip, as when its mesh's origin is not at the tip.
    """
    bounds = np.asarray(indenter.mesh().bounds)
    low = np.maximum(bounds[0, :2], -WIDEST) - 2 * PITCH
    high = np.minimum(bounds[1, :2], WIDEST) + 2 * PITCH
    x, y = (PITCH * np.arange(np.floor(low[i] / PITCH), np.ceil(high[i] / PITCH) + 1) for i in range(2))
    heights = np.asarray(indenter.height(*np.meshgrid(x, y, indexing="ij")), dtype=float)
    covered = np.isfinite(heights) & (heights < REACH)
    if not covered.any() or heights[covered].min() > PITCH * 5:
        lowest = float(heights[np.isfinite(heights)].min()) if np.isfinite(heights).any() else float("nan")
        raise UsageError(
            f"the lowest point of indenter {indenter.shape!r} lies at z = {lowest:.4g} m of its own frame",
            "a body whose tip is the origin and that lies in z >= 0",
            "Move the mesh so that what touches first is at the origin, +z into the body; check the mesh's unit.",
            lowest=lowest,
        )
    # points beyond the outline take the height of the nearest covered one
    nearest = distance_transform_edt(~covered, return_distances=False, return_indices=True)
    return IndenterRelief((float(x[0]), float(y[0])), np.ascontiguousarray(heights[tuple(nearest)]), covered)

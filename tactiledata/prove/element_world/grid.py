"""Grid lines of a pad: fine where a touch presses, wider towards its sides and its base."""

from __future__ import annotations

import numpy as np

from tactiledata.prove.element_world.bodies import RigidBody
from tactiledata.prove.element_world.pad import Array
from tactiledata.prove.element_world.surface import Pose

ACROSS = 10
"""Spacings across the narrower side of a contact."""
FINEST, COARSEST = 0.36, 0.45
"""Least and greatest spacing under a contact, mm."""
GROWTH = 1.7
"""Ratio of neighbouring spacings beside a contact."""
LAYERS = 5
"""Bricks through the thickness."""
FLATTER = 0.8
"""Height of the uppermost bricks in spacings."""


def contact_box(body: RigidBody, rotation: Array, tips: Array) -> tuple[Array, float]:
    """Return the sides ((x, x), (y, y)), mm, of what a body covers on its way, and the narrowest cover, mm.

    Parameters
    ----------
    body : RigidBody
        What presses.
    rotation : (3, 3)
        Of the body.
    tips : (k, 3), mm
        Places of its tip.
    """
    around = np.arange(-7.95, 8.0, 0.1)
    x, y = (part.ravel() for part in np.meshgrid(around, around))
    low, high, narrow = np.full(2, np.inf), np.full(2, -np.inf), 0.0
    for tip in tips:
        points = np.column_stack([x + tip[0], y + tip[1], np.zeros_like(x)])
        inside = points[Pose(body, rotation, tip).gaps(points) < 0.0, :2]
        if len(inside):
            low, high = np.minimum(low, inside.min(axis=0)), np.maximum(high, inside.max(axis=0))
            # as wide as a disc or a strip of that area and length
            spread = np.sqrt(np.linalg.eigvalsh(np.cov(inside.T))[0]) if len(inside) > 2 else 0.0
            narrow = max(narrow, 4.0 * float(spread))
    if narrow == 0.0:
        raise ValueError("the body never reaches the gel")
    return np.column_stack([low, high]), narrow


def spacing_for(narrow: float, finer: float = 1.0) -> float:
    """Return the spacing, mm, under a contact whose narrowest cover is ``narrow``, mm, so many times finer than usual.

    Examples
    --------
    >>> spacing_for(4.0)
    0.4
    """
    return float(np.clip(narrow / ACROSS, FINEST, COARSEST)) / finer


def grid_lines(
    outline: tuple[float, float], thickness: float, box: Array, spacing: float
) -> tuple[Array, Array, Array]:
    """Return grid lines along x, y and z, mm.

    Parameters
    ----------
    outline : (2,), mm
        Sides of the pad along x and y.
    thickness : mm
        From the base to the outer surface, z = 0.
    box : (2, 2), mm
        Where bricks are fine: ends along x, ends along y.
    spacing : mm
        Of the fine bricks; finer through the thickness as well.
    """
    x, y = (_along(side, ends[0], ends[1], spacing) for side, ends in zip(outline, box, strict=True))
    layers = LAYERS if spacing >= FINEST else int(np.ceil(LAYERS * FINEST / spacing))
    first = min(FLATTER * spacing, thickness / layers)
    ratio = _ratio(thickness / first, layers)
    heights = first * ratio ** np.arange(layers)
    depths = np.concatenate([[0.0], np.cumsum(heights)]) * thickness / heights.sum()
    return x, y, -depths[::-1]


def _along(side: float, low: float, high: float, spacing: float) -> Array:
    """Return lines from one side of the pad to the other, spaced evenly between ``low`` and ``high``, mm."""
    low, high = max(low, spacing - 0.5 * side), min(high, 0.5 * side - spacing)
    inner = np.linspace(low, high, max(2, round((high - low) / spacing)) + 1)
    step = inner[1] - inner[0]
    return np.concatenate([-_outward(-low, 0.5 * side, step)[::-1], inner, _outward(high, 0.5 * side, step)])


def _outward(start: float, end: float, step: float) -> Array:
    """Return lines after ``start`` up to ``end``, mm, ever wider from a first spacing on."""
    room = end - start
    count = 1
    while step * sum(GROWTH ** np.arange(1, count + 1)) < room:
        count += 1
    widths = GROWTH ** np.arange(1, count + 1)
    marks = start + room * np.cumsum(widths) / widths.sum()
    marks[-1] = end
    return marks


def _ratio(total: float, count: int) -> float:
    """Return the ratio of a geometric series of ``count`` terms from 1 that adds up to ``total``."""
    low, high = 1.0, 10.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.sum(middle ** np.arange(count)) < total else (low, middle)
    return 0.5 * (low + high)

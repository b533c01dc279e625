"""Shear that sticks remembers the pull at which the contact slid last."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.played_columns import cubics_at

Array = NDArray[np.float64]

BEGINS_TO_SLIDE, ALL_SLIDES = 0.8, 0.95
"""Shares of the limit between which shear forgets: what slides on a curved gel is a little off the limit."""
TURNS = 0.05
"""By how much that share goes down, from frame to frame, where nothing is forgotten, near the limit or not."""


@dataclass(frozen=True)
class CubicsOverFriction:
    """Columns of n frames as piecewise cubics of the friction; beyond the nodes, what they are at the end.

    Parameters
    ----------
    nodes : (m,)
        Frictions, ascending.
    coefficients : (4, m - 1, n, c)
        Of the third power of the distance from the node below first.
    """

    nodes: Array
    coefficients: Array

    def at(self, frictions: Array) -> Array:
        """Columns (n, c), each frame at its own friction (n,)."""
        columns: Array = cubics_at(self.nodes, self.coefficients, frictions)
        return columns


def remembered_shear(
    frictions: Array, columns: CubicsOverFriction, own: Array, touching: NDArray[np.bool_], reach: Array
) -> Array:
    """Shear (n, 2) that stuck at another friction, beyond what each frame has if the whole path had its own friction.

    From frame to frame shear T changes as it does at the friction f of the later one, T_k = T_k-1 + T_k(f) - T_k-1(f),
    within the limit: Masing's rule, which holds for partial slip on the way back as in Mindlin's contact. The nearer to
    its limit T(f) is, if it does not go down, the more of what was remembered is forgotten, but not more than the way
    since the frame before could have loaded: a limit that grows at rest pulls nothing. So shear depends continuously on
    all that it is made of.

    Parameters
    ----------
    frictions : (n,)
    columns : x, y and normal force first
    own : (n, c)
        What they are, each frame at its own friction.
    touching : (n,)
    reach : (n,)
        The contact's stiffness times the way along the gel since the frame before, in the unit of the columns.
    """
    if (frictions == frictions[:1]).all():
        return np.zeros((len(frictions), 2))
    before = CubicsOverFriction(columns.nodes, columns.coefficients[:, :, :-1, :3]).at(frictions[1:])
    share = _share(own[1:], frictions[1:])
    grows = share - _share(before, frictions[1:])
    forgets = 1.0 - np.maximum((ALL_SLIDES - share) / (ALL_SLIDES - BEGINS_TO_SLIDE), -grows / TURNS).clip(0.0, 1.0)
    most = np.maximum(frictions * np.maximum(own[:, 2], 0.0), np.hypot(own[:, 0], own[:, 1]))
    in_contact = touching[1:] & touching[:-1]
    return _followed(own[:, :2], own[:-1, :2] - before[:, :2], most[1:], forgets, reach[1:], in_contact)


def _followed(
    own: Array, changed: Array, most: Array, forgets: Array, reach: Array, in_contact: NDArray[np.bool_]
) -> Array:
    """What is remembered (n, 2) beyond the frames' own shear (n, 2); the rest by frame from the second on."""
    more = np.zeros_like(own)
    x = y = 0.0
    steps = zip(own[1:].tolist(), changed.tolist(), *(one.tolist() for one in (most, forgets, reach)), strict=True)
    for frame, ((own_x, own_y), (add_x, add_y), limit, share, way) in enumerate(steps, start=1):
        if not in_contact[frame - 1]:
            x = y = 0.0
            continue
        pull_x, pull_y = own_x + x + add_x, own_y + y + add_y
        size = hypot(pull_x, pull_y)
        within = limit / size if size > limit else 1.0
        x, y = pull_x * within - own_x, pull_y * within - own_y
        size = hypot(x, y)
        left = 1.0 - min(share * size, way) / size if size > 0.0 else 0.0
        x, y = x * left, y * left
        more[frame] = x, y
    return more


def _share(columns: Array, frictions: Array) -> Array:
    """Of the limit, (n,): how much shear there is."""
    limits = frictions * np.maximum(columns[:, 2], 0.0)
    share: Array = np.divide(
        np.hypot(columns[:, 0], columns[:, 1]), limits, out=np.zeros_like(limits), where=limits > 0
    )
    return share

"""Shear that sticks remembers the pull at which the contact slid last."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tactiledata.arrays import Array
from tactiledata.diagnose.touches.played_columns import cubics_at

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
    return _shear_remembered(own[:, :2], own[:-1, :2] - before[:, :2], most[1:], forgets, reach[1:], in_contact)


def _shear_remembered(
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


PARTS = 12
"""Sliders side by side."""
LARGEST_FACTOR = 2.0
"""Of a spring over what a round contact of its area would have; its reciprocal is the smallest."""
STARTS = (0.0, 0.3, 0.6)
"""Spreads from which is searched."""
LEAST_PULL = 0.1
"""Of the limit: a touch that pulls less tells nothing of its springs."""


class Sliders(NamedTuple):
    """Equal springs side by side, each with a slider: Iwan's model of a contact that slips in part.

    Source: W. D. Iwan, J. Appl. Mech. 33 (1966), 893; limits that are spread evenly.

    Parameters
    ----------
    factor : float
        On the stiffness of a round contact, `tactiledata.effects.touch.shear_stiffness`.
    spread : float
        Limits lie evenly within 1 - spread and 1 + spread of their mean: 0 where all slides at once.
    """

    factor: float = 1.0
    spread: float = 0.0

    def pull(self, path: Array, stiffness: Array, limit: Array) -> Array:
        """Pull (n, 2) on the gel along a path (n, 2), m; stiffness (n,) and limit (n,) are 0 without contact."""
        pull: Array = _pull_of_sliders(path, stiffness, limit, self.factor, self.spread)
        return pull


@njit(cache=True)
def _pull_of_sliders(path: Array, stiffness: Array, limit: Array, factor: float, spread: float) -> Array:
    count = PARTS if spread else 1
    held = np.zeros((count, 2))
    pull = np.zeros((len(limit), 2))
    for frame in range(len(limit)):
        if not limit[frame] > 0.0:
            held[:] = 0.0
            continue
        step_x, step_y = 0.0, 0.0
        if frame > 0:
            spring = 0.5 * factor * (stiffness[frame] + stiffness[frame - 1])
            step_x = (path[frame, 0] - path[frame - 1, 0]) * spring
            step_y = (path[frame, 1] - path[frame - 1, 1]) * spring
        for part in range(count):
            x, y = held[part, 0] + step_x / count, held[part, 1] + step_y / count
            size = np.sqrt(x * x + y * y)
            most = limit[frame] * (1.0 + spread * ((2.0 * part + 1.0) / PARTS - 1.0)) / count
            if size > most:
                x, y = x * most / size, y * most / size
            held[part, 0], held[part, 1] = x, y
            pull[frame, 0] += x
            pull[frame, 1] += y
    return pull


def own_sliders(path: Array, pull: Array, stiffness: Array, limit: Array) -> Sliders:
    """Those nearest to a pull (n, 2) along a path (n, 2), m; those of a round contact where it hardly pulls.

    Stiffness (n,) and limit (n,) as for `Sliders.pull`.
    """
    size = np.hypot(pull[:, 0], pull[:, 1])
    if size.max(initial=0.0) <= LEAST_PULL * limit.max(initial=0.0):
        return Sliders()
    # what slides on a curved gel is a little off the limit
    reached, unit = np.maximum(limit, np.where(limit > 0, size, 0.0)), size.max()

    def missing(values: Array) -> Array:
        sliders = Sliders(float(np.exp(values[0])), float(values[1]))
        return ((sliders.pull(path, stiffness, reached) - pull) / unit).ravel()

    most = float(np.log(LARGEST_FACTOR))
    start = min(([0.0, spread] for spread in STARTS), key=lambda one: float(np.sum(missing(np.array(one)) ** 2)))
    found = least_squares(missing, start, bounds=([-most, -1e-9], [most, 1.0]), diff_step=1e-2, max_nfev=20).x
    return Sliders(float(np.exp(found[0])), float(max(found[1], 0.0)))


def shear_change(path: Array, shift: Array, stiffness: Array, limit: Array, sliders: Sliders) -> Array:
    """Change (n, 2) of the force on an indenter that is shifted by (n, 2) from a path (n, 2), m.

    Both ways are followed by springs that slide at a limit (n,); a shift that stays the same changes nothing.
    Stiffness (n,) and limit are over one modulus, and 0 without contact.
    """
    if not (shift != shift[:1]).any():
        return np.zeros_like(path)
    change: Array = sliders.pull(path, stiffness, limit) - sliders.pull(path + shift, stiffness, limit)
    return change

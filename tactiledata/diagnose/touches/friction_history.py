"""Shear that depends on earlier frames: friction that has changed since the contact slid, and another path."""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.optimize import least_squares

from tactiledata.arrays import Array, Mask
from tactiledata.diagnose.touches.played_columns import cubics_at

BEGINS_TO_SLIDE, ALL_SLIDES = 0.8, 0.95
"""Shares of the friction limit between which memory fades from none lost to all lost.

On a curved gel, a contact that slides is a little off the limit."""
TURNS = 0.05
"""If that share falls by at least this from one frame to the next, shear is being unloaded and no memory is lost."""


@dataclass(frozen=True)
class CubicsOverFriction:
    """Columns of n frames as piecewise cubics of the friction coefficient, constant beyond the outer nodes.

    Parameters
    ----------
    nodes : (m,)
        Friction coefficients, ascending.
    coefficients : (4, m - 1, n, c)
        Of each piece, frame and column, highest power first, over the distance from the lower node; neighbouring
        pieces agree at the node between them.
    """

    nodes: Array
    coefficients: Array

    def at(self, frictions: Array) -> Array:
        """Return columns (n, c), each frame at its own friction coefficient (n,)."""
        columns: Array = cubics_at(self.nodes, self.coefficients, frictions)
        return columns


def remembered_shear(frictions: Array, columns: CubicsOverFriction, own: Array, touching: Mask, reach: Array) -> Array:
    """Return shear (n, 2) that stuck at another friction, to be added to the shear at each frame's own friction.

    Let T_k(f) be the shear of frame k if the whole path had had the friction f. From frame k - 1 to frame k, whose
    friction is f, the shear T changes as it does at f: T_k = T_k-1 + T_k(f) - T_k-1(f), within the friction limit. That
    is Masing's rule, which holds for partial slip on the way back as in Mindlin's contact. The memory is T_k - T_k(f).
    Sliding erases memory: the nearer T_k(f) is to the friction limit, unless it is falling, the more of the memory is
    lost. No more is lost than the motion since the frame before could have loaded, so that a friction limit that grows
    at rest changes no shear. Shear depends continuously on all inputs.

    Parameters
    ----------
    frictions : (n,)
        Friction coefficient of each frame.
    columns : CubicsOverFriction
        Columns over the friction: force along x, along y, normal force, then others; over Young's modulus, in m^2.
    own : (n, c)
        The columns of each frame at its own friction.
    touching : (n,) bool
        Frames in contact; memory is lost without contact.
    reach : (n,)
        Tangential stiffness of the contact times the way along the gel since the frame before, in the unit of the
        forces.
    """
    if (frictions == frictions[:1]).all():
        return np.zeros((len(frictions), 2))
    # each frame but the last at the friction of the frame after it
    before = CubicsOverFriction(columns.nodes, columns.coefficients[:, :, :-1, :3]).at(frictions[1:])
    share = _share(own[1:], frictions[1:])
    grows = share - _share(before, frictions[1:])
    forgets = 1.0 - np.maximum((ALL_SLIDES - share) / (ALL_SLIDES - BEGINS_TO_SLIDE), -grows / TURNS).clip(0.0, 1.0)
    most = np.maximum(frictions * np.maximum(own[:, 2], 0.0), np.hypot(own[:, 0], own[:, 1]))
    in_contact = touching[1:] & touching[:-1]
    return _shear_remembered(own[:, :2], own[:-1, :2] - before[:, :2], most[1:], forgets, reach[1:], in_contact)


def _shear_remembered(own: Array, changed: Array, most: Array, forgets: Array, reach: Array, in_contact: Mask) -> Array:
    """Return the memory (n, 2): shear beyond the frames' own.

    Parameters
    ----------
    own : (n, 2)
        Shear of each frame at its own friction.
    changed : (n - 1, 2)
        By how much the shear of the frame before exceeds its shear at the friction of this frame, from the second
        frame on.
    most : (n - 1,)
        Friction limit.
    forgets : (n - 1,)
        Share of the memory that is lost, 0 to 1.
    reach : (n - 1,)
        Largest size of the memory that can be lost.
    in_contact : (n - 1,) bool
        Whether this frame and the one before are in contact.
    """
    more = np.zeros_like(own)
    x = y = 0.0
    steps = zip(
        own[1:].tolist(), changed.tolist(), *(column.tolist() for column in (most, forgets, reach)), strict=True
    )
    for frame, ((own_x, own_y), (add_x, add_y), limit, share, way) in enumerate(steps, start=1):
        if not in_contact[frame - 1]:
            x = y = 0.0
            continue
        # the sum, brought back to the limit
        pull_x, pull_y = own_x + x + add_x, own_y + y + add_y
        size = hypot(pull_x, pull_y)
        within = limit / size if size > limit else 1.0
        x, y = pull_x * within - own_x, pull_y * within - own_y
        # the part that sliding erases
        size = hypot(x, y)
        left = 1.0 - min(share * size, way) / size if size > 0.0 else 0.0
        x, y = x * left, y * left
        more[frame] = x, y
    return more


def _share(columns: Array, frictions: Array) -> Array:
    """Return the shear over the friction limit (n,); 0 without a normal force."""
    limits = frictions * np.maximum(columns[:, 2], 0.0)
    share: Array = np.divide(
        np.hypot(columns[:, 0], columns[:, 1]), limits, out=np.zeros_like(limits), where=limits > 0
    )
    return share


PARTS = 12
"""Number of sliders side by side."""
LARGEST_FACTOR = 2.0
"""Largest factor of a fitted stiffness on that of a round contact; its reciprocal is the smallest."""
STARTS = (0.0, 0.3, 0.6)
"""Spreads from which the best start of the fit is chosen."""
LEAST_PULL = 0.1
"""A touch whose largest pull is at most this share of the largest friction limit does not determine its springs."""


class Sliders(NamedTuple):
    """Equal springs side by side, each with a slider: Iwan's model of a contact that slips in part.

    Source: W. D. Iwan, J. Appl. Mech. 33 (1966), 893, with limits that are spread evenly.

    Parameters
    ----------
    factor : float
        Factor on the stiffness of a round contact, `tactiledata.effects.touch.shear_stiffness`.
    spread : float
        The limits lie evenly between 1 - spread and 1 + spread of their mean; at 0 all sliders slip at once.
    """

    factor: float = 1.0
    spread: float = 0.0

    def pull(self, path: Array, stiffness: Array, limit: Array) -> Array:
        """Return the pull (n, 2) on the gel along a path, in the unit of the limit.

        Parameters
        ----------
        path : (n, 2) m
            Position of the indenter along the gel.
        stiffness : (n,)
            Tangential stiffness of a round contact, in the unit of the limit per metre; 0 without contact.
        limit : (n,)
            Friction limit of the whole contact; 0 without contact.
        """
        pull: Array = _pull_of_sliders(path, stiffness, limit, self.factor, self.spread)
        return pull


@njit(cache=True)
def _pull_of_sliders(path: Array, stiffness: Array, limit: Array, factor: float, spread: float) -> Array:
    """Return the pull (n, 2) of springs with sliders along a path; see `Sliders.pull`."""
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
            # a spring that exceeds its limit slips back to it
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
    """Return the springs with sliders whose pull is nearest to a given one; those of a round contact if it is faint.

    Parameters
    ----------
    path : (n, 2) m
        Position of the indenter along the gel.
    pull : (n, 2)
        Pull on the gel.
    stiffness, limit : (n,)
        As in `Sliders.pull`, in the unit of the pull.
    """
    size = np.hypot(pull[:, 0], pull[:, 1])
    if size.max(initial=0.0) <= LEAST_PULL * limit.max(initial=0.0):
        return Sliders()
    # on a curved gel, a contact that slides is a little off the limit
    reached, unit = np.maximum(limit, np.where(limit > 0, size, 0.0)), size.max()

    def missing(values: Array) -> Array:
        sliders = Sliders(float(np.exp(values[0])), float(values[1]))
        return ((sliders.pull(path, stiffness, reached) - pull) / unit).ravel()

    most = float(np.log(LARGEST_FACTOR))
    start = min(([0.0, spread] for spread in STARTS), key=lambda values: float(np.sum(missing(np.array(values)) ** 2)))
    solution = least_squares(missing, start, bounds=([-most, -1e-9], [most, 1.0]), diff_step=1e-2, max_nfev=20).x
    return Sliders(float(np.exp(solution[0])), float(max(solution[1], 0.0)))


def shear_change(path: Array, shift: Array, stiffness: Array, limit: Array, sliders: Sliders) -> Array:
    """Return the change (n, 2) of the force on an indenter that is shifted from its recorded path.

    Springs with sliders follow both paths, and the change is the difference. A constant shift changes nothing.

    Parameters
    ----------
    path : (n, 2) m
        Recorded path along the gel.
    shift : (n, 2) m
        Shift from that path in each frame.
    stiffness : (n,)
        Tangential stiffness of a round contact; 0 without contact.
    limit : (n,)
        Friction limit, in the unit of the change; 0 without contact.
    sliders : Sliders
        Springs with sliders that pull as this touch does.
    """
    if not (shift != shift[:1]).any():
        return np.zeros_like(path)
    change: Array = sliders.pull(path, stiffness, limit) - sliders.pull(path + shift, stiffness, limit)
    return change

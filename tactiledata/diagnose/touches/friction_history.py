"""Shear that depends on earlier frames: friction that is not that of a play, or changes, and another path."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.interpolate import PchipInterpolator
from scipy.optimize import least_squares

from tactiledata.arrays import Array
from tactiledata.diagnose.touches.played_columns import cubics_at


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


def own_sliders(path: Array, pulls: Array, stiffness: Array, limits: Array) -> Sliders:
    """Return the springs with sliders whose pulls are nearest to given ones; those of a round contact if all are faint.

    Parameters
    ----------
    path : (n, 2) m
        Position of the indenter along the gel.
    pulls : (m, n, 2)
        Pull on the gel at each of m friction coefficients.
    stiffness : (n,)
        As in `Sliders.pull`, in the unit of the pull.
    limits : (m, n)
        Friction limit at each of the coefficients.
    """
    sizes = np.hypot(pulls[..., 0], pulls[..., 1])
    if sizes.max(initial=0.0) <= LEAST_PULL * limits.max(initial=0.0):
        return Sliders()
    unit = sizes.max()

    def missing(values: Array) -> Array:
        sliders = Sliders(float(np.exp(values[0])), float(values[1]))
        found = np.array([sliders.pull(path, stiffness, limit) for limit in limits])
        return ((found - pulls) / unit).ravel()

    most = float(np.log(LARGEST_FACTOR))
    start = min(([0.0, spread] for spread in STARTS), key=lambda values: float(np.sum(missing(np.array(values)) ** 2)))
    solution = least_squares(missing, start, bounds=([-most, -1e-9], [most, 1.0]), diff_step=1e-2, max_nfev=20).x
    return Sliders(float(np.exp(solution[0])), float(max(solution[1], 0.0)))


@dataclass(frozen=True)
class ShearBetweenPlays:
    """Shear of one touch at friction coefficients that were not played: a control variate by springs with sliders.

    The springs follow the recorded path at the friction that is asked for in each frame, and at each friction that was
    played. The former, less what interpolation makes of the latter, is added to the interpolated shear. So what a play
    tells stands; the springs tell where a contact turns from sticking to sliding between two plays, what a friction
    beyond those played does, and what is left of earlier frames with another friction.

    Parameters
    ----------
    path : (n, 2) m
        Recorded position of the indenter along the gel.
    stiffness : (n,)
        Tangential stiffness of a round contact, in the unit of the load per metre; 0 without contact.
    load : (n,)
        Normal force of the plays; 0 without contact.
    sliders : Sliders
        Springs with sliders that pull as this touch does.
    played : CubicsOverFriction
        Their shear (n, 2), on the indenter, interpolated between the frictions that were played.
    """

    path: Array
    stiffness: Array
    load: Array
    sliders: Sliders
    played: CubicsOverFriction

    @classmethod
    def of(cls, nodes: Array, path: Array, stiffness: Array, load: Array, shear: Array) -> ShearBetweenPlays:
        """Fit springs with sliders to the plays of a touch.

        Parameters
        ----------
        nodes : (m,)
            Friction coefficients that were played, ascending.
        path, stiffness, load
            See the class.
        shear : (m, n, 2)
            Shear on the indenter at each of these frictions; 0 without contact.
        """
        limits = nodes[:, None] * load
        sliders = own_sliders(path, -shear, stiffness, limits)
        own = -np.array([sliders.pull(path, stiffness, limit) for limit in limits])
        return cls(path, stiffness, load, sliders, CubicsOverFriction(nodes, PchipInterpolator(nodes, own).c))

    def missed(self, frictions: Array, shear: Array, load: Array) -> Array:
        """Return the shear (n, 2) on the indenter that interpolation between plays misses.

        Below the lowest friction that was played, what the springs miss of that play is in proportion to the friction.

        Parameters
        ----------
        frictions : (n,)
            Friction coefficient of each frame.
        shear : (n, 2)
            Shear on the indenter, interpolated at these frictions.
        load : (n,)
            Normal force; what is missed is in proportion to it, where it differs from that of the plays.
        """
        springs, played = (
            -self.sliders.pull(self.path, self.stiffness, frictions * self.load),
            self.played.at(frictions),
        )
        share = np.minimum(frictions / self.played.nodes[0], 1.0)[:, None]
        missed = springs - played + (share - 1.0) * (shear - played)
        scale = np.divide(load, self.load, out=np.zeros_like(load), where=self.load > 0)
        found: Array = np.where(scale[:, None] > 0, scale[:, None] * missed, 0.0)
        return found


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

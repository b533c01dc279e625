"""Shear where friction, depth or path are not those of a play: what interpolation between plays misses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.interpolate import PchipInterpolator

from tactiledata.arrays import Array
from tactiledata.diagnose.touches.played_columns import LEAST_FORCE, cubics_at
from tactiledata.diagnose.touches.sliders import Sliders, own_sliders
from tactiledata.effects.touch.shear_stiffness import shear_stiffness


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


@dataclass(frozen=True)
class Parabola:
    """A quantity of each of n frames over the contact offset: level + z (slope + z curvature), z in metres.

    Parameters
    ----------
    level, slope, curvature : (n, ...)
        Coefficients.
    """

    level: Array
    slope: Array
    curvature: Array

    @classmethod
    def through(cls, less: Array, none: Array, more: Array, step: float) -> Parabola:
        """Return the parabola through values at three offsets.

        Parameters
        ----------
        less, none, more : (n, ...)
            Values at the offsets -step, 0 and step.
        step : m
            Distance of the offsets.
        """
        return cls(none, (more - less) / (2 * step), (more + less - 2 * none) / (2 * step**2))

    def at(self, z: Array) -> Array:
        """Return the quantity (n, ...) at an offset z of each frame."""
        bent: Array = self.level + z * (self.slope + z * self.curvature)
        return bent


@dataclass(frozen=True)
class PressedContact:
    """Normal force and area of the contact of one touch over the contact offset, and its tangential stiffness.

    Parameters
    ----------
    load, area : Parabola
        Normal force over Young's modulus, m^2, and area of the contact, m^2, of n frames.
    ratio : float
        Poisson's ratio at which the touch was played.
    thickness : m
        Height of the gel.
    """

    load: Parabola
    area: Parabola
    ratio: float
    thickness: float

    def at(self, offset: Array) -> tuple[Array, Array]:
        """Return stiffness (n,), m, over Young's modulus, and load (n,) at offsets (n,), m; 0 without contact."""
        load, area = self.load, self.area
        pressed: tuple[Array, Array] = _pressed_at(
            offset, load.level, load.slope, load.curvature, area.level, area.slope, area.curvature, self.ratio,
            self.thickness,
        )  # fmt: skip
        return pressed


@njit(cache=True)
def _pressed_at(
    offset: Array, level: Array, slope: Array, curvature: Array, of_area: Array, rises: Array, curves: Array,
    ratio: float, thickness: float,
) -> tuple[Array, Array]:  # fmt: skip
    """Return stiffness (n,) and load (n,) of `PressedContact` from the coefficients of its two parabolas (n,)."""
    areas, loads = np.zeros(len(offset)), np.zeros(len(offset))
    for frame in range(len(offset)):
        z = offset[frame]
        load = level[frame] + z * (slope[frame] + z * curvature[frame])
        if load > LEAST_FORCE:
            areas[frame] = max(of_area[frame] + z * (rises[frame] + z * curves[frame]), 0.0)
            loads[frame] = load
    return shear_stiffness(areas, ratio, thickness), loads


@dataclass(frozen=True)
class ShearBetweenPlays:
    """Shear of one touch where friction, depth or path are not those of a play: springs with sliders tell it.

    The springs follow the path with the friction, the load and the stiffness that each frame has, and with those of
    each play. The former, less what interpolation makes of the latter, is added to the interpolated shear: the springs
    are a control variate, and what a play tells stands. The springs tell where a contact turns from sticking to sliding
    between two plays, what a friction beyond those played does, and what is left of earlier frames with another
    friction, depth or way.

    Source of the springs: W. D. Iwan, J. Appl. Mech. 33 (1966), 893. Control variates: e.g. P. Glasserman, Monte Carlo
    Methods in Financial Engineering (2003), ch. 4.1.

    Parameters
    ----------
    path : (n, 2) m
        Recorded position of the indenter along the gel.
    contact : PressedContact
        Load and stiffness of the contact.
    sliders : Sliders
        Springs with sliders that pull as this touch does.
    played : CubicsOverFriction
        Level, slope and curvature over the offset of their shear on the indenter (n, 6), two columns each.
    """

    path: Array
    contact: PressedContact
    sliders: Sliders
    played: CubicsOverFriction

    @classmethod
    def of(cls, nodes: Array, step: float, path: Array, contact: PressedContact, shear: Array) -> ShearBetweenPlays:
        """Fit springs with sliders to the plays of a touch.

        Parameters
        ----------
        nodes : (m,)
            Friction coefficients that were played, ascending.
        step : m
            Contact offset that was played to either side.
        path, contact
            See the class.
        shear : (m, n, 2)
            Shear on the indenter over Young's modulus at each of these frictions, without an offset.
        """
        count = len(path)
        pressed = [contact.at(np.full(count, offset)) for offset in (-step, 0.0, step)]
        stiffness, load = pressed[1]
        sliders = own_sliders(path, np.where(load[:, None] > 0, -shear, 0.0), stiffness, nodes[:, None] * load)
        rows = []
        for friction in nodes:
            less, none, more = (-sliders.pull(path, spring, friction * most) for spring, most in pressed)
            bent = Parabola.through(less, none, more, step)
            rows.append(np.concatenate([bent.level, bent.slope, bent.curvature], axis=1))
        return cls(path, contact, sliders, CubicsOverFriction(nodes, PchipInterpolator(nodes, np.array(rows)).c))

    def missed(self, frictions: Array, offset: Array, shift: Array, shear: Array, load: Array) -> Array:
        """Return the shear (n, 2) on the indenter, over Young's modulus, that interpolation between plays misses.

        Below the lowest friction that was played, what the springs miss of that play is in proportion to the friction.

        Parameters
        ----------
        frictions : (n,)
            Friction coefficient of each frame.
        offset : (n,) m
            How much deeper the indenter is than recorded.
        shift : (n, 2) m
            How much further along x and y of the gel it is.
        shear : (n, 2)
            Shear on the indenter, interpolated at these.
        load : (n,)
            Normal force; what is missed is in proportion to it, where it differs from that at the middle nu and mu. It
            is 0 without contact.
        """
        stiffness, usual = self.contact.at(offset)
        usual[load <= 0.0] = 0.0
        pull = self.sliders.pull(self.path + shift, stiffness, frictions * usual)
        share = frictions / self.played.nodes[0]
        missed: Array = _missed(pull, self.played.at(frictions), offset, share, shear, load, usual)
        return missed


@njit(cache=True)
def _missed(pull: Array, told: Array, offset: Array, share: Array, shear: Array, load: Array, usual: Array) -> Array:
    """Return the shear (n, 2) that interpolation misses, see `ShearBetweenPlays.missed`.

    Parameters
    ----------
    pull : (n, 2)
        Pull of the springs on the gel.
    told : (n, 6)
        What interpolation makes of the springs' shear on the indenter: level, slope and curvature over the offset.
    offset : (n,) m
        Offset of each frame.
    share : (n,)
        Friction over the lowest that was played.
    shear : (n, 2)
        Shear that is interpolated.
    load, usual : (n,)
        Normal force, and that of the middle nu and mu; 0 without contact.
    """
    missed = np.zeros((len(load), 2))
    for frame in range(len(load)):
        if not usual[frame] > 0.0:
            continue
        z, below = offset[frame], min(share[frame], 1.0) - 1.0
        for axis in range(2):
            played = told[frame, axis] + z * (told[frame, 2 + axis] + z * told[frame, 4 + axis])
            more = below * (shear[frame, axis] - played)
            missed[frame, axis] = load[frame] / usual[frame] * (more - pull[frame, axis] - played)
    return missed

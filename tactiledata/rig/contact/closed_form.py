"""Closed forms of the quasi-static contact of a rigid indenter with a flat elastic layer bonded to a rigid base.

Normal force: the stiffness of a touch at depth d is that of a flat punch on the layer, whose area is that of the
contact; for a ball the closed form of Dimitriadis et al. serves instead. Pressure is shared as by an elastic
foundation, in proportion to the local indentation, which gives centre of pressure and torques.
Tangential force: a spring per contact, Coulomb stick-slip, depending on the path.

Sources: E. K. Dimitriadis et al., Biophys. J. 82 (2002), eq. 11-13, bonded; P. D. Garcia and R. Garcia, Biophys. J. 114
(2018), flat punch, same coefficients; Hertz and Sneddon for the thick limit; K. L. Johnson, Contact Mechanics, 7.2, for
the tangential stiffness.

Assumptions: small strain, no adhesion, no rolling or twisting, indenter inside the pad.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import RealArray
from tactiledata.indenters.base import Indenter
from tactiledata.rig.contact.footprint import CEILING, Footprint
from tactiledata.rig.scenario.scenario import Material

TABLE = 601
"""Number of depths at which the law of one contact is tabulated, from 0 to ``CEILING``: every 5 µm."""
WIDEST = 2.0
"""Largest contact size over thickness at which the series are used; beyond it their tangent is."""


def _bonded_coefficients(poisson_ratio: float) -> tuple[float, float]:
    """Return the coefficients (alpha_0, beta_0) of Dimitriadis et al. for a layer bonded to its base."""
    nu = poisson_ratio
    alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu**2) / (1 - nu)
    beta = (0.6387 - 1.0277 * nu + 1.5164 * nu**2) / (1 - nu)
    return alpha, beta


def _thickness_factor(chi: RealArray, alpha: float, beta: float, third: float, fourth: float) -> RealArray:
    """Return the stiffness (n,) of a layer relative to a half-space, at contact size over thickness ``chi`` (n,).

    A series of fourth order, whose last two terms differ by shape in the weights of ``beta``; beyond ``WIDEST``, where
    it would turn down, its tangent.
    """
    series = np.polynomial.Polynomial(
        [
            1.0,
            -2 * alpha / np.pi,
            4 * alpha**2 / np.pi**2,
            -8 / np.pi**3 * (alpha**3 + third * beta),
            16 * alpha / np.pi**4 * (alpha**3 + fourth * beta),
        ]
    )
    inside = np.minimum(chi, WIDEST)
    return series(inside) + series.deriv()(WIDEST) * (chi - inside)


def sphere_force(depth: RealArray, radius: float, thickness: float, material: Material) -> RealArray:
    """Return the normal force (n,), N, of a ball on a bonded layer: Hertz's law times a series in sqrt(R d) / h.

    Parameters
    ----------
    depth : (n,), m
        Indentation depth, at least 0.
    radius : m
        Radius R of the ball.
    thickness : m
        Thickness h of the layer.
    material : Material
        Young's modulus and Poisson's ratio.
    """
    alpha, beta = _bonded_coefficients(material.poisson_ratio)
    chi = np.sqrt(radius * depth) / thickness
    factor = _thickness_factor(chi, alpha, beta, 4 * np.pi**2 / 15, 3 * np.pi**2 / 5)
    modulus = material.youngs_modulus / (1 - material.poisson_ratio**2)
    return 4 / 3 * modulus * np.sqrt(radius) * depth**1.5 * factor


def punch_stiffness(radius: RealArray, thickness: float, material: Material) -> RealArray:
    """Return the normal stiffness (n,), N/m, of a flat round punch on a bonded layer.

    Parameters
    ----------
    radius : (n,), m
        Radius of the punch.
    thickness : m
        Thickness of the layer.
    material : Material
        Young's modulus and Poisson's ratio.
    """
    alpha, beta = _bonded_coefficients(material.poisson_ratio)
    factor = _thickness_factor(radius / thickness, alpha, beta, np.pi**2 / 3, 2 * np.pi**2 / 3)
    return 2 * material.youngs_modulus / (1 - material.poisson_ratio**2) * radius * factor


def shear_stiffness(radius: RealArray, thickness: float, material: Material) -> RealArray:
    """Return the tangential stiffness (n,), N/m: the sum of a half-space and a thin layer, each exact in its limit.

    Parameters
    ----------
    radius : (n,), m
        Radius of the round contact.
    thickness : m
        Thickness of the layer.
    material : Material
        Young's modulus and Poisson's ratio.
    """
    shear_modulus = material.youngs_modulus / (2 * (1 + material.poisson_ratio))
    half_space = 8 * shear_modulus * radius / (2 - material.poisson_ratio)
    return half_space + shear_modulus * np.pi * radius**2 / thickness


@dataclass(frozen=True)
class ContactLaw:
    """The contact law of one indenter at one angle and place: columns over ``depth`` (k,).

    Parameters
    ----------
    depth : (k,) m
        Depth of the lowest point, from 0.
    force : (k,) N
        Normal force.
    stiffness : (k,) N/m
        Tangential stiffness.
    centre : (k, 3) m
        Centre of pressure relative to the tip (x, y) and the undeformed surface (z), gel axes.
    friction : float
        Coulomb's coefficient.
    radius : (k,) m
        Radius of the round contact of equal area.
    """

    depth: RealArray
    force: RealArray
    stiffness: RealArray
    centre: RealArray
    friction: float
    radius: RealArray

    def depth_at(self, force: float) -> float:
        """Return the depth, m, at which the normal force reaches a value, N; the deepest tabulated one otherwise."""
        return float(np.interp(force, self.force, self.depth))

    def columns_at(self, depth: RealArray) -> tuple[RealArray, RealArray, RealArray]:
        """Return force (n,), N, tangential stiffness (n,), N/m, and centre (n, 3), m, at depths (n,); 0 in air."""
        inside = np.clip(depth, 0.0, self.depth[-1])
        centre = np.stack([np.interp(inside, self.depth, self.centre[:, axis]) for axis in range(3)], axis=1)
        return np.interp(inside, self.depth, self.force), np.interp(inside, self.depth, self.stiffness), centre


def contact_law(indenter: Indenter, footprint: Footprint, thickness: float, material: Material) -> ContactLaw:
    """Return the tabulated law of one contact.

    Parameters
    ----------
    indenter : Indenter
        A sphere has a force law of its own; of other shapes the stiffness is that of a punch of equal area.
    footprint : Footprint
        The indenter over the gel, turned and not yet pressed.
    thickness : m
        Thickness of the gel.
    material : Material
        The gel's material.
    """
    depth = np.linspace(0.0, CEILING, TABLE)
    volume, square, first_moments = _foundation(footprint, depth)
    # volume over depth is the area of a flat punch, and pi R d for a ball, whose Hertzian radius is sqrt(R d)
    area = np.append(_face_area(footprint), volume[1:] / depth[1:])
    radius = np.sqrt(area / np.pi)
    if indenter.shape == "sphere":
        force = sphere_force(depth, indenter.sizes["radius"], thickness, material)
    else:
        rate = punch_stiffness(radius, thickness, material)
        force = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2 * np.diff(depth))])
    # centre of pressure: that of an elastic foundation
    touching = volume > 0
    centre = np.zeros((TABLE, 3))
    for axis, moment in enumerate(first_moments):
        centre[touching, axis] = moment[touching] / volume[touching]
    centre[touching, 2] = -square[touching] / volume[touching]
    if touching.any():
        centre[~touching, :2] = centre[touching][0, :2]
    return ContactLaw(depth, force, shear_stiffness(radius, thickness, material), centre, material.friction, radius)


def _face_area(footprint: Footprint) -> float:
    """Return the area, m², that touches at depth zero: that of a flat face, 0 for a point."""
    grid = footprint.grid
    face = grid.on_pad & (footprint.heights < 1e-9)
    return float(np.count_nonzero(face) * (grid.x[1] - grid.x[0]) * (grid.y[1] - grid.y[0]))


def _foundation(footprint: Footprint, depth: RealArray) -> tuple[RealArray, RealArray, list[RealArray]]:
    """Return integrals over the pad of s = max(d - height, 0): of s, of s², and of s x and s y, each (k,).

    ``depth`` (k,), m, are the depths d; x and y, m, count from the tip.

    Sorted heights and running sums give every depth at once.
    """
    grid = footprint.grid
    near = grid.on_pad & (footprint.heights < depth[-1])
    heights = footprint.heights[near]
    order = np.argsort(heights, kind="stable")
    heights = heights[order]
    x, y = np.meshgrid(grid.x - footprint.position[0], grid.y - footprint.position[1])
    cell = float(grid.x[1] - grid.x[0]) * float(grid.y[1] - grid.y[0])
    count = np.searchsorted(heights, depth, side="left")

    def running(values: RealArray) -> RealArray:
        return np.concatenate([[0.0], np.cumsum(values)])[count] * cell

    ones = running(np.ones(len(heights)))
    volume = np.maximum(depth * ones - running(heights), 0.0)
    square = np.maximum(depth**2 * ones - 2 * depth * running(heights) + running(heights**2), 0.0)
    moments: list[RealArray] = []
    for coordinate in (x[near][order], y[near][order]):
        moments.append(depth * running(coordinate) - running(coordinate * heights))
    return volume, square, moments


@dataclass(frozen=True)
class ContactHistory:
    """The contact over one trajectory, at n moments.

    Parameters
    ----------
    wrench : (n, 6), N, N m
        Wrench on the indenter, gel frame, torque about the gel's origin.
    drag : (n, 2) m
        Displacement of the gel's surface in the contact by friction.
    slipping : (n,) bool
        Whether the contact slides.
    """

    wrench: RealArray
    drag: RealArray
    slipping: NDArray[np.bool_]


def press_along(law: ContactLaw, positions: RealArray) -> ContactHistory:
    """Return the contact along a path of the indenter.

    Parameters
    ----------
    law : ContactLaw
        The tabulated law of this contact.
    positions : (n, 3), metres
        x, y of the tip and depth of the lowest point, close enough in time that each step is small.
    """
    force, stiffness, centre = law.columns_at(positions[:, 2])
    pull, slipping = stick_slip(positions[:, :2], force, stiffness, law.friction)
    on_indenter = np.concatenate([-pull, force[:, None]], axis=1)
    point = centre.copy()
    point[:, :2] += positions[:, :2]
    wrench = np.concatenate([on_indenter, np.cross(point, on_indenter)], axis=1)
    wrench[force <= 0] = 0.0
    drag = np.divide(pull, stiffness[:, None], out=np.zeros_like(pull), where=stiffness[:, None] > 0)
    return ContactHistory(wrench, drag, slipping)


def stick_slip(
    path: RealArray, normal: RealArray, stiffness: RealArray, friction: float
) -> tuple[RealArray, NDArray[np.bool_]]:
    """Return the pull (n, 2), N, of a moving indenter on the gel, and whether it slips (n,).

    The spring is loaded by increments, so that area gained under load starts free of stress (Mindlin); the pull never
    exceeds ``friction`` times the normal force.

    Parameters
    ----------
    path : (n, 2), metres
        Places of the indenter along the gel.
    normal : (n,), N
        Normal force.
    stiffness : (n,), N/m
        Tangential stiffness.
    friction : float
        Coulomb's coefficient.
    """
    count = len(path)
    pull = np.zeros((count, 2))
    slipping = np.zeros(count, dtype=bool)
    steps = np.diff(path, axis=0, prepend=path[:1]) * ((stiffness + np.roll(stiffness, 1)) / 2)[:, None]
    limits = friction * normal
    x = y = 0.0
    for index in np.flatnonzero(normal > 0):
        x += steps[index, 0]
        y += steps[index, 1]
        size = (x * x + y * y) ** 0.5
        limit = limits[index]
        if size > limit:
            x, y = x * limit / size, y * limit / size
            slipping[index] = True
        pull[index] = x, y
        if index + 1 < count and normal[index + 1] <= 0:
            x = y = 0.0
    return pull, slipping

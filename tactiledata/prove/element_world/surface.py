"""Contact and friction at points of a pad's outer surface: stiff springs that push, and Coulomb's law beside them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.prove.element_world.bodies import RigidBody
from tactiledata.prove.element_world.pad import Array, BrickPad

SPRING = 60.0
"""Pressure over Young's modulus that an overlap of one spacing of the grid would cause."""
ONSET = 2e-3
"""Distance, mm, over which the springs set in."""
ALONG = 0.25
"""Stiffness of the springs along the surface, as a share of that of those across it."""
NEW = 0.5
"""Share of a step for which the points that it brings into touch are carried along."""
FULL = 1.5
"""Stretch, in units of Coulomb's limit over the springs' stiffness, from which a point slips."""


@dataclass(frozen=True)
class Pose:
    """A body at a place.

    Parameters
    ----------
    body : RigidBody
        What is pressed on the pad.
    rotation : (3, 3)
        Of the body, gel_from_indenter.
    tip : (3,), mm
        Place of its tip, gel frame.
    """

    body: RigidBody
    rotation: Array
    tip: Array

    def gaps(self, points: Array) -> Array:
        """Return the distances (n,), mm, from the body of points (n, 3), gel frame."""
        return self.body.distance((points - self.tip) @ self.rotation)

    def directions(self, points: Array, gaps: Array) -> tuple[Array, Array]:
        """Return how distances grow (n, 3), and the directions (n, 3) in which points (n, 3) are pressed."""
        growth, push = self.body.directions((points - self.tip) @ self.rotation, gaps)
        return growth @ self.rotation.T, push @ self.rotation.T


@dataclass(frozen=True)
class Held:
    """What the surface remembers of the step before, at each of its points.

    Parameters
    ----------
    points : (f, p, 3), mm
        Places of the points.
    gap : (f, p), mm
        Distances from the body.
    stretch : (f, p, 3)
        Tractions on the gel along the surface that the springs would have without a limit, over Young's modulus.
    tip : (3,), mm
        Place of the body's tip.
    """

    points: Array
    gap: Array
    stretch: Array
    tip: Array


@dataclass(frozen=True)
class Pressed:
    """Tractions of a body on the surface, over Young's modulus, and how they yield.

    Parameters
    ----------
    traction : (f, p, 3)
        On the gel, by area at rest.
    stretch : (f, p, 3)
        See `Held`, at most `FULL` times the limit.
    yields : (f, p, 3, 3), 1/mm
        By how much the traction falls as a point moves.
    gap : (f, p), mm
        Distances from the body.
    points : (f, p, 3), mm
        Places of the points.
    touching, slipping : (f, p) bool
        Whether a point is pressed, and whether it slips.
    """

    traction: Array
    stretch: Array
    yields: Array
    gap: Array
    points: Array
    touching: NDArray[np.bool_]
    slipping: NDArray[np.bool_]


class SpringSurface:
    """The contact law on a pad's outer surface.

    Parameters
    ----------
    pad : BrickPad
        The bricks.
    friction : float
        Coulomb's coefficient.
    spacing : mm
        Spacing of the grid under the contact, which sets how stiff the springs are.
    """

    def __init__(self, pad: BrickPad, friction: float, spacing: float) -> None:
        self._pad, self._friction, self._spring = pad, friction, SPRING / spacing

    def points(self, displacements: Array) -> Array:
        """Return the places (f, p, 3), mm, of the points under displacements (n, 3) of the nodes."""
        return np.matmul(self._pad.shares, (self._pad.places + displacements)[self._pad.facets])

    def at_rest(self, pose: Pose) -> Held:
        """Return the memory of a surface that nothing has touched."""
        points = self.points(np.zeros_like(self._pad.places))
        gap = pose.gaps(points.reshape(-1, 3))
        return Held(points, gap.reshape(points.shape[:2]), np.zeros_like(points), pose.tip)

    def press(self, displacements: Array, pose: Pose, held: Held) -> Pressed:
        """Return what a body does to the surface.

        Parameters
        ----------
        displacements : (n, 3), mm
            Of the nodes.
        pose : Pose
            The body.
        held : Held
            The step before.
        """
        points = self.points(displacements)
        gap = pose.gaps(points.reshape(-1, 3)).reshape(points.shape[:2])
        touching = gap < ONSET
        rows = np.nonzero(touching)
        g = gap[rows]
        growth, n = pose.directions(points[rows], g)
        overlap = np.where(g < -ONSET, -g, (ONSET - g) ** 2 / (4.0 * ONSET))
        slope = np.where(g < -ONSET, 1.0, (ONSET - g) / (2.0 * ONSET))
        pressure = self._spring * overlap
        limit = self._friction * pressure
        # a point that a step brings into touch is carried along for half of the step
        share = ALONG * np.where(held.gap[rows] < ONSET, 1.0, NEW)
        across = np.eye(3) - n[:, :, None] * n[:, None, :]
        moved = points[rows] - held.points[rows] - (pose.tip - held.tip)
        stretch = np.einsum("nij,nj->ni", across, held.stretch[rows] - (self._spring * share)[:, None] * moved)
        size = np.maximum(np.linalg.norm(stretch, axis=1), 1e-15)
        along = stretch / size[:, None]
        slips = (size >= FULL * limit) & (share > 0.0)
        part = np.minimum(size / np.maximum(limit, 1e-15), FULL)
        kept = np.minimum(size, FULL * limit)[:, None] * along
        # the pull bends smoothly from the springs' to Coulomb's limit, which it has at FULL
        pull = part - 4.0 / 27.0 * part**3
        steep = 1.0 - 4.0 / 9.0 * part**2
        rate = self._spring * share
        beside = (rate * limit * pull / size)[:, None, None] * (across - along[:, :, None] * along[:, None, :])
        ahead = (rate * steep)[:, None, None] * (along[:, :, None] * along[:, None, :])
        push = n + (self._friction * (pull - part * steep))[:, None] * along
        yields = beside + ahead
        yields += (self._spring * slope)[:, None, None] * push[:, :, None] * growth[:, None, :]
        pull = (limit * pull)[:, None] * along
        out = [np.zeros((*points.shape[:2], *part.shape[1:])) for part in (n, n, yields)]
        out[0][rows], out[1][rows], out[2][rows] = pressure[:, None] * n + pull, kept, yields
        is_slipping = np.zeros_like(touching)
        is_slipping[rows] = slips
        return Pressed(out[0], out[1], out[2], gap, points, touching, is_slipping)

    def on_bricks(
        self, tractions: Array, yields: Array, with_stiffness: bool = True
    ) -> tuple[Array, Array, NDArray[np.intp]]:
        """Return forces (f, 4, 3) on the corners of facets, what they yield (f, 4, 3, 4, 3), and the facets (f,).

        Parameters
        ----------
        tractions : (f, p, 3)
            Of all facets; only those that are pressed are returned.
        yields : (f, p, 3, 3)
            How tractions fall as points move.
        with_stiffness : bool
            Whether to find what they yield; else it is zero.
        """
        pad = self._pad
        rows = np.flatnonzero(yields.any(axis=(1, 2, 3)) | tractions.any(axis=(1, 2)))
        weighed = pad.shares[rows] * pad.areas[rows][:, :, None]
        force = np.einsum("fpa,fpi->fai", weighed, tractions[rows])
        if not with_stiffness:
            return force, np.zeros((len(rows), 4, 3, 4, 3)), rows
        product = weighed[..., :, None] * pad.shares[rows][..., None, :]
        product = product.reshape(*weighed.shape[:2], 16).transpose(0, 2, 1)
        stiffness = np.matmul(product, yields[rows].reshape(*weighed.shape[:2], 9))
        return force, stiffness.reshape(len(rows), 4, 4, 3, 3).transpose(0, 1, 3, 2, 4), rows

    def wrench(self, pressed: Pressed) -> Array:
        """Return the wrench (6,), mm² and mm³, of the gel on the body, about the gel's origin."""
        force = -self._pad.areas[..., None] * pressed.traction
        torque = np.cross(pressed.points, force)
        return np.concatenate([force.sum(axis=(0, 1)), torque.sum(axis=(0, 1))])

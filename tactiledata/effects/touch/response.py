"""What effects ask of the simulation below them, and what it answers; whoever simulates implements `BaseResponse`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array


@dataclass(frozen=True)
class ContactResponse:
    """What the gel did at the n frames of one touch. Rows that could not be solved are NaN.

    Parameters
    ----------
    wrench : (n, 6) N, N m
        What the gel exerts on the indenter, gel frame, torque about the gel's origin: pressing gives fz > 0.
        Exactly 0 in free air.
    area : (n,) m^2
        Of the contact; 0 in free air.
    centre : (n, 2) m
        Of the contact, gel frame; below the tip in free air.
    depth : (n,) m
        How far the tip is below the undeformed surface; negative above it.
    sliding : (n,) bool
        Whether the whole contact slides.
    spring : (n,) N/m
        Stiffness along the gel of the contact where it sticks; 0 in free air.
    """

    wrench: Array
    area: Array
    centre: Array
    depth: Array
    sliding: NDArray[np.bool_]
    spring: Array

    @property
    def radius(self) -> Array:
        """Radius (n,), m, of the circle with the contact's area."""
        return np.sqrt(self.area / np.pi)

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Frames (n,) in contact."""
        return self.area > 0


@dataclass(frozen=True)
class SoftSpot:
    """A place (x, y) m where the gel's modulus is multiplied by 1 - loss exp(-r^2 / (2 radius^2)), r m away from it."""

    x: float
    y: float
    radius: float
    loss: float


@dataclass(frozen=True)
class GelVariant:
    """A gel, or an indenter, that differs from the nominal one; what is left at its default is nominal.

    Parameters
    ----------
    c20, c30 : ratios to C10
        Yeoh's further terms in the energy of the isochoric deformation: W = C10 (I - 3) + C20 (I - 3)^2 + C30 (I -
        3)^3.
    thickness : factor
        On the height of the pad over its rigid base. The outer surface stays where it is; the base moves.
    dome : 1/m^2
        The outer surface falls by ``thickness * dome * r^2`` at the distance r from the middle, beside its own dome.
    skin : m
        A stiff layer on the outer surface, as the thickness of gel that would resist stretching as much as it does
        beyond the gel in its place: (E_skin / E - 1) t. The uppermost cells, of height h, are stiffer by 1 + skin / h.
    indenter_scale : factor
        On all lengths of the indenter; its tip stays.
    spots : tuple of SoftSpot
        Through the whole thickness, their factors multiplied.
    """

    c20: float = 0.0
    c30: float = 0.0
    thickness: float = 1.0
    dome: float = 0.0
    skin: float = 0.0
    indenter_scale: float = 1.0
    spots: tuple[SoftSpot, ...] = ()

    def together_with(self, other: GelVariant) -> GelVariant:
        """The gel that has the deviations of both: factors multiplied, all else added."""
        return GelVariant(
            self.c20 + other.c20,
            self.c30 + other.c30,
            self.thickness * other.thickness,
            self.dome + other.dome,
            self.skin + other.skin,
            self.indenter_scale * other.indenter_scale,
            self.spots + other.spots,
        )


class BaseResponse(Protocol):
    """A simulation of one touch, that can be asked again with changed arguments."""

    def respond(self, offset: Array, shift: Array, friction: Array) -> ContactResponse:
        """The touch with an indenter that is elsewhere, or slides otherwise, than recorded.

        Parameters
        ----------
        offset : (n,) m
            Deeper, along the gel frame's -z.
        shift : (n, 2) m
            Along x and y of the gel frame.
        friction : (n,)
            Factor on Coulomb's coefficient at each frame.
        """
        ...

    def difference(self, variant: GelVariant) -> Array:
        """Wrench (n, 6) of the recorded touch with a variant of the gel, less that with the nominal one."""
        ...

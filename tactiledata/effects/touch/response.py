"""The interface between effects and the simulation below them, which implements `BaseResponse`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array


@dataclass(frozen=True)
class ContactResponse:
    """Answer of the gel at the n frames of one touch; rows that could not be solved are NaN.

    Parameters
    ----------
    wrench : (n, 6) N, N m
        Wrench that the gel exerts on the indenter, gel frame, torque about the origin of the gel: a press gives fz > 0.
        Exactly 0 in free air.
    area : (n,) m^2
        Area of the contact; 0 in free air.
    centre : (n, 2) m
        Centre of the contact, gel frame; below the tip in free air.
    depth : (n,) m
        Depth of the tip below the undeformed surface; negative above it.
    sliding : (n,) bool
        Whether the whole contact slides.
    spring : (n,) N/m
        Tangential stiffness of the contact where it sticks; 0 in free air.
    """

    wrench: Array
    area: Array
    centre: Array
    depth: Array
    sliding: NDArray[np.bool_]
    spring: Array

    @property
    def radius(self) -> Array:
        """Radius (n,), m, of the circle that has the area of the contact."""
        return np.sqrt(self.area / np.pi)

    @property
    def touching(self) -> NDArray[np.bool_]:
        """Whether the indenter is in contact, for each frame (n,)."""
        return self.area > 0


@dataclass(frozen=True)
class SoftSpot:
    """A soft place of the gel: at the distance r the modulus is multiplied by 1 - loss exp(-r^2 / (2 radius^2)).

    Parameters
    ----------
    x, y : float
        Middle of the spot, m, gel frame.
    radius : float
        Standard deviation of the spot, m.
    loss : float
        Share of the modulus that is lost in the middle, below 1.
    """

    x: float
    y: float
    radius: float
    loss: float


@dataclass(frozen=True)
class GelVariant:
    """A gel, or an indenter, that differs from the nominal one; fields at their defaults are nominal.

    Parameters
    ----------
    c20, c30 : float
        Ratios to C10 of the further terms of Yeoh's energy, W = C10 (I - 3) + C20 (I - 3)^2 + C30 (I - 3)^3, I of the
        isochoric deformation.
    thickness : float
        Factor on the height of the pad over its rigid base. The outer surface stays where it is; the base moves.
    dome : float
        1/m^2: the outer surface falls by ``thickness * dome * r^2`` at the distance r from the middle, beside its own
        dome.
    skin : float
        Stiffness of a layer on the outer surface against stretching, beyond the gel in its place, as a thickness of
        gel, m: (E_skin / E - 1) t. The uppermost cells, of height h, are stiffer by 1 + skin / h.
    indenter_scale : float
        Factor on all lengths of the indenter; its tip stays.
    spots : tuple of SoftSpot
        Soft spots through the whole thickness; their factors are multiplied.
    """

    c20: float = 0.0
    c30: float = 0.0
    thickness: float = 1.0
    dome: float = 0.0
    skin: float = 0.0
    indenter_scale: float = 1.0
    spots: tuple[SoftSpot, ...] = ()

    def together_with(self, other: GelVariant) -> GelVariant:
        """Return the gel that has the deviations of both: factors are multiplied, all else is added."""
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
    """A simulation of one touch, which can be asked again with changed arguments."""

    def respond(self, offset: Array, shift: Array, friction: Array) -> ContactResponse:
        """Return the answer of the gel where the indenter is elsewhere than recorded, or friction is another.

        Parameters
        ----------
        offset : (n,) m
            How much deeper the indenter is, along -z of the gel frame.
        shift : (n, 2) m
            How much further the indenter is along x and y of the gel frame.
        friction : (n,)
            Factor on Coulomb's coefficient at each frame.
        """
        ...

    def difference(self, variant: GelVariant) -> Array:
        """Wrench (n, 6), N and N m, of the recorded touch with a variant of the gel, less that with the nominal gel."""
        ...

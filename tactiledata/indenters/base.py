"""What every indenter offers: a solid with a signed distance and a mesh, in its own frame."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
import trimesh
from numpy.typing import NDArray


class Indenter(ABC):
    """A rigid solid that touches the gel.

    Frame *indenter*: origin at the tip (the point or face that touches first), +z into the body, so the body lies in
    z >= 0. Sizes are metres (angles radians), keyword arguments of the constructor, with the defaults of a usual print.
    """

    shape: ClassVar[str]
    """Name in the table of indenters and in ``log.yaml``."""
    title: ClassVar[str]
    """What it is, in a few words."""

    @property
    @abstractmethod
    def sizes(self) -> dict[str, float]:
        """Sizes by name, m or rad, as the constructor takes them."""

    @abstractmethod
    def signed_distance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distances (n,), metres, of points (n, 3) in the indenter frame to the surface; negative inside."""

    @abstractmethod
    def mesh(self) -> trimesh.Trimesh:
        """The surface as a watertight mesh, metres, indenter frame, normals outward."""

    @abstractmethod
    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """The lowest z of the body above (x, y), metres, indenter frame; ``inf`` where the body is not.

        Its rigid footprint when it presses head-on: a gel surface at z = d is pushed down by ``max(d - height, 0)``.
        """

"""What every indenter offers: a solid with a signed distance and a mesh, in its own frame."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
import trimesh
from numpy.typing import NDArray

from tactiledata.errors import UsageError

LARGEST_PART = 0.2
"""Largest plausible indenter, metres: ten times the gel. A larger one was stated in another unit."""
SMALLEST_PART = 0.2e-3
"""Smallest plausible indenter, metres: below what printers make and the gel shows."""


class Indenter(ABC):
    """A rigid solid that touches the gel.

    Frame *indenter*: origin at the tip (the point or face that touches first), +z into the body, so the body lies in
    z >= 0. Sizes are metres (angles radians), keyword arguments of the constructor, with the defaults of a usual print.
    """

    shape: ClassVar[str]
    """Name in the table of indenters and in ``log.yaml``."""
    title: ClassVar[str]
    """What it is, in a few words."""
    is_exact_inside: ClassVar[bool] = True
    """Whether ``signed_distance`` is exact inside the body too; outside it is exact for all. Where false, its
    magnitude inside is at most the true depth (a safe bound); the sign is right everywhere."""

    @property
    @abstractmethod
    def sizes(self) -> dict[str, float]:
        """Sizes by name, m or rad, as the constructor takes them."""

    @property
    @abstractmethod
    def document(self) -> dict[str, Any]:
        """The indenter as ``log.yaml`` states it, without its pose; ``make_indenter`` takes it back."""

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
        ``x`` and ``y`` may have any common shape.
        """


@dataclass(frozen=True)
class ParametricIndenter(Indenter):
    """An indenter whose dataclass fields are its sizes.

    Raises
    ------
    UsageError
        A size that is not a positive finite number, sizes that contradict one another, or a part that is larger than
        ``LARGEST_PART`` or smaller than ``SMALLEST_PART`` (another unit, most likely).
    """

    def __post_init__(self) -> None:
        for name, value in self.sizes.items():
            is_number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
            if not is_number or not math.isfinite(value) or value <= 0:
                raise UsageError(
                    f"size {name!r} of indenter {self.shape!r} is {value!r}",
                    "a positive finite number",
                    f"Sizes of {self.shape}: {', '.join(self.sizes)}; lengths in metres, angles in radians.",
                    size=name,
                    value=value,
                )
        self._check_unit()
        for holds, law in self._laws():
            if not holds:
                raise UsageError(
                    f"sizes of indenter {self.shape!r} contradict one another: {self.sizes}",
                    law,
                    "Correct the sizes; lengths in metres, angles in radians.",
                    law=law,
                )

    def _check_unit(self) -> None:
        largest = max(value for name, value in self.sizes.items() if not name.endswith("angle"))
        if largest > LARGEST_PART or largest < SMALLEST_PART:
            raise UsageError(
                f"the largest size of indenter {self.shape!r} is {largest:.4g} m ({self.sizes})",
                f"between {SMALLEST_PART} m and {LARGEST_PART} m",
                "Sizes are in metres: 4 mm is 0.004.",
                largest=largest,
            )

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        """What the sizes must obey together, each with its wording; evaluated on positive sizes."""
        return ()

    @property
    def sizes(self) -> dict[str, float]:
        """Sizes by name, m or rad, as the constructor takes them."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def document(self) -> dict[str, Any]:
        """The indenter as ``log.yaml`` states it, without its pose."""
        return {"shape": self.shape, **{name: float(value) for name, value in self.sizes.items()}}

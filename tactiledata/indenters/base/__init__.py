"""What does every indenter offer? A solid with a signed distance, a mesh and a height, in its own frame.

- `Indenter`: the interface, which solver, rig and pages use.
- `ParametricIndenter`: an indenter whose dataclass fields are its sizes, with the checks of the sizes.
- ``planar``: exact signed distances of plane figures, and of the solids that they sweep.
- ``surface``: watertight meshes of swept and revolved figures. ``turned``: how far a turned solid reaches down.

Nothing here knows a member of the family.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError

if TYPE_CHECKING:
    import trimesh

LARGEST_PART = 0.2
"""Largest plausible size of an indenter, m: ten times the gel. A larger one was stated in another unit."""
SMALLEST_PART = 0.2e-3
"""Smallest plausible size of an indenter, m: below what printers make and the gel shows."""


class Indenter(ABC):
    """A rigid solid that touches the gel.

    Frame *indenter*: origin at the tip (the point or face that touches first), +z into the body, so the body lies in
    z >= 0. Sizes are keyword arguments of the constructor, m (angles rad), with the defaults of a usual print.
    """

    shape: ClassVar[str]
    """Name in the table of indenters and in ``log.yaml``."""
    title: ClassVar[str]
    """Description in a few words, for tables."""
    is_exact_inside: ClassVar[bool] = True
    """Whether ``signed_distance`` is exact inside the body, too; outside it always is. Where false, its magnitude
    inside is at most the true depth, a safe bound; the sign is right everywhere."""

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
        """Signed distances (n,), m, of points (n, 3), m, indenter frame, to the surface; negative inside."""

    @abstractmethod
    def mesh(self) -> trimesh.Trimesh:
        """Return the surface as a watertight mesh, m, indenter frame, normals outward."""

    @abstractmethod
    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Lowest z of the body above (x, y), m, indenter frame; ``inf`` where the body is not.

        A gel surface at z = d that the body presses head-on is pushed down by ``max(d - height, 0)``.
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
        """Refuse sizes that no such solid can have."""
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
        """Refuse a solid that is so large or small that its sizes are hardly in metres."""
        largest = max(value for name, value in self.sizes.items() if not name.endswith("angle"))
        if largest > LARGEST_PART or largest < SMALLEST_PART:
            raise UsageError(
                f"the largest size of indenter {self.shape!r} is {largest:.4g} m ({self.sizes})",
                f"between {SMALLEST_PART} m and {LARGEST_PART} m",
                "Sizes are in metres: 4 mm is 0.004.",
                largest=largest,
            )

    def _laws(self) -> tuple[tuple[bool, str], ...]:
        """Return what the sizes must obey together: whether it holds, and its wording; sizes are positive by then."""
        return ()

    @property
    def sizes(self) -> dict[str, float]:
        """Sizes by name, m or rad, as the constructor takes them."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @property
    def document(self) -> dict[str, Any]:
        """The indenter as ``log.yaml`` states it, without its pose."""
        return {"shape": self.shape, **{name: float(value) for name, value in self.sizes.items()}}

"""One recorded touch, and all that effects may depend on."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.errors import UsageError
from tactiledata.gel.material import GelMaterial
from tactiledata.indenters.base import Indenter
from tactiledata.sensors.base import GelGeometry

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Touch:
    """A trajectory of n frames.

    Parameters
    ----------
    seconds : (n,)
        Since the start of the recording, strictly ascending.
    poses : (n, 4, 4)
        gel_from_indenter as recorded, metres; NaN where unknown.
    indenter : Indenter
    material : GelMaterial
        With which the base simulation was made.
    geometry : GelGeometry
        Of the gel.
    sensor, indenter_name, mount : str
        Serial of the sensor, name of the indenter in the log, and which mounting of it; empty where unknown.
    gravity : (n, 3) m/s^2, optional
        The acceleration of gravity in the gel frame, pointing down.
    joints : (n, 6) rad, optional
    powered : (n,) s, optional
        Since the sensor was switched on.
    earlier_depth : (n,) m, optional
        The deepest press near this spot in earlier touches; 0 where it is untouched.
    earlier_contacts : (n,), optional
        How many touches this spot had before.
    selection : (low, high) N, optional
        The range of measured force norms to which the data were cut.
    tare : (n,) bool, optional
        Frames of free air from which the measured zero was taken.

    Raises
    ------
    UsageError
        Arrays that do not fit one another, or times that do not ascend.
    """

    seconds: Array
    poses: Array
    indenter: Indenter
    material: GelMaterial
    geometry: GelGeometry
    sensor: str = ""
    indenter_name: str = ""
    mount: str = ""
    gravity: Array | None = None
    joints: Array | None = None
    powered: Array | None = None
    earlier_depth: Array | None = None
    earlier_contacts: Array | None = None
    selection: tuple[float, float] | None = None
    tare: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        shapes = {"poses": (4, 4), "gravity": (3,), "joints": (6,)}
        for field in fields(self):
            value = getattr(self, field.name)
            wanted = (len(self.seconds), *shapes.get(field.name, ()))
            if isinstance(value, np.ndarray) and value.shape != wanted:
                raise UsageError(f"{field.name} of a touch has shape {value.shape}", f"{wanted}", "Align the frames.")
        if not (np.diff(self.seconds) > 0).all():
            raise UsageError("the times of a touch do not ascend", "strictly ascending seconds", "Sort the frames.")

    def __len__(self) -> int:
        return len(self.seconds)

    @property
    def tips(self) -> Array:
        """Recorded positions (n, 3), m, of the indenter's tip in the gel frame."""
        return self.poses[:, :3, 3]

    @cached_property
    def lateral_steps(self) -> Array:
        """Way (n,), m, of the tip along the gel since the frame before; 0 at the first."""
        return np.linalg.norm(np.diff(self.tips[:, :2], axis=0, prepend=self.tips[:1, :2]), axis=1)

    @cached_property
    def time_steps(self) -> Array:
        """Time (n,), s, since the frame before; 0 at the first."""
        return np.diff(self.seconds, prepend=self.seconds[:1])

    @property
    def lateral_speed(self) -> Array:
        """Speed (n,), m/s, of the tip along the gel on its way into each frame; 0 at the first."""
        return np.divide(self.lateral_steps, self.time_steps, out=np.zeros(len(self)), where=self.time_steps > 0)

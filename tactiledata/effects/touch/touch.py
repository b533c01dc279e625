"""One recorded touch, with all that effects may depend on."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.effects.touch.earlier_places import DELAYS
from tactiledata.effects.touch.felt_acceleration import FREQUENCIES
from tactiledata.effects.touch.last_move import WAYS
from tactiledata.errors import UsageError
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.indenters.base import Indenter
from tactiledata.sensors.base import GelGeometry


@dataclass(frozen=True)
class Touch:
    """A recorded touch of n frames, one trajectory.

    Parameters
    ----------
    seconds : (n,) s
        Time since the start of the recording, strictly ascending.
    poses : (n, 4, 4)
        gel_from_indenter as recorded, m; NaN where unknown.
    indenter : Indenter
        The solid that touches.
    material : GelMaterial
        Material of the base simulation.
    geometry : GelGeometry
        Shape of the gel.
    sensor : str
        Serial of the sensor; empty where unknown.
    indenter_name : str
        Name of the indenter in the log; empty where unknown.
    mount : str
        Which mounting of the indenter it is; empty where unknown.
    gravity : (n, 3) m/s^2, optional
        Acceleration of gravity in the gel frame, pointing down.
    joints : (n, 6) rad, optional
        Angles of the arm's joints.
    powered : (n,) s, optional
        Time since the sensor was switched on.
    earlier_depth : (n,) m, optional
        Depth at which this indenter would do to the gel here what the strongest earlier touch has done, as
        `tactiledata.effects.touch.imprint` compares them; 0 where the gel is untouched.
    earlier_contacts : (n,), optional
        Number of earlier touches of this spot.
    selection : (low, high) N, optional
        Range of measured force norms to which the data were cut.
    tare : (n,) bool, optional
        Frames of free air from which the measured zero was taken.
    pace : (n,) m/s, optional
        Speed of the tip along the gel, or of its last move where it stands: see
        `tactiledata.effects.touch.last_move`. Effects take it from the frames where it is not given.
    rest : (n,) s, optional
        Time for which the tip has stood, from the same function.
    last_ways : (n, w) s, optional
        Time for which the tip has been within each distance of `tactiledata.effects.touch.last_move.WAYS`.
    felt_accelerations : (n, f, 3) m/s^2, optional
        Acceleration of a tool that vibrates on the arm, gel frame, for each of
        `tactiledata.effects.touch.felt_acceleration.FREQUENCIES`.
    earlier_places : (n, d, 3) m, optional
        Positions of the tip at each of `tactiledata.effects.touch.earlier_places.DELAYS` before a frame, gel frame.
    gel_from_sensor : (n, 4, 4), optional
        Pose of the force sensor, m.
    sensor_weight : (n, 6) N, N m, optional
        Weight of the tool as the force sensor reads it, in its own frame, since it was set to zero. It is subtracted
        from measured wrenches, but limits and steps of the sensor act on the sum.

    Raises
    ------
    UsageError
        Arrays whose shapes do not fit one another, or times that do not ascend.
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
    pace: Array | None = None
    rest: Array | None = None
    last_ways: Array | None = None
    felt_accelerations: Array | None = None
    earlier_places: Array | None = None
    gel_from_sensor: Array | None = None
    sensor_weight: Array | None = None

    def __post_init__(self) -> None:
        """Refuse arrays whose shapes do not fit the frames, and times that do not ascend."""
        shapes = {
            "poses": (4, 4),
            "gravity": (3,),
            "joints": (6,),
            "last_ways": (len(WAYS),),
            "felt_accelerations": (len(FREQUENCIES), 3),
            "earlier_places": (len(DELAYS), 3),
            "gel_from_sensor": (4, 4),
            "sensor_weight": (6,),
        }
        for field in fields(self):
            value = getattr(self, field.name)
            expected = (len(self.seconds), *shapes.get(field.name, ()))
            if isinstance(value, np.ndarray) and value.shape != expected:
                raise UsageError(f"{field.name} of a touch has shape {value.shape}", f"{expected}", "Align the frames.")
        if not (np.diff(self.seconds) > 0).all():
            raise UsageError("the times of a touch do not ascend", "strictly ascending seconds", "Sort the frames.")

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.seconds)

    @property
    def tips(self) -> Array:
        """Recorded positions (n, 3), m, of the tip of the indenter in the gel frame."""
        return self.poses[:, :3, 3]

    @cached_property
    def lateral_steps(self) -> Array:
        """Distance (n,), m, of the tip along the gel since the frame before; 0 at the first."""
        return np.linalg.norm(np.diff(self.tips[:, :2], axis=0, prepend=self.tips[:1, :2]), axis=1)

    @cached_property
    def time_steps(self) -> Array:
        """Time (n,), s, since the frame before; 0 at the first."""
        return np.diff(self.seconds, prepend=self.seconds[:1])

    @property
    def lateral_speed(self) -> Array:
        """Mean speed (n,), m/s, of the tip along the gel since the frame before; 0 at the first."""
        return np.divide(self.lateral_steps, self.time_steps, out=np.zeros(len(self)), where=self.time_steps > 0)

    def on(self, material: GelMaterial) -> Touch:
        """Return the touch on a gel of another material; what follows from its path is kept, and nothing is checked."""
        touch = object.__new__(Touch)
        # made here once, and not anew on each gel
        kept = ("lateral_steps", "time_steps", "_load_from_wrench", "_wrench_from_load")
        touch.__dict__.update(self.__dict__, **{name: getattr(self, name) for name in kept}, material=material)
        return touch

    def to_sensor(self, wrench: Array) -> Array:
        """Reading (n, 6) of the sensor, in its own frame, for a wrench (n, 6) on the indenter, gel frame.

        The load on the sensor is the opposite of the wrench, plus the weight of the tool. Where the touch does not
        state the frame of the sensor, it counts as that of the gel.
        """
        load = np.einsum("nij,nj->ni", self._load_from_wrench, wrench)
        return load if self.sensor_weight is None else load + self.sensor_weight

    def from_sensor(self, reading: Array) -> Array:
        """Wrench (n, 6) on the indenter, gel frame, for a reading (n, 6) of the sensor: the inverse of `to_sensor`."""
        load = reading if self.sensor_weight is None else reading - self.sensor_weight
        return np.einsum("nij,nj->ni", self._wrench_from_load, load)

    @cached_property
    def _load_from_wrench(self) -> Array:
        """Matrix (n, 6, 6) that makes of a wrench on the indenter, gel frame, the load on the sensor in its frame."""
        turn, lever = self._sensor_frame
        matrix = np.zeros((len(self), 6, 6))
        matrix[:, :3, :3] = matrix[:, 3:, 3:] = -np.swapaxes(turn, 1, 2)
        matrix[:, 3:, :3] = np.swapaxes(turn, 1, 2) @ lever
        return matrix

    @cached_property
    def _wrench_from_load(self) -> Array:
        """Matrix (n, 6, 6) that makes of a load on the sensor, in its frame, the wrench on the indenter, gel frame."""
        turn, lever = self._sensor_frame
        matrix = np.zeros((len(self), 6, 6))
        matrix[:, :3, :3] = matrix[:, 3:, 3:] = -turn
        matrix[:, 3:, :3] = -lever @ turn
        return matrix

    @property
    def _sensor_frame(self) -> tuple[Array, Array]:
        """Axes (n, 3, 3) of the sensor in the gel frame, and matrices (n, 3, 3), m: torques of unit forces at it."""
        if self.gel_from_sensor is None:
            return np.tile(np.eye(3), (len(self), 1, 1)), np.zeros((len(self), 3, 3))
        x, y, z = self.gel_from_sensor[:, :3, 3].T
        zero = np.zeros(len(self))
        rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
        return self.gel_from_sensor[:, :3, :3], np.moveaxis(np.array(rows), 2, 0)

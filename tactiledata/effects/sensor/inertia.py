"""The force sensor reads the acceleration of the tool, which vibrates on the arm when it stops."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.felt_acceleration import FREQUENCIES, felt_at
from tactiledata.effects.touch.state import TouchState, wrench_at
from tactiledata.effects.touch.touch import Touch


class Inertia(Effect):
    """A force of inertia, F -> F - m a, a the acceleration, gel frame, of a tool that vibrates at ``frequency``.

    The force acts at the tool's centre of gravity, which lies between the gel's origin and that of the force sensor:
    ``centre`` is its place as a share of that way. Where a touch does not state the sensor's frame, it is at the gel's.

    The tool starts late and rings when the tip stops (`felt_acceleration`, from the stream of poses). In a touch
    without such a stream, a is the acceleration of the tip, differentiated twice from the frames; they must then be
    dense enough to show a start or a stop. The force is added to the reading: it neither moves the indenter nor acts on
    the gel.

    Source: Newton; 0.5 kg at 0.2 m/s^2 is 0.1 N.
    """

    name = "inertia"
    title = "inertia of the tool and vibration of the arm"
    slot = "sensor"
    parameters = (
        strength(
            "mass", "kg", "mass between the sensor and the contact",
            bounds=(-3.0, 3.0), plausible=(-1.0, 1.0), deviation=0.4, source="sensor, holder and indenter: 0.1 to 1 kg",
        ),
        shape(
            "frequency", "Hz", "of the arm's mode on which the tool swings",
            default=15.0, bounds=(FREQUENCIES[0], FREQUENCIES[-1]), grid=FREQUENCIES, source="10 to 25 Hz; estimate",
        ),
        shape(
            "centre", "1", "place of the centre of gravity: 0 at the gel, 1 at the force sensor",
            default=0.5, bounds=(-0.5, 1.5), grid=(0.2, 0.8), source="holders of sensor and indenter; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("lag", "tool_weight")
    distinguishing_trial = "Start and stop in free air: peaks at the accelerations, none at constant speed."
    detectability = "0.5 kg at 0.2 m/s^2 is 0.1 N, at starts and for some tenths of a second after stops only."
    reference = "Newton's second law"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        force = -values["mass"] * _acceleration(state.touch, values["frequency"])
        pose = state.touch.gel_from_sensor
        at = np.zeros_like(force) if pose is None else values["centre"] * pose[:, :3, 3]
        return state.with_reading(state.wrench + wrench_at(force, at))


def _acceleration(touch: Touch, frequency: float) -> Array:
    """Acceleration (n, 3), m/s^2, gel frame, of the tool: from the stream of poses, else from the frames."""
    if touch.felt_accelerations is not None:
        return felt_at(touch.felt_accelerations, frequency)
    if len(touch) < 3:
        return np.zeros((len(touch), 3))
    velocity = np.gradient(touch.tips, touch.seconds, axis=0)
    acceleration: Array = np.gradient(velocity, touch.seconds, axis=0)
    return acceleration

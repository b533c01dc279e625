"""The force sensor is turned against the frame that was assumed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState

_MOUNT = "screw holes and adapters; estimate"


class FrameRotation(Effect):
    """A rotation of what the sensor reads, F -> R F and M -> R M, R of the rotation vector (tilt_x, tilt_y, yaw).

    Force and torque are those in the sensor's own frame, about its origin. Where a touch does not state that frame, it
    counts as that of the gel. The norm of the force stays.

    Source: the frame of a rigid body that is turned about its origin.
    """

    name = "frame_rotation"
    title = "rotation of the force frame"
    slot = "sensor"
    parameters = (
        *(
            strength(
                f"tilt_{axis}", "rad", f"turn about {axis} of the sensor's frame",
                bounds=(-0.2, 0.2), plausible=(-0.0175, 0.0175), deviation=0.01, source="0.2 to 1 deg: " + _MOUNT,
            )
            for axis in "xy"
        ),
        strength(
            "yaw", "rad", "turn about z of the sensor's frame",
            bounds=(-0.4, 0.4), plausible=(-0.053, 0.053), deviation=0.02, source="0.5 to 3 deg: " + _MOUNT,
        ),
    )  # fmt: skip
    look_alikes = ("gain_crosstalk", "tool_weight", "mount_offset")
    distinguishing_trial = (
        "Press straight and weigh a known mass in three orientations: all turn alike, forces and torques."
    )
    detectability = "1 degree leaks 0.09 N of 5 N into shear; a loss of force norms cannot see it at all."
    reference = "rigid-body statics"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        turn = Rotation.from_rotvec([values["tilt_x"], values["tilt_y"], values["yaw"]]).as_matrix()
        load = state.touch.to_sensor(state.wrench)
        reading = np.concatenate([load[:, :3] @ turn.T, load[:, 3:] @ turn.T], axis=1)
        return state.with_reading(state.touch.from_sensor(reading))

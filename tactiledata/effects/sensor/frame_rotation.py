"""The force sensor is turned against the frame that was assumed."""

from __future__ import annotations

from collections.abc import Mapping

from scipy.spatial.transform import Rotation

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState

_MOUNT = "screw holes and adapters; estimate"


class FrameRotation(Effect):
    """A rotation of force and torque, F -> R F and M -> R M, R of the rotation vector (tilt_x, tilt_y, yaw).

    The norm of the force stays.

    Source: rotation of a wrench about the gel's origin.
    """

    name = "frame_rotation"
    title = "rotation of the force frame"
    slot = "sensor"
    parameters = (
        *(
            strength(
                f"tilt_{axis}", "rad", f"turn about {axis} of the gel frame",
                bounds=(-0.2, 0.2), plausible=(-0.0175, 0.0175), deviation=0.01, source="0.2 to 1 deg: " + _MOUNT,
            )
            for axis in "xy"
        ),
        strength(
            "yaw", "rad", "turn about z of the gel frame",
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
        wrench = state.wrench.copy()
        wrench[:, :3] = wrench[:, :3] @ turn.T
        wrench[:, 3:] = wrench[:, 3:] @ turn.T
        return state.with_reading(wrench)

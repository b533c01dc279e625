"""Mass and centre of gravity of the tool are not what was compensated (entry 15)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState

_MOMENT = "0.5 kg, 2 to 10 mm: 0.01 to 0.05 N m"


class ToolWeight(Effect):
    """F -> F + m g, M -> M + (first moment) x g: a weight that turns with the wrist.

    g is the acceleration of gravity in the gel frame, m the mass that was not compensated (negative: too much was), the
    moment m r that of its centre about the gel's origin. Measured contact wrenches are on the indenter: a mass on the
    gel's side counts negative.

    Source: rigid-body statics; seen in cartesian_controllers issue 120 and Universal_Robots_ROS_Driver issues 512 and
    617.
    """

    name = "tool_weight"
    number = 15
    title = "tool weight and centre of gravity"
    slot = "S"
    parameters = (
        strength(
            "mass", "kg", "mass that was not compensated",
            bounds=(-0.5, 0.5), plausible=(-0.06, 0.06), deviation=0.03, source="10 to 60 g: cables, adapters",
        ),
        *(
            strength(
                f"moment_{axis}", "kg m", f"first moment of mass along {axis} of the gel frame",
                bounds=(-0.05, 0.05), plausible=(-5e-3, 5e-3), deviation=2e-3, source=_MOMENT,
            )
            for axis in "xyz"
        ),
    )  # fmt: skip
    look_alikes = ("sensor_drift", "cable_drag", "frame_rotation")
    distinguishing_trial = "Turn the wrist in free air: a sinusoid of the angle, in force and torque, without contact."
    detectability = "20 g are 0.4 N between wrist up and wrist down; at one orientation the tare hides it."
    reference = "rigid-body statics"
    needs = ("gravity",)

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        gravity = state.covariate("gravity", self.name)
        moment = np.array([values["moment_x"], values["moment_y"], values["moment_z"]])
        weight = np.concatenate([values["mass"] * gravity, np.cross(moment, gravity)], axis=1)
        return state.with_reading(state.wrench + weight)

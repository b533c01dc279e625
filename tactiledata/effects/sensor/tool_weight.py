"""Mass and centre of gravity of the tool differ from those that were compensated."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState

_MOMENT = "0.5 kg, 2 to 10 mm: 0.01 to 0.05 N m"


class ToolWeight(Effect):
    """A weight that was not compensated, F -> F + m g and M -> M + (first moment) x g.

    g is the acceleration of gravity in the gel frame, which turns with the wrist. m is the mass that was not
    compensated, negative where too much was; the first moment is m r, r its centre from the origin of the gel. Measured
    contact wrenches act on the indenter: a mass on the side of the gel counts negative.

    Source: rigid-body statics; seen in cartesian_controllers issue 120 and Universal_Robots_ROS_Driver issues 512 and
    617.
    """

    name = "tool_weight"
    title = "tool weight and centre of gravity"
    slot = "sensor"
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

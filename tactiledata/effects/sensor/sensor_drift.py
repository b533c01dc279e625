"""The zero of the force sensor drifts while the sensor warms up."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.state import TouchState

_SEEN = "Universal_Robots_ROS_Driver issues 633 (4 N in 5 min) and 269, robotiq issue 106"


class SensorDrift(Effect):
    """A bias b(t) = b (1 - exp(-t / time)), t since power-on, is added to every reading.

    A zero that is taken at the start of each trajectory leaves only the drift within the trajectory.

    Source: first-order warming; sizes as reported by users of such sensors.
    """

    name = "sensor_drift"
    title = "bias and thermal drift of the force sensor"
    slot = "sensor"
    parameters = (
        *(
            strength(
                f"f{axis}", "N", f"final bias of the force along {axis}",
                bounds=(-10.0, 10.0), plausible=(-3.0, 3.0), deviation=0.7, source=_SEEN,
            )
            for axis in "xyz"
        ),
        *(
            strength(
                f"t{axis}", "N m", f"final bias of the torque about {axis}",
                bounds=(-0.5, 0.5), plausible=(-0.1, 0.1), deviation=0.03, source="0.1 m times the force; estimate",
            )
            for axis in "xyz"
        ),
        shape(
            "time", "s", "time constant of the warming",
            default=1200.0, bounds=(30.0, 7200.0), grid=(100.0, 400.0, 1200.0, 3600.0), source="10 to 60 min",
        ),
    )  # fmt: skip
    look_alikes = ("heating", "tool_weight", "cable_drag")
    distinguishing_trial = (
        "Free air before and after each touch: a bias is there without contact, and does not grow with depth."
    )
    detectability = "With a zero per trajectory only the slope is left: 3 N in 20 min are 0.02 N over a touch of 10 s."
    reference = "Universal_Robots_ROS_Driver issue 633"
    needs = ("powered",)

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        warm = -np.expm1(-state.covariate("powered", self.name) / values["time"])
        bias = [values[kind + axis] for kind in "ft" for axis in "xyz"]
        return state.with_reading(state.wrench + warm[:, None] * bias)

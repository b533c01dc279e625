"""The force sensor feels the tool being accelerated (entry 29)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.state import TouchState


class Inertia(Effect):
    """F -> F - m a, a the acceleration of the tip in the gel frame, twice differentiated from the poses.

    It is added to the reading, for it neither moves the indenter nor touches the gel. Frames must be dense enough to
    show a start or a stop.

    Source: Newton; 0.5 kg at 0.2 m/s^2 is 0.1 N.
    """

    name = "inertia"
    number = 29
    title = "inertia of the tool"
    slot = "S"
    parameters = (
        strength(
            "mass", "kg", "mass between the sensor and the contact",
            bounds=(-3.0, 3.0), plausible=(-1.0, 1.0), deviation=0.4, source="sensor, holder and indenter: 0.1 to 1 kg",
        ),
    )  # fmt: skip
    look_alikes = ("lag", "tool_weight")
    told_apart_by = "Start and stop in free air: peaks at the accelerations, none at constant speed."
    detectability = "0.5 kg at 0.2 m/s^2 is 0.1 N, at starts and stops only; slow presses show none of it."
    reference = "Newton's second law"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        touch = state.touch
        if len(touch) < 3:
            return state
        velocity = np.gradient(touch.tips, touch.seconds, axis=0)
        acceleration = np.gradient(velocity, touch.seconds, axis=0)
        wrench = state.wrench.copy()
        wrench[:, :3] -= values["mass"] * acceleration
        return state.read(wrench)

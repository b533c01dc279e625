"""A cable pulls at the tool when the wrist turns."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.state import TouchState


def with_play(angle: Array, play: float) -> Array:
    """Play operator: an angle (n,), rad, that follows another one only at the ends of a band of width ``play``, rad."""
    follows = np.empty_like(angle)
    at = angle[0] if len(angle) else 0.0
    for frame, target in enumerate(angle):
        at = min(max(at, target - play / 2), target + play / 2)
        follows[frame] = at
    return follows


class CableDrag(Effect):
    """A spring with play on the last joint: F -> F + k p(q6), M -> M + k_t p(q6), p the angle after the play operator.

    A cable pulls somewhere at the tool, so that its torque about the gel's origin is a number of its own.

    Source: Krasnosel'skii's play operator, the simplest rate-independent hysteresis; sizes are an estimate.
    """

    name = "cable_drag"
    title = "drag of cables"
    slot = "sensor"
    parameters = (
        *(
            strength(
                f"f{axis}", "N/rad", f"force along {axis} of the gel frame per angle of the last joint",
                bounds=(-2.0, 2.0), plausible=(-0.5, 0.5), deviation=0.15, source="0.05 to 0.5 N; estimate",
            )
            for axis in "xyz"
        ),
        *(
            strength(
                f"t{axis}", "N m/rad", f"torque about {axis} of the gel frame per angle of the last joint",
                bounds=(-0.4, 0.4), plausible=(-0.1, 0.1), deviation=0.03, source="0.2 m times the force; estimate",
            )
            for axis in "xyz"
        ),
        shape(
            "play", "rad", "angle within which the cable does not follow",
            default=0.1, bounds=(0.0, 2.0), grid=(0.0, 0.1, 0.3), source="estimate",
        ),
    )  # fmt: skip
    look_alikes = ("tool_weight", "sensor_drift")
    distinguishing_trial = (
        "Turn the last joint to and fro in free air about a vertical axis: gravity stays, the cable's pull does not."
    )
    detectability = "0.1 N/rad is the noise of one reading at one radian; averaged over a turn in free air it shows."
    reference = "Visintin, Differential Models of Hysteresis"
    needs = ("joints",)

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        angle = with_play(state.covariate("joints", self.name)[:, 5], values["play"])
        pull = [values[kind + axis] for kind in "ft" for axis in "xyz"]
        return state.with_reading(state.wrench + angle[:, None] * pull)

"""Readings of the force come late, and smoothed."""

from __future__ import annotations

from collections.abc import Mapping

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.time_operators import delayed, fading_memory


class Lag(Effect):
    """A delay, F(t) -> F(t - delay), then a first-order low-pass: F - integral of exp(-(t - s) / filter) dF(s).

    It acts on all that the sensor reads, weight and inertia included, and so belongs to the slot ``sensor``.

    Source: robotiq issue 124 (rate really seen); drivers of force sensors with up to 0.5 s.
    """

    name = "lag"
    title = "lag and filter of the force sensor"
    slot = "sensor"
    parameters = (
        strength(
            "delay", "s", "by how much readings are older than their frames",
            bounds=(-0.5, 0.5), plausible=(-0.06, 0.06), deviation=0.03, source="5 to 60 ms",
        ),
        strength(
            "filter", "s", "time constant of the low-pass",
            bounds=(0.0, 1.0), plausible=(0.0, 0.1), deviation=0.03, source="sensor filters of 5 to 100 ms; estimate",
        ),
    )  # fmt: skip
    look_alikes = ("clock_skew", "relaxation", "inertia", "partial_slip")
    distinguishing_trial = (
        "The same path at two speeds: the residual follows dF/dt on all axes; in a dwell of a second it is gone."
    )
    detectability = "20 ms at 10 N/s are 0.2 N; frames taken at rest show nothing of it."
    reference = "ros-industrial robotiq issue 124"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        seconds = state.touch.seconds
        wrench = state.wrench
        if values["delay"] != 0.0:
            wrench = delayed(seconds, wrench, values["delay"])
        if values["filter"] != 0.0:
            wrench = wrench - fading_memory(seconds, wrench, values["filter"])
        return state.with_reading(wrench)

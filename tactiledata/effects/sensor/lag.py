"""Readings of the force come late, and smoothed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.touch.earlier_places import delayed_along
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.time_operators import fading_memory

NODES = 5
"""Delays over which the low-pass is a mean."""


class Lag(Effect):
    """A delay, F(t) -> F(t - delay), then a first-order low-pass: F - integral of exp(-(t - s) / filter) dF(s).

    Between frames the wrench follows the path of the tip, where that is known. The low-pass is then a mean over delays
    (Gauss and Laguerre's quadrature).

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
        delay, time, touch = values["delay"], values["filter"], state.touch
        if time == 0.0 and delay == 0.0:
            return state
        if time == 0.0 or touch.earlier_places is None:
            late = delayed_along(touch.seconds, state.wrench, touch.tips, touch.earlier_places, delay)
            return state.with_reading(late if time == 0.0 else late - fading_memory(touch.seconds, late, time))
        nodes, weights = np.polynomial.laguerre.laggauss(NODES)
        late = np.zeros_like(state.wrench)
        for node, weight in zip(nodes, weights, strict=True):
            by = delay + time * float(node)
            late += weight * delayed_along(touch.seconds, state.wrench, touch.tips, touch.earlier_places, by)
        return state.with_reading(late)

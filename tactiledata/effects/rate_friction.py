"""Friction that grows, or falls, with the sliding speed (entry 8)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.state import TouchState

SLOWEST = 1e-3
"""Of the reference speed: slower, the law is not followed further down."""


class RateFriction(Effect):
    """mu(v) = mu (1 + beta log10(v / v0)), v the speed of the tip along the gel; at rest that of the last move.

    Source: Vorvolakos and Chaudhury, Langmuir 19, 2003: the shear stress of silicone rises with speed up to a maximum;
    beyond, it levels out or falls, which is a negative beta here. The logarithm is the usual form between.
    """

    name = "rate_friction"
    number = 8
    title = "friction by speed"
    slot = "I"
    parameters = (
        strength(
            "beta", "1", "relative change of friction per decade of speed",
            bounds=(-0.5, 0.5), plausible=(-0.15, 0.25), deviation=0.1, source="0.05 to 0.25 below 1 mm/s",
        ),
        shape(
            "speed", "m/s", "v0: where friction is as simulated",
            default=1e-3, bounds=(1e-5, 0.1), grid=(1e-3,), source="usual speed of a slide",
        ),
    )  # fmt: skip
    look_alikes = ("static_friction", "area_friction", "lag")
    told_apart_by = "Slides at 0.1, 1 and 10 mm/s under one load: the plateau moves, the normal force does not."
    detectability = "beta = 0.1: 0.4 N of shear per decade at 5 N and mu 0.8; only while sliding."
    reference = "Vorvolakos and Chaudhury, Langmuir 19, 2003"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        moving = state.touch.lateral_speed
        last = np.maximum.accumulate(np.where(moving > SLOWEST * values["speed"], np.arange(len(moving)), 0))
        ratio = np.maximum(moving[last] / values["speed"], SLOWEST)
        has_moved = np.maximum.accumulate(moving > SLOWEST * values["speed"])
        return state.rubbed(np.where(has_moved, 1.0 + values["beta"] * np.log10(ratio), 1.0))

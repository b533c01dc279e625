"""Readings come in steps, and small ones as zero (entry 26)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import strength
from tactiledata.effects.state import TouchState

Array = NDArray[np.float64]


class Quantisation(Effect):
    """Components smaller than their dead-band read 0; all are rounded to multiples of their step.

    Components are those of the sensor, where the touch tells its frame; of the gel frame otherwise.

    Source: the FT 300-S sends counts of 0.01 N and 0.001 N m; drivers add dead-bands of their own.
    """

    name = "quantisation"
    number = 26
    title = "quantisation and dead-band"
    slot = "S"
    parameters = (
        strength(
            "step", "N", "step of the force",
            bounds=(0.0, 2.0), plausible=(0.0, 0.1), deviation=0.05, source="0.01 to 0.1 N of such sensors",
        ),
        strength(
            "torque_step", "N m", "step of the torque",
            bounds=(0.0, 0.2), plausible=(0.0, 0.01), deviation=0.005, source="0.001 to 0.01 N m of such sensors",
        ),
        strength(
            "dead_band", "N", "smallest force that is not read as 0",
            bounds=(0.0, 3.0), plausible=(0.0, 0.5), deviation=0.2, source="0.1 to 0.5 N; estimate",
            grid=(0.1, 0.15, 0.2, 0.25, 0.35, 0.5),
        ),
        strength(
            "torque_dead_band", "N m", "smallest torque that is not read as 0",
            bounds=(0.0, 0.2), plausible=(0.0, 0.02), deviation=0.005, source="0.02 m times a force's; estimate",
            grid=(0.002, 0.003, 0.004, 0.005, 0.007, 0.01),
        ),
    )  # fmt: skip
    look_alikes = ("clipping", "mount_offset")
    told_apart_by = "A slow press from free air: a staircase, or zeros below one value; a histogram shows the comb."
    detectability = "A step of 0.1 N is 0.03 N rms; a dead-band of 0.3 N is 0.3 N at every small component."
    reference = "Robotiq FT 300-S instruction manual, data stream"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        told = state.touch.to_sensor(state.wrench)
        force = _rounded(_told(told[:, :3], values["dead_band"]), values["step"])
        torque = _rounded(_told(told[:, 3:], values["torque_dead_band"]), values["torque_step"])
        return state.read(state.touch.from_sensor(np.concatenate([force, torque], axis=1)))


def _told(rows: Array, least: float) -> Array:
    return np.where(np.abs(rows) < least, 0.0, rows)


def _rounded(rows: Array, step: float) -> Array:
    return step * np.round(rows / step) if step > 0 else rows

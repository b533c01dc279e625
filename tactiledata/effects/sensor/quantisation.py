"""Readings come in steps, and small ones are read as zero."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import ndtr

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.normal_density import normal_density
from tactiledata.effects.touch.state import TouchState


class Quantisation(Effect):
    """Components smaller than their dead-band are read as 0; all are rounded to multiples of their step.

    Components are those of the sensor, where the touch states its frame; else those of the gel frame. A sensor has
    noise, so that near the end of the band it reads sometimes a force and sometimes 0. A simulated component, which has
    no noise, becomes the mean of such readings (`mean_reading`); with a noise of 0, a single reading.

    Source: the FT 300-S sends counts of 0.01 N and 0.001 N m; drivers add dead-bands of their own.
    """

    name = "quantisation"
    title = "quantisation and dead-band"
    slot = "sensor"
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
        shape(
            "noise", "N", "standard deviation of a reading of the force, before its dead-band",
            default=0.1, bounds=(0.0, 2.0), grid=(0.1,), source="FT 300-S instruction manual",
        ),
        shape(
            "torque_noise", "N m", "standard deviation of a reading of the torque, before its dead-band",
            default=0.005, bounds=(0.0, 0.2), grid=(0.002, 0.005),
            source="FT 300-S instruction manual; less where it is filtered, estimate",
        ),
    )  # fmt: skip
    look_alikes = ("clipping", "mount_offset")
    distinguishing_trial = (
        "A slow press from free air: a staircase, or zeros below one value; a histogram shows the comb."
    )
    detectability = "A step of 0.1 N is 0.03 N rms; a dead-band of 0.3 N is 0.3 N at every small component."
    reference = "Robotiq FT 300-S instruction manual, data stream"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        reading = state.touch.to_sensor(state.wrench)
        force = mean_reading(reading[:, :3], values["dead_band"], values["noise"])
        torque = mean_reading(reading[:, 3:], values["torque_dead_band"], values["torque_noise"])
        force, torque = _rounded(force, values["step"]), _rounded(torque, values["torque_step"])
        return state.with_reading(state.touch.from_sensor(np.concatenate([force, torque], axis=1)))


def mean_reading(rows: Array, least: float, noise: float) -> Array:
    """Mean (n, k) of readings x + e, e normal, that are read as 0 within (-least, least).

    x (1 - Phi(b) + Phi(a)) + s (phi(b) - phi(a)), a = (-least - x) / s, b = (least - x) / s.

    Parameters
    ----------
    rows : (n, k) N or N m
        Components x without noise.
    least : float
        Half width of the dead-band; at 0 the mean is x.
    noise : float
        Standard deviation s of a reading; at 0 the mean is a single reading.
    """
    if not least > 0:
        return rows
    if not noise > 0:
        return np.where(np.abs(rows) < least, 0.0, rows)
    low, high = (-least - rows) / noise, (least - rows) / noise
    lost = rows * (ndtr(high) - ndtr(low)) - noise * (normal_density(high) - normal_density(low))
    return np.asarray(rows - lost)


def _rounded(rows: Array, step: float) -> Array:
    """Return components rounded to multiples of a step; the same where the step is 0."""
    return step * np.round(rows / step) if step > 0 else rows

"""Readings saturate at a limit, and frames were chosen by noisy readings."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.special import ndtr

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.normal_density import normal_density
from tactiledata.effects.touch.state import TouchState

FARTHEST = 2.0
"""Distance from the range, in standard deviations, beyond which a frame is taken not to have been chosen by noise."""


def selection_bias(force: Array, deviation: float, low: float, high: float) -> Array:
    """Mean (n,), N, of the noise of force norms that were kept because norm plus noise lay in [low, high].

    The mean of a truncated normal: s (phi(a) - phi(b)) / (Phi(b) - Phi(a)), a = (low - F) / s, b = (high - F) / s.

    Parameters
    ----------
    force : (n,) N
        Norms F without noise.
    deviation : float
        Standard deviation s of the noise, N.
    low, high : float
        Range of norms that were kept, N.
    """
    margin = FARTHEST * deviation
    is_near = (force > low - margin) & (force < high + margin)
    near = np.where(is_near, force, low)
    a, b = (low - near) / deviation, (high - near) / deviation
    return np.where(is_near, deviation * (normal_density(a) - normal_density(b)) / (ndtr(b) - ndtr(a)), 0.0)


def limited(force: Array, limit: float, knee: float) -> Array:
    """Return forces that saturate at +-limit, along a parabola from (1 - knee) to (1 + knee) times the limit.

    Below the knee a force stays what it is, bit for bit.

    Parameters
    ----------
    force : (n, k) N
        Components of forces.
    limit : float
        Largest component, N.
    knee : float
        Half width of the parabola, over the limit; at 0 a force ends at once.
    """
    size = np.abs(force)
    into = size - (1.0 - knee) * limit
    if not (into > 0).any():
        return force
    bent = size - into**2 / (4.0 * knee * limit) if knee > 0 else size
    ends = np.where(size < (1.0 + knee) * limit, bent, limit)
    return np.where(into > 0, np.copysign(ends, force), force)


class Clipping(Effect):
    """Components of the force end at +-1 / inverse_limit; norms near the ends of the chosen range are biased inwards.

    ``inverse_limit`` is one over the limit, so that its null is no limit. Components are those of the sensor, where the
    touch states its frame. An amplifier bends before it saturates: ``knee`` is the share of the limit over which it
    does (`limited`). ``noise`` is that of the norm by which frames were chosen (`selection_bias`): close to 1 N, frames
    are kept whose noise was positive. Data that were not chosen by force have no such bias.

    Source: truncated normal distribution; the SPLIT paper keeps frames of 1 to 13 N.
    """

    name = "clipping"
    title = "saturation and selection"
    slot = "sensor"
    parameters = (
        strength(
            "inverse_limit", "1/N", "one over the largest component that is read",
            bounds=(0.0, 1.0), plausible=(0.0, 0.25), deviation=0.25, source="limits of 4 N and more; estimate",
            grid=(0.1, 0.12, 0.14, 0.16, 0.19, 0.23),
        ),
        shape(
            "knee", "1", "share of the limit, on both sides of it, over which readings bend",
            default=0.0, bounds=(0.0, 0.6), grid=(0.0, 0.2), source="digital limits have none; amplifiers: estimate",
        ),
        strength(
            "noise", "N", "standard deviation of the norm by which frames were chosen",
            bounds=(0.0, 2.0), plausible=(0.0, 0.3), deviation=0.1, source="0.1 N of the FT 300-S, and a little more",
        ),
    )  # fmt: skip
    look_alikes = ("quantisation", "sensor_drift", "mount_offset")
    distinguishing_trial = "Choose the frames by depth in place of force: the bias is gone."
    detectability = "0.1 N of noise biases frames at the 1 N threshold by 0.08 N, those at 1.2 N by nothing."
    reference = "Johnson, Kotz and Balakrishnan, Continuous Univariate Distributions 1, ch. 13"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        touch, wrench = state.touch, state.wrench.copy()
        if values["inverse_limit"] > 0:
            # in the frame of the sensor; a wrench that loses nothing stays the same, bit for bit
            limit, reading = 1.0 / values["inverse_limit"], touch.to_sensor(wrench)
            reading[:, :3] = limited(reading[:, :3], limit, values["knee"])
            lost = reading - touch.to_sensor(wrench)
            wrench = wrench if not lost.any() else touch.from_sensor(reading)
        force = wrench[:, :3]
        if values["noise"] > 0 and touch.selection is not None:
            low, high = touch.selection
            size = np.linalg.norm(force, axis=1)
            bias = selection_bias(size, values["noise"], low, high)
            force = force * (1.0 + np.divide(bias, size, out=np.zeros_like(size), where=size > 0))[:, None]
        wrench[:, :3] = force
        return state.with_reading(wrench)

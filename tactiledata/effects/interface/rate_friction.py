"""Friction grows, or falls, with the sliding speed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.last_move import SLOWEST as STANDING
from tactiledata.effects.touch.state import TouchState

SLOWEST = 1e-3
"""Speed, over the reference speed, below which the factor on friction stays what it is there."""


class RateFriction(Effect):
    """Friction mu(v) = mu (1 + beta log10(v / v0)) at the speed v of the contact.

    While the tip moves, v is its speed. Where it stands and beta > 0, the contact creeps on under its own shear: with
    k dx = -dF and F on the law, v = u / (1 + u t / L), L = beta mu N / (k ln 10), k the contact's stiffness along the
    gel, t the rest and u the speed below which a tip counts as standing: every move ends slowly. After a moment only
    L / t counts. In a touch that does not state its rest, v is the speed of the last move.

    Source: Vorvolakos and Chaudhury, Langmuir 19, 2003: the shear stress of silicone rises with speed up to a maximum;
    beyond, it levels out or falls, which is a negative beta here. The logarithm is the usual form between.
    """

    name = "rate_friction"
    title = "friction by speed"
    slot = "interface"
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
    distinguishing_trial = "Slides at 0.1, 1 and 10 mm/s under one load: the plateau moves, the normal force does not."
    detectability = "beta = 0.1: 0.4 N of shear per decade at 5 N and mu 0.8; only while sliding."
    reference = "Vorvolakos and Chaudhury, Langmuir 19, 2003"

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"mu": f"a slide at {1e3 * values['speed']:g} mm/s"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        touch = state.touch
        # the motion between frames is known: a contact at rest creeps
        if touch.pace is not None and touch.rest is not None:
            speed = _creeping(state, values["beta"], touch.pace, touch.rest)
            ratio = np.maximum(speed / values["speed"], SLOWEST)
            return state.rubbed(np.where(touch.pace > 0, 1.0 + values["beta"] * np.log10(ratio), 1.0))
        # without the motion between frames: the speed of the last move
        moving = touch.lateral_speed
        last = np.maximum.accumulate(np.where(moving > SLOWEST * values["speed"], np.arange(len(moving)), 0))
        ratio = np.maximum(moving[last] / values["speed"], SLOWEST)
        has_moved = np.maximum.accumulate(moving > SLOWEST * values["speed"])
        return state.rubbed(np.where(has_moved, 1.0 + values["beta"] * np.log10(ratio), 1.0))


def _creeping(state: TouchState, beta: float, pace: Array, rest: Array) -> Array:
    """Speed (n,), m/s, of the contact: the pace where the tip moves, the speed of creep where it rests.

    Parameters
    ----------
    state : TouchState
        State before the effect.
    beta : float
        Relative change of friction per decade of speed; a contact creeps where it is positive.
    pace : (n,) m/s
        As in `Touch`.
    rest : (n,) s
        As in `Touch`.
    """
    gel, contact = state.touch.material, state.contact
    limit = max(beta, 0.0) * gel.friction * np.maximum(np.nan_to_num(contact.wrench[:, 2]), 0.0) / np.log(10.0)
    length = np.divide(limit, contact.spring, out=np.zeros_like(limit), where=contact.spring > 0)
    creeps = (length > 0) & (rest > 0)
    last = np.minimum(pace, STANDING)
    slowed: Array = last / (1.0 + np.divide(last * rest, length, out=np.zeros_like(length), where=creeps))
    return np.where(rest > 0, slowed, pace)

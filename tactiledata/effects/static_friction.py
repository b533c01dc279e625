"""Friction that is larger before it gives way, and the more so the longer it rested (entry 9)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.state import TouchState

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ROUNDS = 2
"""When it slides depends on how long it rested, and that on when it slid."""


class StaticFriction(Effect):
    """mu times 1 + (excess + ageing log10(1 + hold / time)) exp(-slip / length), until it rests again.

    ``hold`` is how long the contact stuck, ``slip`` how far it slid since. Which frames slide is asked of the gel with
    the static friction that rest has built up.

    Source: Baumberger and Caroli, Adv. Phys. 55, 2006: ageing at rest, renewal over a memory length.
    """

    name = "static_friction"
    number = 9
    title = "static friction and ageing"
    slot = "I"
    parameters = (
        strength(
            "excess", "1", "share by which static friction is larger than kinetic",
            bounds=(0.0, 1.0), plausible=(0.0, 0.4), deviation=0.15, source="mu_s / mu_k of 1.05 to 1.4; estimate",
        ),
        strength(
            "ageing", "1", "further share per decade of rest",
            bounds=(0.0, 0.3), plausible=(0.0, 0.05), deviation=0.03, source="2 to 5 % per decade",
        ),
        shape(
            "length", "m", "way over which the excess dies out",
            default=2e-4, bounds=(1e-6, 5e-3), grid=(5e-5, 2e-4, 8e-4), source="estimate",
        ),
        shape(
            "time", "s", "rest after which ageing counts",
            default=1.0, bounds=(0.01, 100.0), grid=(1.0,), source="usual reference of ageing laws",
        ),
    )  # fmt: skip
    look_alikes = ("rate_friction", "partial_slip", "area_friction")
    told_apart_by = (
        "Hold for 1, 10 and 100 s, then slide twice: the first peak grows with the rest, the second has none."
    )
    detectability = "excess 0.2: a peak of 0.8 N at 5 N and mu 0.8, gone after some tenths of a millimetre."
    reference = "Baumberger and Caroli, Adv. Phys. 55, 2006"

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        touching = state.contact.touching
        held = _held(state, touching, np.zeros(len(touching), dtype=bool))
        for _ in range(ROUNDS):
            limit = self._aged(held, values)
            sliding = state.rubbed(1.0 + limit).contact.sliding
            held = _held(state, touching, sliding)
        slipped = _slipped(state, touching & sliding)
        excess = self._aged(held, values) * np.exp(-slipped / values["length"])
        return state.rubbed(np.where(touching, 1.0 + excess, 1.0))

    @staticmethod
    def _aged(held: Array, values: Mapping[str, float]) -> Array:
        return values["excess"] + values["ageing"] * np.log10(1.0 + held / values["time"])


def _held(state: TouchState, touching: Flags, sliding: Flags) -> Array:
    """How long (n,), s, the contact has stuck, or had stuck when it began to slide."""
    held = np.zeros(len(touching))
    now, has_slid = 0.0, False
    for frame, span in enumerate(state.touch.time_steps):
        if not touching[frame]:
            now, has_slid = 0.0, False
        elif sliding[frame]:
            has_slid = True
        else:
            now, has_slid = span + (0.0 if has_slid else now), False
        held[frame] = now
    return held


def _slipped(state: TouchState, sliding: Flags) -> Array:
    """How far (n,), m, it had slid before each frame, since it last stuck."""
    slipped = np.zeros(len(sliding))
    now = 0.0
    for frame, way in enumerate(state.touch.lateral_steps):
        slipped[frame] = now if sliding[frame] else 0.0
        now = now + way if sliding[frame] else 0.0
    return slipped

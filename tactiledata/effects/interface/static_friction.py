"""Friction is larger before a contact slides, and the more so the longer the contact has rested."""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, hypot, log10
from typing import NamedTuple

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import Effect
from tactiledata.effects.parameter import shape, strength
from tactiledata.effects.touch.last_move import WAYS
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.touch import Touch


class StaticFriction(Effect):
    """Friction mu times 1 + excess exp(-slip / length) + ageing log10[(time + age) / (time + length / v0)].

    ``slip`` is the distance that the contact has slid since it stuck. ``age`` is the age of the contact: d age / dt =
    1 - v age / length. The age grows with rest, and is length / v in a long slide at v, which makes fast sliding
    easier; mu is that at v0. Between two frames, slip and age are those of a slider on a spring as stiff as the
    contact. Where it slid, the factor is that at the end of its move, and the age there is the time that the last
    ``length`` of the move took: moves end slowly. Pace and rest are those of the touch where it states them.

    Source: Dieterich's ageing law, as in Baumberger and Caroli, Adv. Phys. 55, 2006.
    """

    name = "static_friction"
    title = "static friction and ageing"
    slot = "interface"
    parameters = (
        strength(
            "excess", "1", "share by which static friction is larger than kinetic",
            bounds=(0.0, 1.0), plausible=(0.0, 0.4), deviation=0.15, source="mu_s / mu_k of 1.05 to 1.4; estimate",
            grid=(0.075, 0.3),
        ),
        strength(
            "ageing", "1", "further share per decade of rest",
            bounds=(0.0, 0.3), plausible=(0.0, 0.05), deviation=0.03, source="2 to 5 % per decade",
            grid=(0.015, 0.06),
        ),
        shape(
            "length", "m", "way over which the excess dies out",
            default=2e-4, bounds=(1e-6, 5e-3), grid=(5e-5, 2e-4, 8e-4), source="estimate",
        ),
        shape(
            "time", "s", "rest after which ageing counts",
            default=1.0, bounds=(0.01, 100.0), grid=(0.1, 1.0), source="0.01 to 1 s; estimate",
        ),
        shape(
            "speed", "m/s", "v0: of a long slide whose friction is as simulated",
            default=1e-3, bounds=(1e-5, 0.1), grid=(1e-3,), source="usual speed of a slide",
        ),
    )  # fmt: skip
    look_alikes = ("rate_friction", "partial_slip", "area_friction")
    distinguishing_trial = (
        "Hold for 1, 10 and 100 s, then slide twice: the first peak grows with the rest, the second has none."
    )
    detectability = "excess 0.2: a peak of 0.8 N at 5 N and mu 0.8, gone after some tenths of a millimetre."
    reference = "Baumberger and Caroli, Adv. Phys. 55, 2006"

    def material_of(self, values: Mapping[str, float]) -> Mapping[str, str]:
        return {"mu": f"a long slide at {1e3 * values['speed']:g} mm/s"}

    def change(self, state: TouchState, values: Mapping[str, float]) -> TouchState:
        # each frame by what happened since the one before: move, pace, rest, age, spring, limit
        touch, contact = state.touch, state.contact
        steps = np.diff(touch.tips[:, :2], axis=0, prepend=touch.tips[:1, :2])
        spring = contact.spring
        limit = touch.material.friction * state.friction * np.maximum(np.nan_to_num(contact.wrench[:, 2]), 0.0)
        paces = touch.lateral_speed if touch.pace is None else touch.pace
        rests = np.zeros(len(touch)) if touch.rest is None else np.minimum(touch.rest, touch.time_steps)
        ages = _ages_of_a_slide(touch, values["length"], rests)
        sticks = contact.touching & (spring > 0)
        factors = np.ones(len(touch))
        interface = _AgeingContact(values)
        columns = (*steps.T, touch.time_steps, paces, rests, ages, spring, limit)
        moves = zip(*(column.tolist() for column in columns), strict=True)
        for frame, (touches, move) in enumerate(zip(sticks.tolist(), moves, strict=True)):
            if touches:
                factors[frame] = interface.advance(_Move(*move))
            else:
                interface = _AgeingContact(values)
        return state.rubbed(factors)


def _ages_of_a_slide(touch: Touch, length: float, rests: Array) -> Array:
    """Age (n,), s, of a contact at the end of a long slide: the time that its last ``length`` took; NaN if unknown."""
    if touch.last_ways is None:
        return np.full(len(touch), np.nan)
    columns = np.interp(np.log(length), np.log(WAYS), np.arange(len(WAYS)))
    below = min(int(columns), len(WAYS) - 2)
    share = columns - below
    took = (1.0 - share) * touch.last_ways[:, below] + share * touch.last_ways[:, below + 1]
    return np.maximum(took - rests, 0.0)


class _Move(NamedTuple):
    """Motion from one frame to the next: m along x and y, s in all, m/s while it moves, s at rest in the end.

    ``age``, s, is that of a long slide at its end, NaN where it is not known; ``spring``, N/m, and ``limit``, N, are
    those at the end.
    """

    x: float
    y: float
    seconds: float
    pace: float
    rest: float
    age: float
    spring: float
    limit: float


class _AgeingContact:
    """A slider on a spring whose friction depends on its slip and its age."""

    def __init__(self, values: Mapping[str, float]) -> None:
        self._excess, self._ageing = values["excess"], values["ageing"]
        self._length, self._time = values["length"], values["time"]
        self._slide_age = values["length"] / values["speed"]
        self._x, self._y = 0.0, 0.0
        self._age, self._slipped = 0.0, 0.0

    @property
    def factor(self) -> float:
        """Factor on the kinetic friction."""
        fresh = self._excess * exp(-self._slipped / self._length)
        older = (self._time + self._age) / (self._time + self._slide_age)
        return 1.0 + fresh + self._ageing * log10(older)

    def advance(self, move: _Move) -> float:
        """Advance by a move, and return the factor at its end; the rest comes after it."""
        self._x += move.spring * move.x
        self._y += move.spring * move.y
        size = hypot(self._x, self._y)
        most = move.limit * self.factor
        if size <= most:
            self._age, self._slipped = self._age + move.seconds, 0.0
            return self.factor
        slip = (size - most) / move.spring
        # a contact may slide where nothing moves, because its load falls
        speed = move.pace if move.pace > 0 else slip / move.seconds
        age = move.age if move.age > 0 else self._length / speed
        kept = exp(-slip / self._length)
        self._age = kept * self._age + (1.0 - kept) * age
        self._slipped += slip
        factor = self.factor
        within = min(move.limit * factor, size) / size
        self._x, self._y = within * self._x, within * self._y
        self._age += move.rest
        return factor

"""A simulator with effects is a simulator again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.base import CONTACT_SLOTS
from tactiledata.effects.simulate.balance import Balance
from tactiledata.effects.simulate.setting import EffectSetting, in_order
from tactiledata.effects.touch.response import BaseResponse, GelVariant
from tactiledata.effects.touch.state import TouchState
from tactiledata.effects.touch.touch import Touch
from tactiledata.errors import UsageError

EDGE = 1e-5
"""m about the surface, within which contact comes and goes."""
MOST_ROUNDS = 30
PATIENCE = 8
"""Rounds without a nearer answer after which one that is close enough is taken."""
RESUMED_ROUNDS, RESUMED_CLOSE = 8, 1e-6
"""From the balance of a touch bent alike: rounds after which it is looked for anew, and how near it is led on. Nearer
than from the start, so that small changes of it are those of what bends."""
CLOSE, CLOSE_ENOUGH = 1e-5, 5e-3
"""Of the largest force: up to where what bends the springs and what the gel answers balance, and where no more. Between
them lies what jumps: a contact that sticks heals at once, and there may be no balance on either side of it."""


@dataclass(frozen=True)
class Simulator:
    """A simulation of touches, with effects on top.

    Parameters
    ----------
    base : callable, touch -> BaseResponse
    effects : tuple of EffectSetting
        In the order in which they act.
    """

    base: Callable[[Touch], BaseResponse]
    effects: tuple[EffectSetting, ...] = ()

    def with_effects(self, settings: Iterable[EffectSetting]) -> Simulator:
        """A simulator with further effects."""
        return Simulator(self.base, in_order([*self.effects, *settings]))

    def variant(self, touch: Touch) -> GelVariant:
        """The gel and the indenter that the effects stand for: play it with ``moved_poses`` for deformed meshes."""
        variant = GelVariant()
        for setting in self.effects:
            if setting.acts_on(touch) and not setting.is_null:
                variant = variant.together_with(setting.member.variant(setting.values))
        return variant

    def play(self, touch: Touch) -> TouchState:
        """A touch to its end: ``wrench`` is what the sensor would read, ``moved_poses`` where the indenter was.

        Raises
        ------
        UsageError
            An effect depends on what the touch does not tell, or gel and springs find no balance.
        """
        return self.read(self.contact(touch))

    def contact(self, touch: Touch) -> TouchState:
        """The touch after its effects in contact alone; as `play`, which goes on from here with `read`."""
        return self.contact_near(touch, None)[0]

    def contact_near(self, touch: Touch, near: Balance | None) -> tuple[TouchState, Balance | None]:
        """The same, looked for from the balance of a touch that was bent much alike; and the balance found, or
        ``near`` where nothing bends.
        """
        return _in_balance(TouchState.start(touch, self.base(touch)), in_contact(self.active(touch)), near)

    def read(self, contact: TouchState) -> TouchState:
        """What time and sensor make of it."""
        return as_read(contact, self.active(contact.touch))

    def active(self, touch: Touch) -> list[EffectSetting]:
        """Effects that do something to a touch, in their order."""
        return [setting for setting in self.effects if setting.acts_on(touch) and not setting.is_null]


def with_effects(base: Callable[[Touch], BaseResponse], settings: Iterable[EffectSetting]) -> Simulator:
    """A simulator of a base with effects."""
    return Simulator(base).with_effects(settings)


def in_contact(settings: Iterable[EffectSetting]) -> list[EffectSetting]:
    """Those that change what is asked of the gel."""
    return [setting for setting in settings if setting.member.slot in CONTACT_SLOTS]


def as_read(state: TouchState, settings: Iterable[EffectSetting]) -> TouchState:
    """A touch after its effects in contact, with what time and sensor make of the wrench."""
    state = state.with_reading(state.contact.wrench)
    for setting in settings:
        if setting.member.slot not in CONTACT_SLOTS:
            state = setting.apply(state)
    return _zeroed(state)


def _in_balance(
    start: TouchState, settings: Sequence[EffectSetting], near: Balance | None
) -> tuple[TouchState, Balance | None]:
    """The state after effects in contact, in which what is felt is what the gel answers, and the balance."""

    def after(felt: Array) -> TouchState:
        state = replace(start, felt=felt)
        for setting in settings:
            state = setting.apply(state)
        return state

    if not any(setting.member.feeds_back for setting in settings):
        return after(start.felt), near
    if near is not None:
        balance = near.resumed()
        found, least = _searched(balance, after, RESUMED_CLOSE, RESUMED_ROUNDS)
        if least <= CLOSE * balance.largest and balance.knows(found.contact.wrench):
            return found, balance
    balance = Balance(start.contact.wrench)
    found, least = _searched(balance, after, CLOSE, MOST_ROUNDS)
    if min(least, _missed_beyond_edges(found)) > CLOSE_ENOUGH * balance.largest:
        raise unbalanced(least, MOST_ROUNDS)
    return found, balance


def _searched(
    balance: Balance, after: Callable[[Array], TouchState], close: float, rounds: int
) -> tuple[TouchState, float]:
    """The nearest state, and what it misses the balance by, N; ``close`` ends it, of the largest force."""
    least, found = np.inf, 0
    for number in range(rounds):
        state = after(balance.felt)
        balance.measure(state.contact.wrench)
        if number == 0 or balance.missed < least:
            nearest, least, found = state, balance.missed, number
        is_stuck = number - found >= PATIENCE and least <= CLOSE_ENOUGH * balance.largest
        if least <= close * balance.largest or is_stuck:
            break
        if number + 1 < rounds:
            balance.move()
    return nearest, least


def _missed_beyond_edges(state: TouchState) -> float:
    """By how much, N, what is felt is not what the gel answers, but for frames in which it touches or does not.

    A force that begins with a jump pushes its springs out of the contact, and without force they come back.
    """
    missed = np.abs(np.nan_to_num(state.contact.wrench - state.felt))
    inside = ~(np.abs(state.contact.depth) < EDGE)
    return float(missed[inside].max(initial=0.0))


def unbalanced(missed: float, rounds: int) -> UsageError:
    """Springs so soft that gel and springs find no rest."""
    return UsageError(
        f"gel and springs find no balance: {missed:.2g} N are left after {rounds} rounds",
        "springs that are not many times softer than the gel",
        "Lessen the compliances.",
    )


def _zeroed(state: TouchState) -> TouchState:
    """The reading less its median in the frames from which the measured zero was taken."""
    tare, wrench = state.touch.tare, state.wrench
    if tare is None:
        return state
    free = wrench[tare]
    free = free[np.isfinite(free).all(axis=1)]
    # most effects leave the air alone
    return state.with_reading(wrench - np.median(free, axis=0)) if free.any() else state

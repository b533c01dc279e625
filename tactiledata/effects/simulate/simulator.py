"""A simulator of touches with effects on top of any base simulation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

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
"""Distance from the surface, m, within which contact may come and go between two iterations."""
MOST_ROUNDS = 30
"""Largest number of iterations for the force balance."""
PATIENCE = 8
"""Iterations without a smaller residual after which one within ``CLOSE_ENOUGH`` is accepted."""
RESUMED_ROUNDS, RESUMED_CLOSE = 8, 1e-6
"""Iterations from the balance of a similar touch before the solution starts anew, and their relative tolerance. It is
tighter than ``CLOSE``, so that small differences between two balances are differences of the touches."""
CLOSE, CLOSE_ENOUGH = 1e-5, 5e-3
"""Relative tolerances of the force balance: below ``CLOSE`` it has converged, above ``CLOSE_ENOUGH`` it has failed. In
between the result is accepted, because stick-slip jumps may leave no exact balance."""


@dataclass(frozen=True)
class Simulator:
    """A simulation of touches with effects.

    Parameters
    ----------
    base : callable, touch -> BaseResponse
        The simulation without effects.
    effects : tuple of EffectSetting
        Effects in the order in which they act.
    """

    base: Callable[[Touch], BaseResponse]
    effects: tuple[EffectSetting, ...] = ()

    def with_effects(self, settings: Iterable[EffectSetting]) -> Simulator:
        """Return a simulator with further effects, all in the order in which they act."""
        return Simulator(self.base, in_order([*self.effects, *settings]))

    def variant(self, touch: Touch) -> GelVariant:
        """Return the gel and the indenter that the effects stand for; deformed meshes need it and ``moved_poses``."""
        variant = GelVariant()
        for setting in self.effects:
            if setting.acts_on(touch) and not setting.is_null:
                variant = variant.together_with(setting.member.variant(setting.values))
        return variant

    def play(self, touch: Touch) -> TouchState:
        """Return the state after all effects: ``wrench`` is what the sensor would read.

        Raises
        ------
        UsageError
            The touch does not state what an effect depends on, or gel and springs find no balance.
        """
        return self.read(self.contact(touch))

    def contact(self, touch: Touch) -> TouchState:
        """Return the state after the effects in contact alone, from which `read` goes on; errors as those of `play`."""
        return self.contact_near(touch, None)[0]

    def contact_near(self, touch: Touch, near: Balance | None) -> tuple[TouchState, Balance | None]:
        """Return the state after the effects in contact, and the force balance found.

        Parameters
        ----------
        touch : Touch
            The touch to play.
        near : Balance, optional
            Balance of a similar touch, from which the iteration starts; it is returned where no effect feeds back.
        """
        return _in_balance(TouchState.start(touch, self.base(touch)), in_contact(self.active(touch)), near)

    def read(self, contact: TouchState) -> TouchState:
        """Return the state after effects of time and sensor, for a state after the effects in contact."""
        return with_sensor_effects(contact, self.active(contact.touch))

    def active(self, touch: Touch) -> list[EffectSetting]:
        """Return the settings that change a touch, in the order in which they act."""
        return [setting for setting in self.effects if setting.acts_on(touch) and not setting.is_null]


def with_effects(base: Callable[[Touch], BaseResponse], settings: Iterable[EffectSetting]) -> Simulator:
    """Return a simulator of a base simulation with effects.

    Parameters
    ----------
    base : callable, touch -> BaseResponse
        The simulation without effects.
    settings : iterable of EffectSetting
        Effects with their values, in any order.
    """
    return Simulator(base).with_effects(settings)


def in_contact(settings: Iterable[EffectSetting]) -> list[EffectSetting]:
    """Return the settings of effects in contact, which change what the gel is asked."""
    return [setting for setting in settings if setting.member.slot in CONTACT_SLOTS]


def with_sensor_effects(state: TouchState, settings: Iterable[EffectSetting]) -> TouchState:
    """Return the state with the effects of time and sensor, zeroed where the touch states its tare.

    Parameters
    ----------
    state : TouchState
        A state after the effects in contact.
    settings : iterable of EffectSetting
        Effects in the order in which they act; those in contact are passed over.
    """
    state = state.with_reading(state.contact.wrench)
    for setting in settings:
        if setting.member.slot not in CONTACT_SLOTS:
            state = setting.apply(state)
    return _zeroed(state)


def _in_balance(
    start: TouchState, settings: Sequence[EffectSetting], near: Balance | None
) -> tuple[TouchState, Balance | None]:
    """Return the state after effects in contact, in force balance with what bends, and that balance."""

    # springs bent by a wrench, then the answer of the gel
    def after(felt: Array) -> TouchState:
        """Return the state after all effects where a wrench (n, 6) bends arm and stem."""
        state = start.with_felt(felt)
        for setting in settings:
            state = setting.apply(state)
        return state

    if not any(setting.member.feeds_back for setting in settings):
        return after(start.felt), near
    # first from the balance of a similar touch, then from the start
    if near is not None:
        balance = near.resumed()
        nearest, least = _search(balance, after, RESUMED_CLOSE, RESUMED_ROUNDS)
        if least <= CLOSE * balance.largest and balance.knows(nearest.contact.wrench):
            return nearest, balance
    balance = Balance(start.contact.wrench)
    nearest, least = _search(balance, after, CLOSE, MOST_ROUNDS)
    if min(least, _missed_beyond_edges(nearest)) > CLOSE_ENOUGH * balance.largest:
        raise unbalanced(least, MOST_ROUNDS)
    return nearest, balance


def _search(
    balance: Balance, after: Callable[[Array], TouchState], close: float, rounds: int
) -> tuple[TouchState, float]:
    """Return the state with the smallest residual, and that residual, N or N m; a residual below ``close`` ends it."""
    least, best = np.inf, 0
    for iteration in range(rounds):
        state = after(balance.felt)
        balance.measure(state.contact.wrench)
        if iteration == 0 or balance.missed < least:
            nearest, least, best = state, balance.missed, iteration
        is_stuck = iteration - best >= PATIENCE and least <= CLOSE_ENOUGH * balance.largest
        if least <= close * balance.largest or is_stuck:
            break
        if iteration + 1 < rounds:
            balance.move()
    return nearest, least


def _missed_beyond_edges(state: TouchState) -> float:
    """Largest residual of the force balance, N or N m, without frames within ``EDGE`` of the surface.

    There a force that begins with a jump pushes the springs out of contact, and without force they come back.
    """
    missed = np.abs(np.nan_to_num(state.contact.wrench - state.felt))
    inside = ~(np.abs(state.contact.depth) < EDGE)
    return float(missed[inside].max(initial=0.0))


def unbalanced(missed: float, rounds: int) -> UsageError:
    """Return the error where springs are too soft for a balance; ``missed`` is the residual, N or N m."""
    return UsageError(
        f"gel and springs find no balance: {missed:.2g} N are left after {rounds} rounds",
        "springs that are not many times softer than the gel",
        "Lessen the compliances.",
    )


def _zeroed(state: TouchState) -> TouchState:
    """Return the state whose reading is less its median over the frames of the tare; the same without a tare."""
    tare, wrench = state.touch.tare, state.wrench
    if tare is None:
        return state
    free = wrench[tare]
    free = free[np.isfinite(free).all(axis=1)]
    # most effects leave the air alone
    return state.with_reading(wrench - np.median(free, axis=0)) if free.any() else state

"""A simulator with effects is a simulator again."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tactiledata.effects.base import CONTACT_SLOTS
from tactiledata.effects.response import BaseResponse, GelVariant
from tactiledata.effects.setting import EffectSetting, in_order
from tactiledata.effects.state import TouchState
from tactiledata.effects.touch import Touch
from tactiledata.errors import UsageError

Array = NDArray[np.float64]

MOST_ROUNDS = 30
CLOSE, CLOSE_ENOUGH = 1e-9, 1e-4
"""Of the largest force: up to where what bends the springs and what the gel answers balance, and where no more."""
LEAST_STEP, LARGEST_STEP = 0.02, 2.0


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
        active = [setting for setting in self.effects if setting.acts_on(touch) and not setting.is_null]
        in_contact = [setting for setting in active if setting.member.slot in CONTACT_SLOTS]
        state = _in_balance(TouchState.start(touch, self.base(touch)), in_contact)
        state = state.read(state.contact.wrench)
        for setting in active[len(in_contact) :]:
            state = setting.apply(state)
        return _zeroed(state)


def with_effects(base: Callable[[Touch], BaseResponse], settings: Iterable[EffectSetting]) -> Simulator:
    """A simulator of a base with effects."""
    return Simulator(base).with_effects(settings)


def _in_balance(start: TouchState, settings: Sequence[EffectSetting]) -> TouchState:
    """The state after effects in contact, in which what is felt is what the gel answers.

    Each component of each frame follows the secant method, for which its neighbours hardly matter.
    """

    def after(felt: Array) -> TouchState:
        state = replace(start, felt=felt)
        for setting in settings:
            state = setting.apply(state)
        return state

    if not any(setting.member.feeds_back for setting in settings):
        return after(start.felt)
    known = np.isfinite(start.contact.wrench)
    felt = _bridged(start.contact.wrench, known)
    close = CLOSE * np.abs(felt).max(initial=0.0)
    step, miss = np.ones_like(felt), np.zeros_like(felt)
    for turn in range(MOST_ROUNDS):
        state = after(felt)
        away = state.contact.wrench - felt
        last, miss = miss, np.where(np.isfinite(away), away, 0.0)
        if np.abs(miss).max(initial=0.0) <= close:
            break
        if turn > 0:
            fell = last - miss
            step = np.divide(step * last, fell, out=np.ones_like(fell), where=np.abs(fell) > 1e-3 * np.abs(miss))
            step = np.clip(step, LEAST_STEP, LARGEST_STEP)
        felt = _bridged(felt + step * miss, known)
    if np.abs(miss).max(initial=0.0) > CLOSE_ENOUGH / CLOSE * close:
        raise UsageError(
            f"gel and springs find no balance: {np.abs(miss).max():.2g} N are left after {MOST_ROUNDS} rounds",
            "springs that are not many times softer than the gel",
            "Lessen the compliances.",
        )
    return state


def _bridged(wrench: Array, known: NDArray[np.bool_]) -> Array:
    """A wrench (n, 6) with what is unknown taken from its neighbours, as what is not simulated bends the arm, too."""
    frames = np.arange(len(wrench))
    columns = [
        column if sure.all() else np.interp(frames, frames[sure], column[sure]) if sure.any() else np.zeros(len(column))
        for column, sure in zip(wrench.T, known.T, strict=True)
    ]
    return np.stack(columns, axis=1)


def _zeroed(state: TouchState) -> TouchState:
    """The reading less its median in the frames from which the measured zero was taken."""
    tare, wrench = state.touch.tare, state.wrench
    if tare is None:
        return state
    free = wrench[tare]
    free = free[np.isfinite(free).all(axis=1)]
    return state.read(wrench - np.median(free, axis=0)) if len(free) else state

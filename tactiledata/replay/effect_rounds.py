"""Trajectories played with effects: on the gel that they stand for, where they move the indenter, as it is felt."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.effects.simulate.balance import Balance
from tactiledata.effects.simulate.simulator import in_contact, unbalanced, with_sensor_effects
from tactiledata.effects.touch.state import TouchState
from tactiledata.gel.contact.history import GelHistory, GelTouch
from tactiledata.gel.contact.recorder import Keep
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.embedded import EmbeddedEngine
from tactiledata.gel.engines.fem import FemEngine
from tactiledata.replay.effect_touches import EffectTouch
from tactiledata.replay.played_answer import PlayedAnswer

MOST_ROUNDS = 15
STILL = 1e-7
"""m: effects that move the indenter by no more than this from where it was played are in balance with the gel."""


def play_with_effects(
    engine: FemEngine | EmbeddedEngine,
    touches: Sequence[GelTouch],
    effects: Sequence[EffectTouch | None],
    material: GelMaterial,
    keep: Keep,
) -> Iterator[tuple[int, GelHistory]]:
    """As ``play`` of the engine, with wrenches as the force sensor would read them.

    What yields under the contact's force is played until gel and springs are in balance; each round plays all touches
    that are not, in lockstep.

    Parameters
    ----------
    effects : sequence of EffectTouch
        Of each touch; ``None`` where nothing acts.

    Raises
    ------
    UsageError
        An effect depends on what a touch does not tell, or gel and springs find no balance.
    """
    ways = [
        None if effect is None else _Way(touch, effect, engine, material)
        for touch, effect in zip(touches, effects, strict=True)
    ]
    going = list(range(len(touches)))
    for _ in range(MOST_ROUNDS):
        asked = [touches[number] if (way := ways[number]) is None else way.next for number in going]
        left = []
        for place, history in engine.play(asked, material, keep):
            way = ways[going[place]]
            found = history if way is None else way.took(history)
            if found is None:
                left.append(going[place])
            else:
                yield going[place], found
        going = sorted(left)
        if not going:
            return
    raise unbalanced(max(way.missed for number in going if (way := ways[number]) is not None), MOST_ROUNDS)


class _Way:
    """One touch from round to round."""

    def __init__(
        self, touch: GelTouch, effects: EffectTouch, engine: FemEngine | EmbeddedEngine, material: GelMaterial
    ) -> None:
        self._touch, self._effects, self._engine, self._material = touch, effects, engine, material
        self._feeds_back = any(setting.member.feeds_back for setting in effects.settings)
        self._balance: Balance | None = None
        self._poses = self._moved(self._state(PlayedAnswer.untouched(effects.touch.poses)))

    @property
    def next(self) -> GelTouch:
        """What is to be played."""
        return GelTouch(self._touch.indenter, self._poses)

    @property
    def missed(self) -> float:
        """N, by which what is felt and what the gel answers differ."""
        return 0.0 if self._balance is None else self._balance.missed

    def took(self, history: GelHistory) -> GelHistory | None:
        """The history with the wrench as it is read; ``None`` where the indenter has to be elsewhere first."""
        rows, areas = self._effects.known, self._engine.surface.patch_areas
        touch = replace(self._effects.touch, material=self._material)
        answer = PlayedAnswer.of(history, rows, self._poses, self._engine.mesh, areas, touch)
        if self._feeds_back:
            self._weigh(self._state(answer).contact.wrench)
        state = self._state(answer)
        poses = self._moved(state)
        if np.abs(poses[rows] - self._poses[rows]).max(initial=0.0) > STILL:
            self._poses = poses
            return None
        wrench = history.wrench.copy()
        # the sensor's zero is taken before the first contact
        tare = np.logical_and.accumulate(~answer.contact.touching)
        state = replace(state, touch=replace(state.touch, tare=tare))
        wrench[rows] = with_sensor_effects(state, self._effects.settings).wrench
        return replace(history, wrench=wrench)

    def _weigh(self, wrench: Array) -> None:
        if self._balance is None:
            self._balance = Balance(wrench)
        else:
            self._balance.measure(wrench)
            self._balance.move()

    def _state(self, answer: PlayedAnswer) -> TouchState:
        state = TouchState.start(self._effects.touch, answer)
        if self._balance is not None:
            state = replace(state, felt=self._balance.felt)
        for setting in in_contact(self._effects.settings):
            state = setting.member.apply(state, setting.member.parameters_not_played_by_gel(setting.values))
        return state

    def _moved(self, state: TouchState) -> Array:
        poses = self._touch.poses.copy()
        poses[self._effects.known] = state.moved_poses
        return poses

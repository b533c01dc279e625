"""Simulation of trajectories with effects: on the varied gel, along the moved indenter, with the sensor's reading."""

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
"""Most rounds of simulation until effects and gel are in balance."""
STILL = 1e-7
"""Largest motion of the indenter, m, between two rounds at which effects and gel are in balance."""


def play_with_effects(
    engine: FemEngine | EmbeddedEngine,
    touches: Sequence[GelTouch],
    effects: Sequence[EffectTouch | None],
    material: GelMaterial,
    keep: Keep,
) -> Iterator[tuple[int, GelHistory]]:
    """Simulate trajectories with their effects, and yield number and answer of each when it is in balance.

    Wrenches are those that the force sensor would read. Where the contact's force moves the indenter, trajectories are
    simulated again until gel and springs are in balance; each round solves all that are not, in lockstep.

    Parameters
    ----------
    engine : FemEngine or EmbeddedEngine
        Engine of the gel that the effects stand for.
    touches : sequence of GelTouch
        Poses and indenters as recorded.
    effects : sequence of EffectTouch
        Inputs of the effects on each touch; ``None`` where none acts.
    material : GelMaterial
        Young's modulus, Poisson's ratio and friction.
    keep : "all", "surface" or "none"
        Nodes whose displacements are returned.

    Raises
    ------
    UsageError
        A touch lacks what an effect depends on, or gel and springs find no balance.
    """
    iterations = [
        None if effect is None else _EffectIteration(touch, effect, engine, material)
        for touch, effect in zip(touches, effects, strict=True)
    ]
    unfinished = list(range(len(touches)))
    for _ in range(MOST_ROUNDS):
        poses_to_play = [
            touches[number] if (iteration := iterations[number]) is None else iteration.next for number in unfinished
        ]
        unbalanced_touches = []
        for place, history in engine.play(poses_to_play, material, keep):
            iteration = iterations[unfinished[place]]
            balanced_history = history if iteration is None else iteration.with_reading(history)
            if balanced_history is None:
                unbalanced_touches.append(unfinished[place])
            else:
                yield unfinished[place], balanced_history
        unfinished = sorted(unbalanced_touches)
        if not unfinished:
            return
    raise unbalanced(
        max(iteration.imbalance for number in unfinished if (iteration := iterations[number]) is not None), MOST_ROUNDS
    )


class _EffectIteration:
    """Fixed-point iteration of one touch: the poses to simulate next, and the forces that moved the indenter there."""

    def __init__(
        self, touch: GelTouch, effects: EffectTouch, engine: FemEngine | EmbeddedEngine, material: GelMaterial
    ) -> None:
        self._touch, self._effects, self._engine, self._material = touch, effects, engine, material
        self._feeds_back = any(setting.member.feeds_back for setting in effects.settings)
        self._balance: Balance | None = None
        self._poses = self._moved(self._state(PlayedAnswer.untouched(effects.touch.poses)))

    @property
    def next(self) -> GelTouch:
        """The touch with the poses that must be simulated in this round."""
        return GelTouch(self._touch.indenter, self._poses)

    @property
    def imbalance(self) -> float:
        """Remaining difference, N, between the force that the springs feel and the gel's answer."""
        return 0.0 if self._balance is None else self._balance.missed

    def with_reading(self, history: GelHistory) -> GelHistory | None:
        """Return the answer with the wrench that the sensor reads, or ``None`` where the indenter moves once more."""
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
        # in balance: let the sensor's effects read the wrench
        wrench = history.wrench.copy()
        # the sensor's zero is taken before the first contact
        tare = np.logical_and.accumulate(~answer.contact.touching)
        state = replace(state, touch=replace(state.touch, tare=tare))
        wrench[rows] = with_sensor_effects(state, self._effects.settings).wrench
        return replace(history, wrench=wrench)

    def _weigh(self, wrench: Array) -> None:
        """Update the balance of springs and gel with the wrench (n, 6) that the gel answered."""
        if self._balance is None:
            self._balance = Balance(wrench)
        else:
            self._balance.measure(wrench)
            self._balance.move()

    def _state(self, answer: PlayedAnswer) -> TouchState:
        """State of the touch after all effects on the contact, given the gel's answer."""
        state = TouchState.start(self._effects.touch, answer)
        if self._balance is not None:
            state = replace(state, felt=self._balance.felt)
        for setting in in_contact(self._effects.settings):
            state = setting.member.apply(state, setting.member.parameters_not_played_by_gel(setting.values))
        return state

    def _moved(self, state: TouchState) -> Array:
        """Poses (n, 4, 4) of all frames, with those of known frames as the effects have moved them."""
        poses = self._touch.poses.copy()
        poses[self._effects.known] = state.moved_poses
        return poses

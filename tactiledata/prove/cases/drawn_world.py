"""A world of a configuration and a seed: what it records with and without hidden effects, and how much can be seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.prove.cases.configuration import Configuration
from tactiledata.prove.cases.kinds import Sight
from tactiledata.prove.cases.oracle import PaperCalibration, alike_effects, plain_whitened, refit
from tactiledata.prove.cases.truth import friction_left, modulus_left
from tactiledata.prove.cases.world_case import WorldCase
from tactiledata.prove.worlds.logs import LogReadings
from tactiledata.prove.worlds.played_plan import PlayedPlan
from tactiledata.prove.worlds.recorder import ReadWorld
from tactiledata.rig.scenario.scenario import load_scenario


class RecordedWorld(NamedTuple):
    """What the force sensor reads in each log of a world.

    Parameters
    ----------
    readings : list of LogReadings
        Readings as they are recorded.
    exact : list of LogReadings
        The same by a sensor without noise and quanta.
    """

    readings: list[LogReadings]
    exact: list[LogReadings]


@dataclass(frozen=True)
class DrawnWorld:
    """A world of a configuration, before it is decided what it hides.

    Parameters
    ----------
    played : PlayedPlan
        The plan of the configuration, with its plays.
    configuration : Configuration
        Generator, plan, errors of the solver and noise.
    seed : int
        Seed of the world's gel, noise and offsets.
    """

    played: PlayedPlan
    configuration: Configuration
    seed: int

    def recorded(self, hidden: Sequence[dict[str, Any]]) -> RecordedWorld:
        """Return what the force sensor reads where this is hidden, with its noise and without."""
        maker = self.configuration.maker(self.played.maker)
        logs = maker.played(self.seed, self.played.gel(self.seed), list(hidden))
        return RecordedWorld([log.readings(maker.noise) for log in logs], [log.readings(0.0) for log in logs])

    @cached_property
    def _without(self) -> RecordedWorld:
        """The readings of the world without what it hides."""
        return self.recorded(())

    @cached_property
    def unhidden(self) -> ReadWorld:
        """The world without what it hides, as a diagnosis would read it."""
        return self.played.maker.observed(self._without.readings)

    @cached_property
    def clean(self) -> Array:
        """Wrenches (N, 6), N and N m, of the world without what it hides, by a sensor without noise."""
        return np.concatenate(self.played.maker.observed(self._without.exact).wrenches)

    @cached_property
    def touch_set(self) -> TouchSet:
        """Trajectories of the world without what it hides, whose noise is the unit of a signal."""
        return self.played.maker.cases(self.unhidden, self.played.family)

    @cached_property
    def plain(self) -> JointFit:
        """The plain simulation fitted to the world without what it hides."""
        return refit(self.touch_set, self.clean)

    @cached_property
    def paper(self) -> PaperCalibration:
        """The paper's calibration of the plan's touches."""
        return PaperCalibration.of(self.touch_set)

    @property
    def solver_error(self) -> Array:
        """What the generator's forces (N, 6), N and N m, differ by from the plain simulation that fits them best."""
        return self.clean - self.touch_set.play(self.plain.model.material, [], self.plain.model.offsets)

    def loss_ratio(self, recorded: RecordedWorld) -> float:
        """Return the paper's loss on readings after a calibration, over that of the world without what it hides."""
        loss = self.paper.loss(self.played.maker.observed(recorded.readings).wrenches)
        return round(loss / self.paper.loss(self.unhidden.wrenches), 4)

    def sight(self, recorded: RecordedWorld, loss_ratio: float, with_alike: bool = False) -> Sight:
        """Return how much can be seen of what is hidden.

        Parameters
        ----------
        recorded : RecordedWorld
            The readings with what is hidden.
        loss_ratio : float
            See `loss_ratio`.
        with_alike : bool
            Whether effects are looked for that imitate it.
        """
        felt = np.concatenate(self.played.maker.observed(recorded.exact).wrenches)
        change = felt - self.clean
        signal = float(np.sqrt(max(refit(self.touch_set, felt).cost - self.plain.cost, 0.0)))
        whole = float((plain_whitened(self.touch_set, change) ** 2).sum())
        alike = alike_effects(self.plain, self.touch_set, change, self.played.effects) if with_alike else {}
        found = self.plain.model.material
        return Sight(
            signal=round(signal, 3),
            absorbed=round(1.0 - min(1.0, signal**2 / whole), 4) if whole > 0 else 0.0,
            loss_ratio=loss_ratio,
            alike=alike,
            unhidden=(found.youngs_modulus, found.poisson_ratio, found.friction),
        )

    def case(self, kind: str, hidden: Sequence[dict[str, Any]], sight: Sight | None = None) -> WorldCase:
        """Return the case of this world.

        Parameters
        ----------
        kind : str
            Kind of the case.
        hidden : sequence of dict
            Hidden effects as a scenario states them.
        sight : Sight, optional
            How much can be seen of them; ``None`` where nothing is hidden.
        """
        gel = self.played.gel(self.seed)
        effects = load_scenario(self.played.plan.scenario(self.seed, gel, list(hidden))).hidden
        return WorldCase(
            kind=kind,
            configuration=self.configuration,
            seed=self.seed,
            hidden=tuple(hidden),
            material=(gel.youngs_modulus, gel.poisson_ratio, gel.friction),
            modulus_left=modulus_left(effects),
            friction_left=friction_left(effects, gel.friction),
            sight=None if sight is None else sight.document,
        )

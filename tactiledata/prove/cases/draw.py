"""Cases drawn by a seed: kinds, effects, strengths, places, times and directions.

An effect that is asked to be visible, or concealed by calibration, is drawn again until the oracle says so. Draws that
were rejected are counted. Visible effects may be concealed by a calibration as well; most are. An effect that is asked
to be ambiguous, and that another one resembles, is drawn with a strength at which data do not tell the two apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactiledata.errors import UsageError
from tactiledata.prove.cases.configuration import Configuration, played_plan
from tactiledata.prove.cases.drawn_world import DrawnWorld, RecordedWorld
from tactiledata.prove.cases.kinds import AMBIGUOUS, CONCEALED, DRAWN, LEAST_SIGNAL, NULLS, OUTSIDE, PAIRS, Sight
from tactiledata.prove.cases.strengths import drawn_parameters, weakened
from tactiledata.prove.cases.truth import OUTSIDE as OUTSIDE_EFFECTS
from tactiledata.prove.cases.truth import TITLES
from tactiledata.prove.cases.world_case import WorldCase
from tactiledata.prove.worlds.logs import LogReadings
from tactiledata.prove.worlds.played_plan import PlayedPlan

TRIES = 16
"""Largest number of draws for one case."""
BEYOND = 2.0
"""Factor by which strengths are drawn below the rig's weak ones and above its strong ones."""
DRAWING = 71
"""Number of the random streams of draws."""
FIRST_SEED = 100_000
"""Seeds of worlds begin here, beyond those that rules were made with."""


@dataclass(frozen=True)
class CaseRequest:
    """A case that is to be drawn.

    Parameters
    ----------
    number : int
        Place among all requests; decides the draws together with the seed.
    kind : str
        Kind of the case.
    configuration : Configuration
        Generator, plan, errors and noise.
    seed : int
        Seed of the proof.
    bank : Path
        Folder of kept solutions of generators.
    with_variants : bool
        Whether effects that need other gels played may be hidden.
    only : tuple of str
        Hidden effects, by the rig's names, among which is drawn; all where empty.
    """

    number: int
    kind: str
    configuration: Configuration
    seed: int
    bank: Path
    with_variants: bool = True
    only: tuple[str, ...] = ()

    def effects(self, played: PlayedPlan) -> list[str]:
        """Return the rig's names of the effects that may be hidden."""
        if self.kind == OUTSIDE:
            return [name for name in OUTSIDE_EFFECTS if not self.only or name in self.only]
        allowed = [name for name, title in TITLES.items() if title in played.effects]
        allowed = [name for name in allowed if name not in self.configuration.not_drawn]
        return [name for name in allowed if not self.only or name in self.only]


@dataclass(frozen=True)
class DrawnCase:
    """A case that was drawn, and the readings that a diagnosis will see.

    Parameters
    ----------
    case : WorldCase, optional
        ``None`` where no draw gave a case of the kind.
    readings : list of LogReadings
        Readings of each log.
    rejected : dict, reason -> int
        Number of draws that were rejected, by the reason.
    """

    case: WorldCase | None
    readings: list[LogReadings]
    rejected: Mapping[str, int]


def drawn_case(request: CaseRequest) -> DrawnCase:
    """Return the case of a request, recorded by its generator."""
    played = played_plan(request.configuration.plan, request.bank, request.with_variants)
    chance = np.random.default_rng([request.seed, DRAWING, request.number])
    allowed = request.effects(played)
    world = DrawnWorld(played, request.configuration, int(FIRST_SEED + chance.integers(2**31)))
    if request.kind == NULLS:
        return DrawnCase(world.case(NULLS, ()), world.recorded(()).readings, {})
    if len(allowed) < (2 if request.kind == PAIRS else 1):
        return DrawnCase(None, [], {})
    rejected: Counter[str] = Counter()
    for _ in range(TRIES):
        names = chance.choice(allowed, 2 if request.kind == PAIRS else 1, replace=False).tolist()
        drawn = int(chance.integers(2**31))
        hidden = tuple({"effect": name, "parameters": drawn_parameters(name, drawn, BEYOND)} for name in names)
        titles = [TITLES.get(name, "") for name in names]
        try:
            recorded, sight = _recorded(world, hidden, request.kind)
            if request.kind == AMBIGUOUS and (factor := _weakening(sight, titles, chance)) < 1.0:
                hidden = tuple({**one, "parameters": weakened(**one, factor=factor)} for one in hidden)
                recorded, sight = _recorded(world, hidden, request.kind)
        except UsageError as error:
            # a strength beyond what the generator can record
            rejected[f"the generator refuses {names[0]}: {error.expected}"] += 1
            continue
        alone = (
            [world.sight(world.recorded((one,)), sight.loss_ratio) for one in hidden]
            if request.kind == PAIRS and sight.is_visible
            else []
        )
        if is_of_kind(request.kind, sight, alone, titles):
            return DrawnCase(world.case(request.kind, hidden, sight), recorded.readings, rejected)
        rejected["not of the kind" if sight.is_visible else "too weak to be seen"] += 1
    return DrawnCase(None, [], rejected)


def _recorded(world: DrawnWorld, hidden: Sequence[dict[str, Any]], kind: str) -> tuple[RecordedWorld, Sight]:
    """Return the readings of a world that hides this, and how much can be seen of it."""
    recorded = world.recorded(hidden)
    return recorded, world.sight(recorded, world.loss_ratio(recorded), with_alike=kind == AMBIGUOUS)


def _weakening(sight: Sight, names: Sequence[str], chance: np.random.Generator) -> float:
    """Return the factor on strengths at which data do not tell what is hidden from an effect that resembles it.

    The signal is drawn evenly in its logarithm between the least that can be seen and the largest at which the two are
    not told apart. It is 1 where no other effect resembles what is hidden, or where data tell them apart as soon as
    they see it.
    """
    largest = max((sight.largest_alike(name) for name in set(sight.alike) - set(names)), default=0.0)
    if largest <= LEAST_SIGNAL:
        return 1.0
    wanted = LEAST_SIGNAL * (largest / LEAST_SIGNAL) ** chance.uniform()
    return min(1.0, wanted / max(sight.signal, LEAST_SIGNAL))


def is_of_kind(kind: str, sight: Sight, alone: Sequence[Sight], names: Sequence[str]) -> bool:
    """Return whether a draw is a case of a kind.

    Parameters
    ----------
    kind : str
        Kind that is asked for.
    sight : Sight
        How much can be seen of all that is hidden.
    alone : sequence of Sight
        How much can be seen of each of two hidden effects by itself.
    names : sequence of str
        Names of the hidden effects in the catalogue.
    """
    if kind == DRAWN:
        return True
    if not sight.is_visible:
        return False
    if kind == CONCEALED:
        return sight.is_concealed
    if kind == PAIRS:
        return all(one.is_visible for one in alone)
    if kind == AMBIGUOUS:
        return bool(set(sight.imitators) - set(names))
    return True

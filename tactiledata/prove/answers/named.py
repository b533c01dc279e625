"""What a diagnosis says of the readings of a world: it knows the plan and the readings, and nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from tactiledata.diagnose.answer.sentences import Answer
from tactiledata.diagnose.naming.full_plays import FullPlay, named_with_full_plays
from tactiledata.diagnose.naming.kept_fits import KeptFits
from tactiledata.diagnose.naming.name_effects import NamingResult, name_effects
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.played_response import PlayedFamily
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.zeros.causes import beside_claims, zero_causes
from tactiledata.effects.touch.response import GelVariant
from tactiledata.prove.worlds.logs import LogReadings
from tactiledata.prove.worlds.played_plan import START, PlayedPlan
from tactiledata.prove.worlds.recorder import ReadWorld

KEPT = ("verdict", "names", "probabilities", "objections", "dispersion", "at_large", "undetectable", "not_tried")
"""Fields of the document of a naming that an answer keeps as they are."""
SCREENED = 10
"""Number of rows of the screen that an answer keeps."""


@dataclass(frozen=True)
class NamedWorld:
    """The effects that a simulation lacks, as a diagnosis names them.

    Parameters
    ----------
    recorded : ReadWorld
        What the diagnosis read.
    touch_set : TouchSet
        The trajectories, with estimated plays.
    naming : NamingResult
        The last naming.
    full_plays : tuple of FullPlay
        How far estimated plays were off that were then played in full.
    """

    recorded: ReadWorld
    touch_set: TouchSet
    naming: NamingResult
    full_plays: tuple[FullPlay, ...]

    @property
    def document(self) -> dict[str, Any]:
        """The answer as it is kept: verdict, names, probabilities, candidates, fitted numbers, causes of zeros."""
        answer = Answer(self.naming)
        document = answer.document
        best = self.naming.decision.best
        causes = zero_causes(self.recorded.zeros, band=self.recorded.dead_band)
        shown, alike = beside_claims(causes, document["names"])
        ranked = sorted(self.naming.scored, key=lambda each: -each.gain)
        return {
            **{key: document[key] for key in KEPT},
            "set": list(dict.fromkeys([*answer.candidates, *alike])),
            "nearest": list(best.names) if best else [],
            "ties": [tie.name for tie in self.naming.decision.ties],
            "candidates": [
                {**told, "gains": one.gains.round(2).tolist(), "falls": one.evidence_per_trajectory.round(2).tolist()}
                for told, one in zip(document["candidates"], ranked, strict=True)
            ],
            "screen": document["screen"][:SCREENED],
            "before": [one["value"] for one in document["before"]],
            "after": [one["value"] for one in document["after"][:3]],
            "values": {one["name"]: one["value"] for one in document["after"][3:]},
            "zeros": [*shown, *self.recorded.shown],
            "full_plays": [
                # a number that is none was not refitted
                {key: None if value != value else value for key, value in asdict(one).items()}
                for one in self.full_plays
            ],
        }


@dataclass(frozen=True)
class _PlayedSet:
    """Touches of a world with the plays by which they are simulated."""

    touch_set: TouchSet
    plays: list[TouchPlays]


def named_world(
    played: PlayedPlan, readings: Sequence[LogReadings], pairs: bool = True, in_full: bool = True
) -> NamedWorld:
    """Return the effects that the simulation lacks, by the readings of a world.

    Parameters
    ----------
    played : PlayedPlan
        The plan, with its plays.
    readings : sequence of LogReadings
        What the force sensor read in each log.
    pairs : bool
        Whether pairs of effects are tried.
    in_full : bool
        Whether gels on which the answer could rest are played in full; else the answer is from estimated plays.
    """
    recorded = played.maker.observed(readings)
    touch_set = played.maker.cases(recorded, played.family)
    options = NamingOptions(effects=played.effects, profile=False, pairs=pairs)

    def play(full: frozenset[GelVariant]) -> _PlayedSet:
        plays = played.plays(full)
        return _PlayedSet(replace(touch_set, base=PlayedFamily(played.maker.touches, plays)), plays)

    def name(one: _PlayedSet, kept: KeptFits | None = None) -> NamingResult:
        return name_effects(one.touch_set, START, options, kept=kept)

    if not in_full:
        return NamedWorld(recorded, touch_set, name(play(frozenset())), ())
    _, naming, full_plays = named_with_full_plays(play, name)
    return NamedWorld(recorded, touch_set, naming, full_plays)

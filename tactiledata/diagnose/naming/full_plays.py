"""Effects named with gels that are played in full, wherever an answer could rest on an estimated play.

A first diagnosis estimates how most other gels would respond (`tactiledata.calibrate.plays`). That is good enough to
see which effects are worth a closer look. The gels of these are then played at finite strain, and the effects are named
again.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.kept_fits import KeptFits
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.variant_plays import design_variants
from tactiledata.effects import EFFECTS
from tactiledata.effects.touch.response import GelVariant

ALIKE = ("level", "by_ratio", "by_friction", "by_shift", "height")
"""Plays that all effects share."""
OF_A_PAIR = 0.5
"""Share of the evidence that a claim needs, which an effect must add to another one to be played in full."""
MOST_ROUNDS = 3
"""Largest number of times that gels are played in full and effects named again."""


class PlayedTouches(Protocol):
    """Trajectories with the plays by which they are simulated."""

    @property
    def plays(self) -> Sequence[TouchPlays]:
        """Plays of each trajectory."""


AnyPlayed = TypeVar("AnyPlayed", bound=PlayedTouches)


@dataclass(frozen=True)
class FullPlay:
    """How far the estimate of an effect was off that has since been played in full.

    Parameters
    ----------
    effect : str
        Name of the effect.
    error : float
        Root mean square of the difference in force between estimated and full play, over that of the change in force
        in the full play.
    estimated_evidence, evidence : float
        Evidence of the effect with estimated and with full plays; not a number where it was not refitted.
    """

    effect: str
    error: float
    estimated_evidence: float
    evidence: float


def named_with_full_plays(
    play: Callable[[frozenset[GelVariant]], AnyPlayed],
    name: Callable[[AnyPlayed, KeptFits], NamingResult],
    told: Callable[[NamingResult], None] = lambda naming: None,
) -> tuple[AnyPlayed, NamingResult, tuple[FullPlay, ...]]:
    """Return touches, the effects that their simulation lacks, and how far estimates were off.

    Parameters
    ----------
    play : callable
        Plays the touches, some variants of the gel in full.
    name : callable
        Names the effects that the simulation of touches lacks, with the fits of earlier namings that still hold.
    told : callable
        Called with the first answer where gels have yet to be played in full.
    """
    full: frozenset[GelVariant] = frozenset()
    played = play(full)
    kept = KeptFits()
    naming = name(played, kept)
    first, first_naming = played, naming
    for _ in range(MOST_ROUNDS):
        estimates = estimated(played.plays)
        wanted = estimates.intersection(
            variant for effect in promising(naming) for variant in design_variants(EFFECTS[effect]())
        )
        if not wanted:
            break
        if not full:
            told(naming)
        full |= wanted
        before, played = played, play(full)
        kept.forget(_changed(before.plays, played.plays))
        naming = name(played, kept)
    looked_at = full & estimated(first.plays)
    effects = [effect for effect in EFFECTS if looked_at.intersection(design_variants(EFFECTS[effect]()))]
    closer = tuple(
        FullPlay(
            effect,
            _error(first.plays, played.plays, design_variants(EFFECTS[effect]())),
            _evidence(first_naming, effect),
            _evidence(naming, effect),
        )
        for effect in effects
    )
    return played, naming, closer


def estimated(plays: Sequence[TouchPlays]) -> frozenset[GelVariant]:
    """Return the variants of the gel whose changes are estimated in the plays of some trajectory."""
    return frozenset(variant for one in plays for variant in one.by_estimate)


def promising(naming: NamingResult) -> set[str]:
    """Return the effects on which an answer could rest: those with evidence for a trace, the named ones, and ties.

    What is enough for a trace grows with the errors of the simulation beside the effect, as what a claim needs does.
    An effect of a pair must add ``OF_A_PAIR`` of what the pair needs to be claimed (`decide.needed_of`): a trace of a
    second effect is not told, and estimates are not so far off that a claim could come of less.
    """
    thresholds = naming.thresholds
    trace = thresholds.for_traces
    found = {one.names[0] for one in naming.scored if len(one.names) == 1 and one.evidence >= one.needed(trace)}
    alone = {one.names: one.evidence for one in naming.scored}
    for pair in naming.scored:
        for effect, other in itertools.permutations(pair.names, 2):
            beside = alone.get((other,), 0.0)
            claim = thresholds.with_errors(pair.error_size).claim(effect)
            if pair.evidence - beside >= OF_A_PAIR * max(claim, thresholds.second_share * beside):
                found.add(effect)
    return found | set(naming.decision.claimed) | {tie.name for tie in naming.decision.ties}


def _changed(before: Sequence[TouchPlays], after: Sequence[TouchPlays]) -> set[str] | None:
    """Effects whose variants are other plays than before; ``None`` where all effects are simulated otherwise."""
    pairs = list(zip(before, after, strict=True))
    for one, other in pairs:
        parts = [(getattr(one, name), getattr(other, name)) for name in ALIKE]
        if not all(np.array_equal(*part, equal_nan=True) for part in parts):
            return None
    variants = {variant for pair in pairs for one in pair for variant in one.variants}
    other_plays = {
        variant
        for variant in variants
        if any(_differ(one.variants.get(variant), other.variants.get(variant)) for one, other in pairs)
    }
    return {name for name in EFFECTS if other_plays.intersection(design_variants(EFFECTS[name]()))}


def _differ(one: Array | None, other: Array | None) -> bool:
    """Whether two changes of a wrench are not the same numbers, or only one of them is there."""
    if one is None or other is None:
        return one is not other
    return not np.array_equal(one, other, equal_nan=True)


def _error(before: Sequence[TouchPlays], after: Sequence[TouchPlays], variants: Sequence[GelVariant]) -> float:
    """Relative root mean square by which the forces of variants differ between plays of the same frames."""
    off = size = 0.0
    for one, other in zip(before, after, strict=True):
        for variant in variants:
            if variant in one.variants and variant in other.variants:
                change = other.variants[variant][:, :3]
                off += float(np.nansum((one.variants[variant][:, :3] - change) ** 2))
                size += float(np.nansum(change**2))
    return float(np.sqrt(off / size)) if size > 0 else float("nan")


def _evidence(naming: NamingResult, effect: str) -> float:
    """Evidence of an effect alone; not a number where it was not refitted."""
    return next((one.evidence for one in naming.scored if one.names == (effect,)), float("nan"))

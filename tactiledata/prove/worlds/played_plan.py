"""A plan whose touches the gel engine has played: all that the worlds of this plan have in common."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from tactiledata.calibrate.plays.estimated_plays import Estimates
from tactiledata.compute.base import Scheduler
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.diagnose.touches.grid_answer import TouchPlays
from tactiledata.diagnose.touches.play_grid import play_touches
from tactiledata.diagnose.touches.played_response import PlayedFamily
from tactiledata.diagnose.touches.variant_plays import design_variants, variants_of
from tactiledata.effects import EFFECTS
from tactiledata.effects.touch.response import GelVariant
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.gel.engines.fem import Fidelity
from tactiledata.prove.worlds.plan import WorldPlan
from tactiledata.prove.worlds.recorder import WorldMaker
from tactiledata.prove.worlds.touches import to_play

START = GelMaterial(0.9e6, 0.475, 0.65)
"""Material from which every fit starts."""
QUICK_EFFECTS = ("frame_rotation", "relaxation", "lag")
"""Candidates of a diagnosis on a coarse pad of small strain, which only shows that it works."""
MODULI = (0.84e6, 0.95e6)
"""Young's moduli, Pa, between which that of each world is drawn."""


@dataclass(frozen=True)
class PlayedPlan:
    """A plan of touches, how they are recorded and read, and the plays of the gel engine.

    Parameters
    ----------
    plan : WorldPlan
        What the arm is told.
    maker : WorldMaker
        Records worlds, and reads recordings; of each touch the frames that the gel engine could solve.
    family : PlayedFamily
        The simulation, from plays of which some are estimated.
    effects : tuple of str
        Effects for which all gels have been played: the candidates of a diagnosis.
    plays : callable
        Returns the plays of all touches, where some variants of the gel are played in full.
    """

    plan: WorldPlan
    maker: WorldMaker
    family: PlayedFamily
    effects: tuple[str, ...]
    plays: Callable[[frozenset[GelVariant]], list[TouchPlays]]

    @classmethod
    def of(
        cls,
        plan: WorldPlan,
        bank: Path,
        with_variants: bool,
        varied: Iterable[str] = tuple(EFFECTS),
        runner: Scheduler | None = None,
        progress: Progress = no_progress,
        estimates: Estimates = "learned",
    ) -> PlayedPlan:
        """Return a plan with its plays; what was not played yet is played, and kept.

        Parameters
        ----------
        plan : WorldPlan
            What the arm is told.
        bank : Path
            Folder of kept solutions of generators.
        with_variants : bool
            Whether other gels are played, for the effects that need them.
        varied : iterable of str
            Effects whose other gels are played.
        runner : Scheduler, optional
            Where touches are played; in this process where ``None``.
        progress : Progress
            Called with how many plays are finished.
        estimates : "learned", "rough" or "none"
            How plays at finite strain are estimated; with "none" every play is made.
        """
        maker = WorldMaker.of(plan, bank)
        fidelity: Fidelity = "linear" if plan.is_quick else "finite-strain"
        wanted = variants_of(varied) if with_variants else ()
        touches = to_play(maker.touches)

        @cache
        def plays_with(full: frozenset[GelVariant]) -> list[TouchPlays]:
            return play_touches(
                plan.mesh, fidelity, touches, plan.bounds, runner, progress, wanted, estimates=estimates, full=full
            )

        plays = plays_with(frozenset())
        known = [one.known for one in plays]
        played = set(plays[0].variants)
        asked = QUICK_EFFECTS if plan.is_quick else EFFECTS
        tried = tuple(name for name in asked if played.issuperset(design_variants(EFFECTS[name]())))
        maker = maker.keeping(known)

        def known_plays(full: frozenset[GelVariant]) -> list[TouchPlays]:
            return [one.part(rows) for one, rows in zip(plays_with(full), known, strict=True)]

        return cls(plan, maker, PlayedFamily(maker.touches, known_plays(frozenset())), tried, known_plays)

    def gel(self, seed: int) -> GelMaterial:
        """Return the real gel of a world: E is drawn for each world, nu and mu are those of the plan."""
        modulus = float(np.random.default_rng([seed, 53]).uniform(*MODULI))
        return GelMaterial(modulus, self.plan.truth.poisson_ratio, self.plan.truth.friction)

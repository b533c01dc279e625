"""Configurations: which generator records which plan, with which errors of a solver and which noise."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from tactiledata.prove.worlds.generators import SOLVED_ANEW, make_generator
from tactiledata.prove.worlds.plan_names import named_plan
from tactiledata.prove.worlds.played_plan import PlayedPlan
from tactiledata.prove.worlds.recorder import WorldMaker
from tactiledata.prove.worlds.solver_errors import OtherSolver


@dataclass(frozen=True)
class Configuration:
    """The circumstances that several worlds share.

    Parameters
    ----------
    generator : str
        Name of the generator.
    plan : str
        Name of the plan of touches.
    mismatch : float
        Size of the solver's errors beside those that the generator has: 0 none, 1 some per cent.
    solver : int
        Seed of these errors.
    noise : float
        Factor on noise and quanta of the force sensor.
    """

    generator: str
    plan: str
    mismatch: float = 0.0
    solver: int = 0
    noise: float = 1.0

    @property
    def label(self) -> str:
        """The configuration in a few words, for tables."""
        return f"{self.generator} {self.plan} mismatch {self.mismatch:g} noise {self.noise:g}"

    @property
    def document(self) -> dict[str, Any]:
        """The configuration for a label."""
        return asdict(self)

    @property
    def not_drawn(self) -> tuple[str, ...]:
        """Hidden effects that this generator would have to solve anew for every world."""
        return () if self.generator == "analytic" else SOLVED_ANEW

    def maker(self, maker: WorldMaker) -> WorldMaker:
        """Return what records worlds of this configuration, from the maker of its plan."""
        solve = OtherSolver(make_generator(self.generator, maker.bank), self.mismatch, self.solver)
        return replace(maker, solve=solve, noise=self.noise)


@lru_cache(maxsize=2)
def played_plan(name: str, bank: Path, with_variants: bool) -> PlayedPlan:
    """Return a named plan with its plays; a process keeps the last two, since its tasks come plan by plan.

    Parameters
    ----------
    name : str
        Name of the plan.
    bank : Path
        Folder of kept solutions of generators.
    with_variants : bool
        Whether other gels are played.
    """
    return PlayedPlan.of(named_plan(name), bank, with_variants)

"""Cases of sealed proofs with what they hide, told by their generators: for the tables that compare the two."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from tactiledata.arrays import Array
from tactiledata.compute import make_scheduler
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.gel.elasticity.compliance import cache_folder
from tactiledata.prove.answers.case_readings import case_readings
from tactiledata.prove.cases.configuration import Configuration, played_plan
from tactiledata.prove.cases.drawn_world import DrawnWorld
from tactiledata.prove.score.outcome import IN_SET, NAMED
from tactiledata.prove.score.scored_case import ScoredCase
from tactiledata.prove.seal.folder import ProofFolder
from tactiledata.prove.seal.verify import scored_cases
from tactiledata.prove.worlds.recorder import ReadWorld

T = TypeVar("T")


@dataclass(frozen=True)
class ProofCase:
    """A scored case of a proof, and its world without noise.

    Parameters
    ----------
    folder : ProofFolder
        The proof.
    case : ScoredCase
        The case, its label and its answer.
    bank : Path
        Folder of kept solutions of generators.
    """

    folder: ProofFolder
    case: ScoredCase
    bank: Path

    @cached_property
    def world(self) -> DrawnWorld:
        """The world of the case."""
        configuration = Configuration(**self.case.label["configuration"])
        return DrawnWorld(played_plan(configuration.plan, self.bank, True), configuration, self.case.label["seed"])

    @cached_property
    def change(self) -> Array:
        """What is hidden changes in the wrenches (N, 6), N and N m, without noise."""
        exact = self.world.recorded(self.case.label["hidden"]).exact
        felt: Array = np.concatenate(self.world.played.maker.observed(exact).wrenches) - self.world.clean
        return felt

    @cached_property
    def read(self) -> ReadWorld:
        """What a diagnosis reads of the case."""
        return self.world.played.maker.observed(case_readings(self.folder, self.case.name))

    @property
    def touch_set(self) -> TouchSet:
        """Trajectories as a diagnosis reads them, with the simulation of their plan."""
        played = self.world.played
        return played.maker.cases(self.read, played.family)

    @property
    def effect(self) -> str:
        """The effect that is hidden, as the catalogue calls it; for a case that hides one of its effects."""
        (own,) = self.case.label["truth"]
        return str(own)

    @property
    def document(self) -> dict[str, Any]:
        """What is known of a case that hides one effect of the catalogue, and whether it was named."""
        label, case = self.case.label, self.case
        return {
            "case": case.name,
            "kind": case.kind,
            "generator": label["configuration"]["generator"],
            "mismatch": label["configuration"]["mismatch"],
            "hidden": case.hidden,
            "effect": self.effect,
            "signal": case.signal,
            "is_named": case.outcome in (NAMED, IN_SET),
        }


def proof_parser(description: str | None) -> argparse.ArgumentParser:
    """Return a parser of the options that these tables share: proofs, workers, bank and file."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("proofs", type=Path, nargs="+")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--bank", type=Path, default=cache_folder() / "generators")
    parser.add_argument("--json", type=Path)
    return parser


def proof_cases(given: argparse.Namespace, kinds: Sequence[str]) -> list[ProofCase]:
    """Return the cases of these kinds, in the order of proofs and names.

    Parameters
    ----------
    given : Namespace
        Options of `proof_parser`.
    kinds : sequence of str
        Kinds of cases.
    """
    folders = [ProofFolder(path.absolute()) for path in given.proofs]
    return [
        ProofCase(folder, case, given.bank) for folder in folders for case in scored_cases(folder) if case.kind in kinds
    ]


def of_cases(said: Callable[[ProofCase], T], cases: Sequence[ProofCase], workers: int) -> Iterator[T]:
    """Yield what a function says of each case; so many workers execute it."""
    for outcome in make_scheduler(workers).outcomes(said, cases):
        yield outcome.value

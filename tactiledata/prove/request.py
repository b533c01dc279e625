"""What a proof is asked to do: configurations, counts of each kind of case, seeds, and how it is diagnosed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any

from tactiledata.errors import UnknownName, UsageError
from tactiledata.prove.cases.configuration import Configuration
from tactiledata.prove.cases.draw import CaseRequest
from tactiledata.prove.cases.kinds import KINDS
from tactiledata.prove.cases.truth import OUTSIDE, TITLES
from tactiledata.prove.worlds.generators import GENERATORS
from tactiledata.prove.worlds.plan_names import named_plan

MOST_CASES = 100_000
"""Largest number of cases of a proof."""


@dataclass(frozen=True)
class ProofRequest:
    """What a proof is asked to do.

    Parameters
    ----------
    generators, plans : tuple of str
        Every generator records every plan.
    mismatches, noises : tuple of float
        Sizes of the solvers' errors, and factors on the noise: each with each is a configuration.
    counts : dict, kind -> int
        Number of cases of each kind in each configuration.
    seed : int
        Seed of all draws.
    only : tuple of str
        Hidden effects, by the rig's names; all where empty.
    with_variants : bool
        Whether effects that need other gels take part, as hidden ones and as candidates.
    pairs : bool
        Whether the diagnosis tries pairs of effects.
    in_full : bool
        Whether gels on which an answer could rest are played in full.
    """

    generators: tuple[str, ...] = ("layer", "analytic")
    plans: tuple[str, ...] = ("wedge-2",)
    mismatches: tuple[float, ...] = (1.0,)
    noises: tuple[float, ...] = (1.0,)
    counts: Mapping[str, int] = field(default_factory=dict)
    seed: int = 0
    only: tuple[str, ...] = ()
    with_variants: bool = True
    pairs: bool = True
    in_full: bool = False

    @property
    def configurations(self) -> list[Configuration]:
        """All configurations, plan by plan, so that plays are shared; each has errors of a solver of its own."""
        places = product(self.plans, self.generators, self.mismatches, self.noises)
        return [
            Configuration(generator, plan, mismatch, 1000 * self.seed + number, noise)
            for number, (plan, generator, mismatch, noise) in enumerate(places)
        ]

    def requests(self, bank: Path) -> list[CaseRequest]:
        """Return all cases that are to be drawn.

        Parameters
        ----------
        bank : Path
            Folder of kept solutions of generators.
        """
        asked = [
            (configuration, kind)
            for configuration in self.configurations
            for kind in KINDS
            for _ in range(self.counts.get(kind, 0))
        ]
        return [
            CaseRequest(number, kind, configuration, self.seed, bank, self.with_variants, self.only)
            for number, (configuration, kind) in enumerate(asked)
        ]

    @property
    def document(self) -> dict[str, Any]:
        """The request as it is kept in the folder of the proof."""
        return {key: list(value) if isinstance(value, tuple) else value for key, value in asdict(self).items()}

    @staticmethod
    def of(document: Mapping[str, Any]) -> ProofRequest:
        """Return the request of a document.

        Raises
        ------
        UsageError
            The document is no request.
        """
        try:
            values: dict[str, Any] = {
                key: tuple(value) if isinstance(value, list) else value for key, value in document.items()
            }
            return ProofRequest(**values).checked()
        except (TypeError, AttributeError) as error:
            raise UsageError(f"a request with other fields ({error})", "the request of a proof") from error

    def checked(self) -> ProofRequest:
        """Return the request; refuse names that nothing has, numbers that mean nothing, and requests of no case.

        Raises
        ------
        UsageError
            Something of it cannot be done.
        """
        for name in self.generators:
            if name not in GENERATORS:
                raise UnknownName("generator", name, GENERATORS)
        for name in self.plans:
            named_plan(name)
        for name in self.only:
            if name not in (*TITLES, *OUTSIDE):
                raise UnknownName("hidden effect", name, (*TITLES, *OUTSIDE))
        for kind, count in self.counts.items():
            if kind not in KINDS or count < 0:
                raise UsageError(f"{count} cases of kind {kind!r}", f"0 or more, of {', '.join(KINDS)}")
        for what, values in (("mismatch", self.mismatches), ("noise", self.noises)):
            if not values or any(not 0.0 <= value <= 100.0 for value in values):
                raise UsageError(f"{what} {', '.join(map(str, values)) or 'of nothing'}", "numbers from 0 to 100")
        total = len(self.configurations) * sum(self.counts.values())
        if not 0 < total <= MOST_CASES:
            raise UsageError(f"{total} cases", f"1 to {MOST_CASES}", "Say how many: --nulls 2 --visible 2, or --quick.")
        return self

    def with_counts(self, counts: Mapping[str, int]) -> ProofRequest:
        """Return the same request with other counts."""
        return replace(self, counts={kind: count for kind, count in counts.items() if count})


QUICK = ProofRequest(
    generators=("layer", "analytic"),
    plans=("wedge-2x10",),
    counts={"nulls": 4, "visible": 3, "concealed": 1, "pairs": 1, "outside": 1},
)
"""A proof of 20 cases that two processors finish in some minutes."""

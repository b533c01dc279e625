"""A case of a proof: a world, what it hides, and what counts as a right answer. Its document is the sealed label."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tactiledata.prove.cases.configuration import Configuration
from tactiledata.prove.cases.truth import TITLES


@dataclass(frozen=True)
class WorldCase:
    """A world and what it hides.

    Parameters
    ----------
    kind : str
        One of ``KINDS``.
    configuration : Configuration
        Generator, plan, errors of the solver and noise.
    seed : int
        Seed of the world's gel, noise, offsets and draws.
    hidden : tuple of dict
        Hidden effects as a scenario states them.
    material : (3,)
        E (Pa), nu and mu of the real gel.
    modulus_left, friction_left : float
        Factors on E and mu that make of them what a fit with the effect should find.
    sight : dict
        How much of the effect can be seen; empty where nothing is hidden.
    """

    kind: str
    configuration: Configuration
    seed: int
    hidden: tuple[Mapping[str, Any], ...]
    material: tuple[float, float, float]
    modulus_left: float = 1.0
    friction_left: float = 1.0
    sight: Mapping[str, Any] | None = None

    @property
    def truth(self) -> tuple[str, ...]:
        """Names of the hidden effects in the catalogue; none for what it does not hold."""
        return tuple(TITLES[one["effect"]] for one in self.hidden if one["effect"] in TITLES)

    @property
    def document(self) -> dict[str, Any]:
        """The label of the case, as it is sealed."""
        return {
            "kind": self.kind,
            "configuration": self.configuration.document,
            "seed": self.seed,
            "hidden": [dict(one) for one in self.hidden],
            "truth": list(self.truth),
            "material": list(self.material),
            "modulus_left": self.modulus_left,
            "friction_left": self.friction_left,
            "sight": dict(self.sight or {}),
        }

"""Cases of missing physics that a benchmark asks for: kinds, hidden effects, strengths and seeds."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from tactiledata.prove.cases.strengths import drawn_parameters
from tactiledata.prove.cases.truth import OUTSIDE, PAIRS, TITLES, WrongRadius
from tactiledata.prove.worlds.plan import INDENTERS
from tactiledata.rig.hidden.base import HiddenEffect

DRAWN = "drawn"
"""Strength of which all numbers are drawn by the seed."""
KINDS = ("nulls", "effects", "outside", "pairs", "metadata")


@dataclass(frozen=True)
class Asked:
    """One case.

    Parameters
    ----------
    kind : str
    effects : the rig's names of what is hidden
    strength : str
        One of the rig's, or ``DRAWN``.
    seed : int
    wrong : (indenter, share) whose radius is not as stated
    """

    kind: str
    effects: tuple[str, ...]
    strength: str
    seed: int
    wrong: tuple[tuple[str, float], ...] = ()

    @property
    def label(self) -> str:
        """For the file."""
        wrong = [f"{name}{100 * share:+.0f}%" for name, share in self.wrong]
        return " ".join([self.kind, *self.effects, *wrong, self.strength, str(self.seed)])

    @property
    def hidden(self) -> list[dict[str, Any]]:
        """Of the scenario."""
        if self.strength == DRAWN:
            return [{"effect": name, "parameters": drawn_parameters(name, self.seed)} for name in self.effects]
        return [{"effect": name, "strength": self.strength} for name in self.effects]

    @property
    def more(self) -> tuple[HiddenEffect, ...]:
        """Effects that no scenario states."""
        return tuple(WrongRadius(name, share) for name, share in self.wrong)

    @property
    def truth(self) -> tuple[str, ...]:
        """The catalogue's names; none for what it does not hold."""
        return tuple(TITLES[name] for name in self.effects if name in TITLES) + ("mount_offset",) * bool(self.wrong)


def asked_cases(kinds: Iterable[str], count: int, strength: str) -> list[Asked]:
    """So many cases of each kind; of each effect so many."""
    found = []
    for kind in kinds:
        if kind == "nulls":
            found += [Asked(kind, (), "none", 1000 + number) for number in range(count)]
        elif kind == "metadata":
            names = [name for name in INDENTERS if "radius" in INDENTERS[name]]
            wrong = [(names[number % len(names)], 0.05 * (-1) ** number) for number in range(count)]
            found += [Asked(kind, (), "5%", 5000 + number, (one,)) for number, one in enumerate(wrong)]
        else:
            hidden = {"effects": [(name,) for name in TITLES], "outside": [(name,) for name in OUTSIDE], "pairs": PAIRS}
            first = {"effects": 2000, "outside": 3000, "pairs": 4000}[kind]
            found += [Asked(kind, names, strength, first + number) for number in range(count) for names in hidden[kind]]
    return found

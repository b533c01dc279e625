"""Kinds of cases, and from when on an effect can be seen or is concealed."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any

NULLS, VISIBLE, CONCEALED, PAIRS = "nulls", "visible", "concealed", "pairs"
OUTSIDE, AMBIGUOUS, DRAWN = "outside", "ambiguous", "drawn"
KINDS = (NULLS, VISIBLE, CONCEALED, PAIRS, OUTSIDE, AMBIGUOUS, DRAWN)
"""Kinds of cases; ``drawn`` are single effects of any strength, visible or not."""
LEAST_SIGNAL = 8.0
"""Signal from which a hidden effect is called visible."""
LOSS_RATIO = 1.15
"""Ratio of the paper's loss with and without the effect up to which a calibration conceals it."""
ABSORBED = 0.8
"""Share of the squared change that a refit of E, nu, mu and nuisances absorbs, from which it conceals an effect."""
ALIKE = 0.95
"""Cosine from which an effect of the catalogue resembles what is hidden."""
TOLD_APART = 4.0
"""Signal of what a resembling effect cannot imitate, from which data tell the two apart: evidence of 8."""


@dataclass(frozen=True)
class Sight:
    """How much can be seen of what a world hides.

    Parameters
    ----------
    signal : float
        Root of the squares, in units of the noise, that the plain simulation leaves of it after a refit.
    absorbed : float
        Share of its squared change that this refit absorbs.
    loss_ratio : float
        The paper's loss after a calibration, over that of the same world without what is hidden.
    alike : dict, effect -> float
        Effects of the catalogue by the cosine with which they can imitate the change; those above ``ALIKE``.
    unhidden : (3,)
        E (Pa), nu and mu of the plain fit to the world without what is hidden.
    """

    signal: float
    absorbed: float
    loss_ratio: float
    alike: dict[str, float] = field(default_factory=dict)
    unhidden: tuple[float, ...] = ()

    @property
    def is_visible(self) -> bool:
        """Whether the signal is large enough to be seen at all."""
        return self.signal >= LEAST_SIGNAL

    @property
    def is_concealed(self) -> bool:
        """Whether a calibration conceals it: the paper's loss hardly rises, or E, nu and mu absorb most of it."""
        return self.loss_ratio <= LOSS_RATIO or self.absorbed >= ABSORBED

    @property
    def imitators(self) -> tuple[str, ...]:
        """Effects that resemble the change so much that data do not tell them apart."""
        return tuple(name for name in self.alike if self.signal < self.largest_alike(name))

    def largest_alike(self, name: str) -> float:
        """Return the signal below which data do not tell one of the resembling effects from what is hidden."""
        apart = math.sqrt(1.0 - min(self.alike[name], 1.0) ** 2)
        return TOLD_APART / apart if apart > 0.0 else math.inf

    @property
    def document(self) -> dict[str, Any]:
        """The numbers, for a label."""
        return {**asdict(self), "unhidden": list(self.unhidden)}

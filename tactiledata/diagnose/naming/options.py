"""How to look for what a simulation lacks."""

from __future__ import annotations

from dataclasses import dataclass, field

from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS, DecisionThresholds
from tactiledata.diagnose.touches.whitened import NumericalErrors


@dataclass(frozen=True)
class NamingOptions:
    """How to look.

    Parameters
    ----------
    effects : names of candidates; all of the catalogue where ``None``
    errors : NumericalErrors
    scale : DecisionThresholds
    promising : float
        Logarithm of the first-order Bayes factor from which an effect is refitted.
    most_singles, most_paired, most_first, most_pairs : int
        At most so many are refitted; of the best so many, pairs are thought of, beside the best so many; so many pairs
        are refitted.
    pairs : bool
    robust : bool
        Whether frames that lie far off count for less (Huber).
    profile : bool
        Whether intervals of what is claimed come from the profile of the likelihood; from its curvature otherwise.
    seed : int
        Of the folds.
    """

    effects: tuple[str, ...] | None = None
    errors: NumericalErrors = field(default_factory=NumericalErrors)
    scale: DecisionThresholds = DEFAULT_THRESHOLDS
    promising: float = 0.0
    most_singles: int = 8
    most_paired: int = 6
    most_first: int = 2
    most_pairs: int = 3
    pairs: bool = True
    robust: bool = False
    profile: bool = True
    seed: int = 0

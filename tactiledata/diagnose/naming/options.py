"""The choices of a naming run: candidates, priors, thresholds and how many refits are made."""

from __future__ import annotations

from dataclasses import dataclass, field

from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS, DecisionThresholds
from tactiledata.diagnose.touches.simulation_errors import NumericalErrors


@dataclass(frozen=True)
class NamingOptions:
    """The choices of a naming run; the defaults are those with which the thresholds were measured.

    Parameters
    ----------
    effects : tuple of str, optional
        Names of the candidate effects; all of the catalogue where ``None``.
    errors : NumericalErrors
        Standard deviations of the simulation's own errors.
    thresholds : DecisionThresholds
        What a claim needs.
    promising : float
        Evidence to first order (`Screened.evidence`) above which an effect is refitted.
    most_singles : int
        Largest number of single effects that are refitted.
    most_paired : int
        Pairs are formed among this number of the best single refits.
    most_first : int
        The first effect of a pair is one of this number of the best single refits.
    most_pairs : int
        Largest number of pairs that are refitted.
    pairs : bool
        Whether pairs of effects are tried at all.
    robust : bool
        Whether frames with large residuals get smaller weights (Huber).
    profile : bool
        Whether intervals of a claim come from the profile of the likelihood; from its curvature otherwise.
    seed : int
        Random seed with which trajectories are dealt to folds.
    """

    effects: tuple[str, ...] | None = None
    errors: NumericalErrors = field(default_factory=NumericalErrors)
    thresholds: DecisionThresholds = DEFAULT_THRESHOLDS
    promising: float = 0.0
    most_singles: int = 8
    most_paired: int = 6
    most_first: int = 2
    most_pairs: int = 3
    pairs: bool = True
    robust: bool = False
    profile: bool = True
    seed: int = 0

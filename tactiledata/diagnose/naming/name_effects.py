"""Naming what a simulation lacks: plain fit, screen, refits of single effects and pairs, decision, intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.decide import Decision
from tactiledata.diagnose.naming.error_sizes import (
    size_penalty,
    smallest_ratio,
    with_errors_of,
    with_estimated_sizes,
)
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.held_out import held_out
from tactiledata.diagnose.naming.identifiability import Identifiability, identifiability_of
from tactiledata.diagnose.naming.intervals import ProfiledInterval, intervals
from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit, plain_fit
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.refit import Refits
from tactiledata.diagnose.naming.screen import Screened, screen
from tactiledata.diagnose.naming.signatures import Signature, effect_signatures, playable
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial

SMALLER = 0.85
"""Ratio of a size of the simulation's errors beside the best effect to that without it below which all is refitted."""


@dataclass(frozen=True)
class NamingResult:
    """The answer and every intermediate result that led to it.

    Parameters
    ----------
    whitened : WhitenedTouches
        The trajectories in units of their noise.
    base : JointFit
        Fit of the plain simulation.
    intervals_before, intervals : tuple of ProfiledInterval
        Intervals of E, nu and mu in the plain fit; of these and of the effects' numbers in the decision's best fit.
    identifiable : Identifiability
        Which effects these trajectories could show at all.
    screened : list of Screened
        First-order scores of all effects that were tried.
    scored : list of ScoredCandidate
        Single effects and pairs that were refitted.
    decision : Decision
        The answer.
    not_tried : tuple of str
        Effects that depend on covariates which some touches do not have.
    """

    whitened: WhitenedTouches
    base: JointFit
    intervals_before: tuple[ProfiledInterval, ...]
    intervals: tuple[ProfiledInterval, ...]
    identifiable: Identifiability
    screened: list[Screened]
    scored: list[ScoredCandidate]
    decision: Decision
    not_tried: tuple[str, ...]


def name_effects(
    touch_set: TouchSet,
    material: GelMaterial,
    options: NamingOptions | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> NamingResult:
    """Return which known effect the simulation lacks, with all fits that led to the answer.

    Parameters
    ----------
    touch_set : TouchSet
        Measured trajectories, and the simulation without effects.
    material : GelMaterial
        Start of the fits, as a plain calibration found it.
    options : NamingOptions, optional
        Candidates, priors, thresholds and numbers of refits; the defaults where ``None``.
    progress : callable
        Called with a few words at the beginning of each step.

    Raises
    ------
    TactileDataError
        Too few trajectories, or too few frames in one of them.
    """
    chosen = options or NamingOptions()
    touch_set.need_touches()
    whitened = WhitenedTouches.of(touch_set, chosen.errors)
    # plain fit
    progress("plain fit")
    base = plain_fit(whitened, material)
    if chosen.robust:
        whitened = whitened.with_trust(_huber(base.residual))
        base = plain_fit(whitened, base.model.material)
    # errors of the simulation: as large as the data ask for, with fields where the plain fit ended
    whitened = with_estimated_sizes(whitened, base)
    numerical = whitened.simulation_error_fields(base.model.material, base.model.offsets)
    base = joint_fit(whitened, numerical, base.model)
    # screen and refits of single effects
    names, not_tried = playable(whitened, chosen.effects)
    progress("screen")
    signatures, screened = _screened(whitened, base, names)
    fits = Refits(whitened, base, chosen, progress)
    singles = fits.singles(screened)
    # what is missing made the errors of the simulation look larger: their sizes are those beside the best effect
    best_single = max(singles, key=lambda fit: _evidence(base, fit), default=None)
    if best_single is not None and _evidence(base, best_single) >= chosen.thresholds.needed(best_single.names):
        resized = with_estimated_sizes(whitened, best_single)
        if smallest_ratio(whitened, resized) < SMALLER:
            reference, penalty = held_out(whitened, base, chosen.seed), size_penalty(whitened, base, resized)
            numerical = resized.simulation_error_fields(base.model.material, base.model.offsets)
            base = joint_fit(resized, numerical, with_errors_of(base.model, whitened, resized))
            whitened = resized
            signatures, screened = _screened(whitened, base, names)
            fits = Refits(whitened, base, chosen, progress, reference, penalty)
            singles = fits.singles(screened)
    pairs = fits.pairs(screened, singles) if chosen.pairs else []
    scored, decision = fits.score_and_decide(singles, pairs)
    # intervals; a profile needs many plays and is taken of a claim alone
    progress("intervals")
    claimed = decision.best is not None and not decision.objections
    best = decision.best.fit if decision.best is not None else base
    before, after = (
        intervals(whitened, fit, max(1.0, decision.left.dispersion), chosen.profile and claimed) for fit in (base, best)
    )
    identifiable = identifiability_of(base.metric, signatures, tuple(not_tried), names)
    return NamingResult(whitened, base, before, after, identifiable, screened, scored, decision, tuple(not_tried))


def _screened(
    whitened: WhitenedTouches, base: JointFit, names: Sequence[str]
) -> tuple[list[Signature], list[Screened]]:
    """Signatures of effects about a plain fit, and their first-order scores."""
    signatures = effect_signatures(whitened, base.model.material, names, offsets=base.model.offsets)
    return signatures, screen(base.metric, base.residual_at_centre, signatures)


def _evidence(base: JointFit, fit: JointFit) -> float:
    """Logarithm of the Bayes factor of a refit against the plain fit (Laplace's approximation)."""
    return 0.5 * (base.cost - fit.cost) - fit.occam


def _huber(residual: Array, turn: float = 2.0) -> Array:
    """Square roots of Huber's weights (N,) of frames, from whitened residuals (N, 6).

    Parameters
    ----------
    turn : float
        Size of a residual, in medians of all sizes, up to which the weight is 1; beyond, it falls as 1 / size.
    """
    size = np.sqrt((residual**2).mean(axis=1))
    usual = max(float(np.median(size)), 1e-300)
    return np.sqrt(np.minimum(1.0, turn * usual / np.maximum(size, 1e-300)))

"""Naming what a simulation lacks: plain fit, screen, refits of single effects and pairs, decision, intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.compute.base import Scheduler
from tactiledata.compute.local import LocalScheduler
from tactiledata.compute.threads import one_thread
from tactiledata.diagnose.naming.decide import Decision
from tactiledata.diagnose.naming.error_sizes import (
    size_penalty,
    smallest_ratio,
    with_errors_of,
    with_estimated_errors,
    with_estimated_sizes,
)
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.held_out import held_out
from tactiledata.diagnose.naming.identifiability import Identifiability, identifiability_of
from tactiledata.diagnose.naming.intervals import (
    IntervalRequest,
    ProfiledInterval,
    intervals,
    profiled_intervals,
)
from tactiledata.diagnose.naming.joint_fit import JointFit, plain_fit
from tactiledata.diagnose.naming.kept_fits import KeptFits
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.own_error_sizes import OddTouch, odd_touches, with_estimated_own_sizes
from tactiledata.diagnose.naming.refit import Refits
from tactiledata.diagnose.naming.screen import Screened, screen
from tactiledata.diagnose.naming.signatures import Signature, effect_signatures, playable
from tactiledata.diagnose.naming.thresholds import DEFAULT_THRESHOLDS, DecisionThresholds
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial

SMALLER = 0.85
"""Everything is refitted if, with the best effect, some size of errors falls below this share of its value without."""


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
    odd : tuple of OddTouch
        Touches whose forces do not belong to the others, in the decision's best fit.
    thresholds : DecisionThresholds
        The thresholds for these trajectories.
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
    odd: tuple[OddTouch, ...] = ()
    thresholds: DecisionThresholds = DEFAULT_THRESHOLDS


@one_thread()
def name_effects(
    touch_set: TouchSet,
    material: GelMaterial,
    options: NamingOptions | None = None,
    progress: Callable[[str], None] = lambda text: None,
    kept: KeptFits | None = None,
    runner: Scheduler | None = None,
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
    kept : KeptFits, optional
        Fits of an earlier naming of these trajectories, which are not made again; those of this one are added.
    runner : Scheduler, optional
        Where several refits are made at a time; in this process where ``None``. The answer does not depend on it.

    Raises
    ------
    TactileDataError
        Too few trajectories, or too few frames in one of them.
    """
    chosen = options or NamingOptions()
    kept = kept or KeptFits()
    touch_set.need_touches()
    whitened = WhitenedTouches.of(touch_set, chosen.errors)
    # plain fit
    progress("plain fit")
    base = plain_fit(whitened, material, kept.joint_fit)
    if chosen.robust:
        whitened = whitened.with_trust(_huber(base.residual))
        base = plain_fit(whitened, base.model.material, kept.joint_fit)
    # errors of the simulation: sizes that suit the data, and fields about the material of the plain fit
    whitened, base = with_estimated_errors(whitened, base, kept.joint_fit)
    # screen and refits of single effects, with smaller errors of the simulation where an effect explains these
    names, not_tried = playable(whitened, chosen.effects)
    progress("screen")
    refits = Refits(whitened, base, chosen, progress, kept=kept, runner=runner or LocalScheduler())
    tried = _with_smaller_errors(_tried(refits, names), names)
    whitened, base = tried.refits.whitened, tried.refits.base
    # pairs and decision
    pairs = tried.refits.pairs(tried.screened, tried.singles) if chosen.pairs else []
    scored, decision = tried.refits.score_and_decide(tried.singles, pairs)
    # intervals by the curvature
    best = decision.best.fit if decision.best is not None else base
    dispersion = max(1.0, decision.left.dispersion)
    before, after = (intervals(IntervalRequest(whitened, fit, dispersion)) for fit in (base, best))
    thresholds = tried.refits.thresholds
    identifiable = identifiability_of(base.metric, tried.signatures, thresholds, tuple(not_tried), names)
    odd = odd_touches(whitened, best)
    naming = NamingResult(
        whitened, base, before, after, identifiable, tried.screened, scored, decision, tuple(not_tried), odd,
        thresholds,
    )  # fmt: skip
    return with_profiles(naming, progress) if chosen.profile else naming


def with_profiles(
    naming: NamingResult, progress: Callable[[str], None] = lambda text: None, runner: Scheduler | None = None
) -> NamingResult:
    """Return a result whose intervals are those of the profile of the likelihood, where an effect is claimed.

    The profile needs many plays: it is worth them once the answer is final. Without a claim the result is returned as
    it is, with intervals by the curvature.

    Parameters
    ----------
    naming : NamingResult
        A result with intervals by the curvature.
    progress : callable
        Called with a word before the intervals are computed.
    runner : Scheduler, optional
        Where their ends are searched, each by itself; in this process where ``None``.
    """
    decision = naming.decision
    if decision.best is None or decision.objections:
        return naming
    progress("intervals")
    dispersion = max(1.0, decision.left.dispersion)
    asked = [IntervalRequest(naming.whitened, fit, dispersion) for fit in (naming.base, decision.best.fit)]
    before, after = profiled_intervals(asked, runner)
    return replace(naming, intervals_before=before, intervals=after)


@dataclass(frozen=True)
class _Tried:
    """Screen and refits of single effects at one choice of the sizes of the simulation's errors."""

    refits: Refits
    signatures: list[Signature]
    screened: list[Screened]
    singles: list[JointFit]

    def evidence(self, fit: JointFit) -> float:
        """Logarithm of the Bayes factor of a refit against the plain fit with the sizes that suit each best."""
        return 0.5 * (self.refits.base.cost - fit.cost) - fit.occam - self.refits.size_penalty

    @property
    def best(self) -> JointFit | None:
        """The refit with most evidence; ``None`` where nothing was refitted."""
        return max(self.singles, key=self.evidence, default=None)


def _tried(refits: Refits, names: Sequence[str]) -> _Tried:
    """Screen effects by their names about the plain fit, and refit the promising ones."""
    base = refits.base
    signatures = effect_signatures(refits.whitened, base.model.material, names, offsets=base.model.offsets)
    screened = screen(base.metric, base.residual_at_centre, signatures)
    return _Tried(refits, signatures, screened, refits.singles(screened))


def _with_smaller_errors(first: _Tried, names: Sequence[str]) -> _Tried:
    """Return refits with smaller errors of the simulation, if the best effect makes the data more likely with these.

    Physics that the plain fit lacks makes the errors of the simulation look larger than they are, and errors that are
    taken to be larger hide the missing physics.
    """
    refits, best = first.refits, first.best
    if best is None or first.evidence(best) < refits.options.thresholds.for_traces.needed(best.names):
        return first
    whitened = with_estimated_own_sizes(with_estimated_sizes(refits.whitened, best), best)
    if smallest_ratio(refits.whitened, whitened) >= SMALLER:
        return first
    base = refits.base
    second = _tried(
        replace(
            refits,
            whitened=whitened,
            base=refits.kept.joint_fit(whitened, with_errors_of(base.model, refits.whitened, whitened)),
            reference=held_out(refits.whitened, base, refits.options.seed),
            size_penalty=size_penalty(refits.whitened, base, whitened),
        ),
        names,
    )
    found = second.best
    return second if found is not None and second.evidence(found) > first.evidence(best) else first


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

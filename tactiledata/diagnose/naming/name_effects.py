"""Naming what a simulation lacks: screen, refits, pairs, and the answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.decide import Decision
from tactiledata.diagnose.naming.evidence import ScoredCandidate
from tactiledata.diagnose.naming.identifiability import Identifiability, identifiability_of
from tactiledata.diagnose.naming.intervals import ProfiledInterval, intervals
from tactiledata.diagnose.naming.joint_fit import JointFit, joint_fit, plain_fit
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.refit import Refits
from tactiledata.diagnose.naming.screen import Screened, screen
from tactiledata.diagnose.naming.signatures import effect_signatures, playable
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial


@dataclass(frozen=True)
class NamingResult:
    """Everything that was found on the way.

    Parameters
    ----------
    whitened : WhitenedTouches
    base : JointFit
        Of the plain simulation.
    intervals_before, intervals : tuple of ProfiledInterval
        Of E, nu, mu in the plain fit; of these and the effects' numbers in the best one.
    identifiable : Identifiability
        What these trajectories could tell at all.
    screened : list of Screened
    scored : list of ScoredCandidate
        Singles and pairs that were refitted.
    decision : Decision
    not_tried : effects that the touches do not tell enough for
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
    cases: TouchSet,
    material: GelMaterial,
    options: NamingOptions | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> NamingResult:
    """What the simulation lacks.

    Parameters
    ----------
    material : GelMaterial
        Where the fits begin, as a plain calibration found it.

    Raises
    ------
    TactileDataError
        Too few trajectories, or frames.
    """
    chosen = options or NamingOptions()
    cases.need_cases()
    white = WhitenedTouches.of(cases, chosen.errors)
    progress("plain fit")
    base = plain_fit(white, material)
    if chosen.robust:
        white = white.trusting(_huber(base.residual))
        base = plain_fit(white, base.model.material)
    numerical = white.simulation_error_fields(base.model.material, base.model.offsets)
    base = joint_fit(white, numerical, base.model)
    names, not_tried = playable(white, chosen.effects)
    progress("screen")
    signatures = effect_signatures(white, base.model.material, names, offsets=base.model.offsets)
    screened = screen(base.metric, base.undone, signatures)
    fits = Refits(white, numerical, base, chosen, progress)
    singles = fits.singles(screened)
    pairs = fits.pairs(screened, singles) if chosen.pairs else []
    judged, decision = fits.decided(singles, pairs)
    progress("intervals")
    claimed = decision.best is not None and not decision.objections
    best = decision.best.fit if decision.best is not None else base
    before, after = (
        intervals(white, fit, numerical, max(1.0, decision.left.dispersion), chosen.profile and claimed)
        for fit in (base, best)
    )
    identifiable = identifiability_of(base.metric, signatures, tuple(not_tried), names)
    return NamingResult(white, base, before, after, identifiable, screened, judged, decision, tuple(not_tried))


def _huber(residual: Array, turn: float = 2.0) -> Array:
    """Square roots of Huber's weights (N,) of frames: 1 up to ``turn`` times the usual size of a residual."""
    size = np.sqrt((residual**2).mean(axis=1))
    usual = max(float(np.median(size)), 1e-300)
    return np.sqrt(np.minimum(1.0, turn * usual / np.maximum(size, 1e-300)))

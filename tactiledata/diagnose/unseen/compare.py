"""Comparison of the plain simulation with the best fit on data that neither was fitted to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactiledata.contract.extras import need_packages
from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.locate import LEVEL, LocatorResults
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.simulator_share import simulator_share
from tactiledata.diagnose.residuals.ceiling import BlackBox, black_box
from tactiledata.diagnose.unseen.errors import FORCE, HeldOutErrors, held_out_errors
from tactiledata.diagnose.unseen.touch_residuals import known_rows, locate_touches

STRETCHED = 3.0
"""Standard deviations of its prior from which on an error of the simulation itself is unusual."""


@dataclass(frozen=True)
class HeldOutComparison:
    """Held-out errors, located structure and black box, before and after the effects that are claimed.

    Parameters
    ----------
    names : tuple of str
        Effects that are claimed; empty where none is.
    tried : tuple of str
        Effects of the fit "after": those that are claimed, else the nearest candidate; empty where there is none.
    errors : list of HeldOutErrors
        Errors with trajectories, indenters and sensors held out, in that order.
    located : LocatorResults
        Results of the locators on what the plain simulation leaves.
    left_over : LocatorResults, optional
        Results of the locators on what the claimed effects leave; ``None`` where none is claimed.
    ceiling : BlackBox
        Boosted trees on what the plain simulation leaves, trajectories held out.
    ceiling_force : float
        Force error that plain simulation and boosted trees reach together on held-out trajectories, N.
    stretched : dict, words -> float
        Errors of the simulation itself that the plain fit needs, in standard deviations of their priors; only those
        of at least `STRETCHED`.
    """

    names: tuple[str, ...]
    tried: tuple[str, ...]
    errors: list[HeldOutErrors]
    located: LocatorResults
    left_over: LocatorResults | None
    ceiling: BlackBox
    ceiling_force: float
    stretched: dict[str, float]

    @property
    def of_trajectories(self) -> HeldOutErrors:
        """Errors on held-out trajectories, which the page draws."""
        return self.errors[0]

    @property
    def hardest(self) -> HeldOutErrors:
        """Errors on held-out indenters where there are several; else on sensors, else on trajectories."""
        order = ("indenters", "sensors", "trajectories")
        return min(self.errors, key=lambda errors: order.index(errors.unseen))

    def worst(self, most: int = 3) -> list[int]:
        """Return the numbers of the trajectories with the largest force errors of the plain simulation."""
        return [int(number) for number in np.argsort(-self.of_trajectories.by_trajectory, kind="stable")[:most]]

    @property
    def flattened(self) -> tuple[Drift, Drift] | None:
        """The strongest certain drift before and after; ``None`` where there is none, or nothing is claimed."""
        if self.left_over is None or not self.located.is_certain("drifting parameters"):
            return None
        covariates = self.located.projection.residuals.covariates
        before, after = (
            {(drift.parameter, drift.covariate): drift for drift in results.drifts if drift.covariate in covariates}
            for results in (self.located, self.left_over)
        )
        for leading in self.located.leading:
            # a label cannot be drawn as an axis; a covariate that varies together with it can
            pairs = [(leading.parameter, name) for name in (leading.covariate, *leading.alike)]
            sloped = [
                pair
                for pair in pairs
                if pair in before and pair in after and before[pair].p <= LEVEL and before[pair].change.sharpness > 1.0
            ]
            if sloped:
                best = max(sloped, key=lambda pair: before[pair].change.sharpness)
                return before[best], after[best]
        return None


def show(
    naming: NamingResult,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
    located: LocatorResults | None = None,
    left_over: LocatorResults | None = None,
) -> HeldOutComparison:
    """Return how the plain simulation and the best fit do on held-out trajectories, indenters and sensors.

    Errors are those of `tactiledata.diagnose.unseen.errors`: refits to the other groups are linearised about the whole
    fit, then played. Which effect is claimed was decided with all trajectories; its strengths are refitted without the
    held-out ones.

    Parameters
    ----------
    naming : NamingResult
        Gives touches, plain fit, best fit and decision.
    seed : int
        Draws folds, sign flips and bootstraps.
    progress : callable
        Called with a few words when each step begins.
    located, left_over : LocatorResults, optional
        Results of the locators on the plain fit and on the fit with effects, where they are known already.

    Raises
    ------
    TactileDataError
        Too few trajectories, or scikit-learn is not installed.
    """
    need_packages("a diagnosis", "sklearn")
    white, base, decision = naming.whitened, naming.base, naming.decision
    names = decision.claimed
    after = decision.best.fit if decision.best is not None else base
    # where the plain simulation departs
    if located is None:
        progress("where they differ")
        located = locate_touches(white, base, seed, has_errors=not names)
    # errors on held-out data, without and with the best candidate, and of a black box
    progress("what is held out")
    errors = held_out_errors(white, (base, after), seed)
    progress("the ceiling")
    ceiling = black_box(located.projection, seed)
    # structure that the claimed effects leave
    if not names:
        left_over = None
    elif left_over is None:
        progress("what is left")
        left_over = locate_touches(white, after, seed)
    return HeldOutComparison(
        names, after.names, errors, located, left_over, ceiling, _ceiling_force(naming, errors[0], ceiling),
        _stretched(naming, base),
    )  # fmt: skip


def _ceiling_force(naming: NamingResult, errors: HeldOutErrors, ceiling: BlackBox) -> float:
    """Return the force error that plain simulation and black box reach together, N, on held-out trajectories.

    It is the root mean square of a component, and at most the error of the plain simulation.
    """
    white = naming.whitened
    rows = known_rows(white, errors.before)
    whitened = np.zeros((len(rows), 6))
    # residuals of the black box have unit variance in single readings, see `case_residuals`
    whitened[rows] = ceiling.predicted
    single = np.sqrt(np.array([case.noise.inflation for case in white.touch_set.touches]))[white.trajectory, None]
    explained = white.in_newtons(whitened / single)
    left = (white.measured - errors.before - explained)[rows][:, FORCE]
    return min(float(np.sqrt((left**2).mean())), errors.force.before)


def _stretched(naming: NamingResult, base: JointFit) -> dict[str, float]:
    """Return the unusual errors of the simulation itself in the plain fit, in standard deviations of their priors."""
    shares = simulator_share(naming.whitened, base)
    return {share.what: share.deviations for share in shares if abs(share.deviations) >= STRETCHED}

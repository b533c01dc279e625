"""What an effect does for data that it was not fitted to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tactiledata.diagnose.locate.drifts import Drift
from tactiledata.diagnose.locate.locate import LEVEL, LocatorResults
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.name_effects import NamingResult
from tactiledata.diagnose.naming.simulator_share import simulator_share
from tactiledata.diagnose.residuals.ceiling import BlackBox, black_box
from tactiledata.diagnose.residuals.learners import need_learning_library
from tactiledata.diagnose.unseen.errors import FORCE, HeldOutErrors, held_out_errors
from tactiledata.diagnose.unseen.touch_residuals import known_rows, locate_touches

STRETCHED = 3.0
"""Standard deviations of its prior, from which on an error of the simulation itself is no usual one."""


@dataclass(frozen=True)
class HeldOutComparison:
    """How much better the simulation tells what it has not seen.

    Parameters
    ----------
    names : tuple of str
        Effects that are claimed; empty where none is.
    tried : tuple of str
        Effects that "after" speaks of: those that are claimed, else the nearest candidate; empty where there is none.
    errors : list of HeldOutErrors
        Of trajectories, indenters, sensors, in that order.
    located : LocatorResults
        Of the plain simulation.
    left_over : LocatorResults, optional
        Of what the claimed effects leave; ``None`` where none is claimed.
    ceiling : BlackBox
        Boosted trees on what the plain simulation leaves, trajectories held out.
    ceiling_force : float
        N, the force error that they reach on trajectories.
    stretched : dict, words -> float
        Errors of the simulation itself, in standard deviations of their priors, that the plain fit needs.
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
        """Those of which the pictures are."""
        return self.errors[0]

    @property
    def hardest(self) -> HeldOutErrors:
        """Indenters held out, where there are several; else sensors, else trajectories."""
        order = ("indenters", "sensors", "trajectories")
        return min(self.errors, key=lambda one: order.index(one.unseen))

    def worst(self, most: int = 3) -> list[int]:
        """Numbers of the trajectories that the plain simulation tells worst."""
        return [int(number) for number in np.argsort(-self.of_trajectories.by_trajectory, kind="stable")[:most]]

    @property
    def flattened(self) -> tuple[Drift, Drift] | None:
        """The strongest certain dependence, before and after; ``None`` where there is none, or nothing is claimed."""
        if self.left_over is None or not self.located.is_certain("drifting parameters"):
            return None
        covariates = self.located.projection.residuals.covariates
        before, after = (
            {(drift.parameter, drift.covariate): drift for drift in one.drifts if drift.covariate in covariates}
            for one in (self.located, self.left_over)
        )
        for leading in self.located.leading:
            # a label that tells the same story as a covariate is no axis; the covariate is
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
    """The plain simulation and the best fit on trajectories, indenters and sensors that were held out.

    Held-out numbers are those of `tactiledata.diagnose.unseen.errors`: refits to the others are linearised about
    the whole fit, then played. Which effect is claimed was decided with all trajectories; its numbers were not.

    Parameters
    ----------
    located, left_over : LocatorResults, optional
        Of the plain fit and of that with the effects, where they are known already.

    Raises
    ------
    TactileDataError
        Too few trajectories, or scikit-learn is not installed.
    """
    need_learning_library()
    white, base, decision = naming.whitened, naming.base, naming.decision
    names = decision.best.names if decision.best is not None and decision.verdict in ("named", "one of a set") else ()
    after = decision.best.fit if decision.best is not None else base
    if located is None:
        progress("where they differ")
        located = locate_touches(white, base, seed)
    progress("what is held out")
    numerical = white.simulation_error_wrenches(base.model.material, base.model.offsets)
    errors = held_out_errors(white, (base, after), numerical, seed)
    progress("the ceiling")
    ceiling = black_box(located.projection, seed)
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
    """Root mean square, N, of the force that black box and plain simulation leave together of trajectories held out."""
    white = naming.whitened
    rows = known_rows(white, errors.before)
    whitened = np.zeros((len(rows), 6))
    # black box and locators count in single noise, see `case_residuals`
    whitened[rows] = ceiling.predicted
    single = np.sqrt(np.array([case.noise.inflation for case in white.touch_set.touches]))[white.trajectory, None]
    explained = white.in_newtons(whitened / single)
    left = (white.measured - errors.before - explained)[rows][:, FORCE]
    return min(float(np.sqrt((left**2).mean())), errors.force.before)


def _stretched(naming: NamingResult, base: JointFit) -> dict[str, float]:
    found = simulator_share(naming.whitened, base)
    return {one.what: one.deviations for one in found if abs(one.deviations) >= STRETCHED}

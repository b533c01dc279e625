"""Sizes of what the simulation gets wrong in single touches, for each indenter, estimated from the data at hand.

An error that repeats in every touch of an indenter is one of `simulation_errors`. What is left of it differs from touch
to touch, as with the direction in which a tilted edge slides. It is large under an indenter with steep walls and small
under a ball, so that each indenter has a size of its own: touches that the simulation gets wrong pull less at material
and effects, and the others keep their weight.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.touches.own_errors import FACTORS
from tactiledata.diagnose.touches.whitened import WhitenedTouches

DOUBT = 0.7
"""Standard deviation of the logarithm of a size about 0, as of the sizes of `error_sizes`."""
SMALLEST, LARGEST = 1.0, 6.0
"""Bounds of a size: the arm alone brings the usual one, and beyond 6 % of all forces a touch says nothing of a gel."""
ODD = 4.0
"""Deviations of a factor, by the size of its indenter, from which a touch does not belong to the others."""


@dataclass(frozen=True)
class OddTouch:
    """One touch whose forces differ from the simulation by far more than other touches of its indenter.

    Parameters
    ----------
    name : str
        Name of the trajectory.
    unknown : str
        One of ``FACTORS``.
    factor : float
        The fitted factor; 1 where the touch is as simulated.
    deviation : float
        Prior standard deviation of that factor in touches of the indenter.
    """

    name: str
    unknown: str
    factor: float
    deviation: float


def odd_touches(whitened: WhitenedTouches, fit: JointFit) -> tuple[OddTouch, ...]:
    """Return touches with a factor on their forces or shear beyond ``ODD`` deviations, in the order of trajectories.

    A trajectory is one touch. Beside what all touches share it has two factors of its own, one on all of its forces and
    torques and one on its shear force, both 1 where the touch is as simulated. They are estimated by the mean of their
    posterior, with the touch's other own errors (`OwnErrors`), given the residual of the fit. A touch is odd where an
    estimate differs from 1, either way, by more than ``ODD`` times the factor's prior standard deviation in touches of
    its indenter. A touch with both factors beyond is returned twice; without any the result is empty. In a touch
    without shear the factor on shear is 1.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories in units of the noise, with the sizes of their own errors.
    fit : JointFit
        Fit to them.
    """
    usual = dict(zip(FACTORS, (whitened.own.force, whitened.own.shear), strict=True))
    names = whitened.own.names()
    found = []
    for case, touch in zip(whitened.touch_set.touches, _touches(whitened, fit), strict=True):
        size = whitened.own.size(case.indenter)
        deviations = touch.posterior_mean(size)
        for unknown in FACTORS:
            off, deviation = deviations[names.index(unknown)], size * usual[unknown]
            if abs(off) > ODD:
                found.append(OddTouch(case.name, unknown, float(1.0 + off * deviation), deviation))
    return tuple(found)


def with_estimated_own_sizes(whitened: WhitenedTouches, fit: JointFit) -> WhitenedTouches:
    """Return the trajectories with the sizes of own factors that make the residual of a fit most likely.

    A size (`OwnErrors.sizes`) is from ``SMALLEST`` to ``LARGEST``. For each indenter by itself it maximises the
    marginal likelihood of the residual of its trajectories, with everything that trajectories share as fitted, times a
    log-normal prior (empirical Bayes).

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories.
    fit : JointFit
        Fit to them.
    """
    found = {}
    for name, touches in _by_indenter(whitened, fit).items():
        bounds = np.log(SMALLEST), np.log(LARGEST)
        best = minimize_scalar(_cost, args=(touches,), bounds=bounds, method="bounded")
        found[name] = float(np.exp(best.x))
    return replace(whitened, own=whitened.own.with_sizes(found))


def own_size_penalty(whitened: WhitenedTouches, fit: JointFit, sizes: Mapping[str, float]) -> float:
    """Return by how much the logarithm of a fit's marginal likelihood falls with other sizes; at least 0.

    Parameters
    ----------
    whitened : WhitenedTouches
        Trajectories with the sizes of the fit.
    fit : JointFit
        Fit to them.
    sizes : dict, indenter -> float
        The other sizes; 1 for an indenter that has no entry.
    """
    change = 0.0
    for name, touches in _by_indenter(whitened, fit).items():
        now, other = whitened.own.size(name), sizes.get(name, 1.0)
        change += _cost(np.log(other), touches) - _cost(np.log(now), touches)
    return max(0.0, 0.5 * change)


@dataclass(frozen=True)
class _Touch:
    """One trajectory's residual and own unknowns, the noise whitened and nothing marginalised.

    Parameters
    ----------
    gram : (r, r)
        Products of the changes over one deviation of each unknown, own factors at size 1.
    toward : (r,)
        Products of these changes with the residual.
    square : float
        Square of the residual.
    is_factor : (r,) bool
        Unknowns that the size of the indenter multiplies.
    """

    gram: Array
    toward: Array
    square: float
    is_factor: Array

    def at(self, size: float) -> tuple[Array, Array]:
        """Return the precision (r, r) of the unknowns, in standard deviations at a size, and the pull (r,) on them."""
        scale = np.where(self.is_factor, size, 1.0)
        return np.eye(len(scale)) + self.gram * np.outer(scale, scale), self.toward * scale

    def posterior_mean(self, size: float) -> Array:
        """Return the mean (r,) of the unknowns given the residual, in standard deviations, at a size."""
        precision, pull = self.at(size)
        return np.asarray(np.linalg.solve(precision, pull), dtype=np.float64)

    def cost(self, size: float) -> float:
        """Return twice the negative logarithm of the marginal likelihood, up to a constant, at a size."""
        precision, pull = self.at(size)
        determinant = float(np.linalg.slogdet(precision)[1])
        return self.square - float(pull @ np.linalg.solve(precision, pull)) + determinant


def _touches(whitened: WhitenedTouches, fit: JointFit) -> list[_Touch]:
    """Return each trajectory, the contact offset as one more unknown."""
    residual = whitened.with_own(fit.residual + fit.own * fit.by_row)
    fields = np.concatenate([whitened.own_fields, whitened.with_own(fit.own)[:, :, None]], axis=2)
    is_factor = np.append(np.isin(whitened.own.names(), FACTORS), False)
    ends = np.append(whitened.starts, len(residual))
    found = []
    for start, end, case in zip(ends[:-1], ends[1:], whitened.touch_set.touches, strict=True):
        rows, change = residual[start:end].ravel(), fields[start:end].reshape(-1, fields.shape[2])
        change = change / np.where(is_factor, whitened.own.size(case.indenter), 1.0)
        found.append(_Touch(change.T @ change, change.T @ rows, float(rows @ rows), is_factor))
    return found


def _by_indenter(whitened: WhitenedTouches, fit: JointFit) -> dict[str, list[_Touch]]:
    """Return the trajectories of each indenter."""
    found: dict[str, list[_Touch]] = {}
    for name, touch in zip(whitened.touch_set.indenters, _touches(whitened, fit), strict=True):
        found.setdefault(str(name), []).append(touch)
    return found


def _cost(logarithm: float, touches: Sequence[_Touch]) -> float:
    """Twice the negative logarithm of the likelihood of trajectories and of the prior, at a size's logarithm."""
    size = float(np.exp(logarithm))
    return sum(touch.cost(size) for touch in touches) + (logarithm / DOUBT) ** 2

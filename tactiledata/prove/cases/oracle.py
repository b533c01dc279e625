"""How much of a hidden effect can be seen: what a plain simulation leaves of it, and what a calibration by force sees.

The generator tells its world without noise, with what it hides and without. These oracles know the truth; nothing of
them enters a diagnosis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.joint_fit import JointFit, plain_fit
from tactiledata.diagnose.naming.metric import best_imitation
from tactiledata.diagnose.naming.options import NamingOptions
from tactiledata.diagnose.naming.signatures import effect_signatures, playable
from tactiledata.diagnose.touches.own_errors import OwnErrors
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.prove.cases.kinds import ALIKE
from tactiledata.prove.worlds.played_plan import START

RATIOS, FRICTIONS = 5, 5
"""Number of Poisson's ratios and of friction coefficients that the paper's calibration tries."""


def with_wrenches(touch_set: TouchSet, wrenches: Array) -> TouchSet:
    """Return the trajectories with other measured wrenches (N, 6), N and N m, one trajectory after the other."""
    ends = np.cumsum(touch_set.counts)[:-1]
    pairs = zip(touch_set.touches, np.split(wrenches, ends), strict=True)
    return replace(touch_set, touches=[replace(case, measured=one) for case, one in pairs])


def refit(touch_set: TouchSet, wrenches: Array) -> JointFit:
    """Return the plain simulation fitted to wrenches (N, 6) without noise; its cost is in squares of the noise."""
    return plain_fit(WhitenedTouches.of(with_wrenches(touch_set, wrenches), NamingOptions().errors), START)


def plain_whitened(touch_set: TouchSet, change: Array) -> Array:
    """Return a change (N, 6), N and N m, in units of noise and scatter; nothing that a fit absorbs is taken out."""
    own = OwnErrors(slope=0.0, place=0.0, force=0.0, shear=0.0, locked=0.0)
    return WhitenedTouches.of(touch_set, NamingOptions().errors, own).whiten(change)


@dataclass(frozen=True)
class PaperCalibration:
    """The calibration of the SPLIT paper: E, nu and mu that minimise the mean difference of the norms of force.

    Forces are proportional to E, so that the best E at a nu and a mu is a weighted median.

    Parameters
    ----------
    norms : (k, N)
        Simulated norms of force over Young's modulus, m^2, at k pairs of nu and mu.
    """

    norms: Array

    @staticmethod
    def of(touch_set: TouchSet) -> PaperCalibration:
        """Return the calibration of a plan's touches; the norms are the same for all worlds of the plan."""
        low, high = np.array(touch_set.box.low), np.array(touch_set.box.high)
        pairs = [
            (ratio, friction)
            for ratio in np.linspace(low[1], high[1], RATIOS)
            for friction in np.linspace(low[2], high[2], FRICTIONS)
        ]
        played = [touch_set.play(GelMaterial(1e6, ratio, friction), []) for ratio, friction in pairs]
        return PaperCalibration(np.stack([np.linalg.norm(one[:, :3], axis=1) / 1e6 for one in played]))

    def loss(self, wrenches: Sequence[Array]) -> float:
        """Return the smallest mean absolute difference of norms, N, over all E, nu and mu.

        Parameters
        ----------
        wrenches : sequence of (n, 6), N and N m
            Measured wrenches of the touches.
        """
        measured = np.linalg.norm(np.concatenate(list(wrenches))[:, :3], axis=1)
        return min(_least_difference(measured, norms) for norms in self.norms)


def _least_difference(measured: Array, norms: Array) -> float:
    """Return the mean absolute difference of norms (N,) and measured ones (N,) at the best factor."""
    used = (norms > 0) & np.isfinite(measured)
    if not used.any():
        return float(np.nanmean(np.abs(measured)))
    # the sum of |m - E n| = n |m / n - E| is least at the median of m / n with weights n
    ratios, weights = measured[used] / norms[used], norms[used]
    order = np.argsort(ratios)
    half = np.searchsorted(np.cumsum(weights[order]), 0.5 * weights.sum())
    factor = ratios[order][min(int(half), len(order) - 1)]
    return float(np.nanmean(np.abs(measured - factor * np.nan_to_num(norms))))


def alike_effects(plain: JointFit, touch_set: TouchSet, change: Array, effects: Sequence[str]) -> dict[str, float]:
    """Return the effects of the catalogue that can imitate a change, with their cosines; those above ``ALIKE``.

    Parameters
    ----------
    plain, touch_set, change, effects
        As of `imitations`.
    """
    found = imitations(plain, touch_set, change, effects)
    return {name: round(cosine, 4) for name, cosine in found.items() if cosine >= ALIKE}


def imitations(plain: JointFit, touch_set: TouchSet, change: Array, effects: Sequence[str]) -> dict[str, float]:
    """Return the cosine with which each effect of the catalogue can imitate a change, beyond what a refit takes up.

    The cosine is that of the change with the effect's signature, to first order, at the shape that a screen tries and
    that suits best.

    Parameters
    ----------
    plain : JointFit
        The plain fit without what is hidden.
    touch_set : TouchSet
        Trajectories and simulation.
    change : (N, 6), N and N m
        What is hidden changes.
    effects : sequence of str
        Effects of the catalogue that are compared.
    """
    white = WhitenedTouches.of(touch_set, NamingOptions().errors)
    names, _ = playable(white, tuple(effects))
    field_ = white.whiten(change)
    found: dict[str, float] = {}
    for one in effect_signatures(white, plain.model.material, names):
        cosine = float(best_imitation(plain.metric, field_, one.field))
        found[one.effect] = max(found.get(one.effect, 0.0), cosine)
    return found

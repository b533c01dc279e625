"""Wrenches of trajectories that a fit has not seen, played by the simulation itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactiledata.diagnose.effect_signatures import own_field
from tactiledata.diagnose.grouped_prediction import LinearRefits
from tactiledata.diagnose.joint_fit import JointFit
from tactiledata.diagnose.joint_model import JointModel
from tactiledata.diagnose.linearised import offset_steps
from tactiledata.diagnose.whitened_cases import WhitenedCases
from tactiledata.nuisance.offsets import FARTHEST, PRIOR

Array = NDArray[np.float64]

ROUNDS = 2


def held_out_wrenches(white: WhitenedCases, fit: JointFit, groups: NDArray[np.int64], numerical: Array) -> Array:
    """Wrenches (N, 6), N and N m, each group's by numbers that were fitted to the others; NaN where not simulated.

    E, nu, mu, the effects' numbers and the errors of the simulation move to where the other groups have them: one step
    of the whole fit's linearisation, as in `tactiledata.diagnose.grouped_prediction`. The wrench is then played anew.
    An indenter that was not fitted has no factor of its own. The contact offset and the sensor's zero, which nobody
    else can know, are those of the trajectory itself, under their priors.

    Parameters
    ----------
    groups : (t,)
        Number of each trajectory's group; at least two.
    numerical : (N, 6, e) N, N m
        One standard deviation of each error of the simulation, as in the fit.
    """
    refits = LinearRefits.of(white, fit)
    predicted = np.full((len(white.trajectory), 6), np.nan)
    for group in np.unique(groups):
        out = groups == group
        rows = out[white.trajectory]
        moved = fit.model.at(fit.model.vector + refits.change_without(out), fit.model.offsets[out])
        part = white.part(out)
        predicted[rows] = _with_own_offsets(part, moved, numerical[rows])
        predicted[rows] += _own_zeros(part, predicted[rows])
    return predicted


def zero_shares(white: WhitenedCases) -> Array:
    """Shares (t,) of a trajectory's mean residual that are taken for its zero, from what its free air tells of it."""
    known = np.add.reduceat(white.weights**2, white.starts) * white.tare
    return known / (1.0 + known)


def _own_zeros(part: WhitenedCases, predicted: Array) -> Array:
    """Most likely zeros (N, 6), N and N m, of trajectories beside what is predicted of them."""
    weights = np.where(np.isfinite(predicted).all(axis=1), part.weights**2, 0.0)
    off = weights[:, None] * np.nan_to_num(part.measured - predicted)
    total = np.maximum(np.add.reduceat(weights, part.starts), 1e-300)
    zeros: Array = np.add.reduceat(off, part.starts, axis=0) * (zero_shares(part) / total)[:, None]
    return zeros[part.trajectory]


def _with_own_offsets(part: WhitenedCases, model: JointModel, numerical: Array) -> Array:
    """What a model says of trajectories (N, 6), their offsets (t,) fitted to them."""
    material, settings, errors = model.material, model.settings, numerical @ model.errors
    offsets = model.offsets
    for _ in range(ROUNDS):
        played = part.cases.played(material, settings, offsets)
        own = own_field(part, material, settings, offsets, played)
        squares = 1.0 + np.add.reduceat(np.einsum("nk,nk->n", own, own), part.starts)
        steps = offset_steps(own, part.residual(played.wrench + errors), part.starts, squares, offsets / PRIOR)
        offsets = np.clip(offsets + PRIOR * steps, -FARTHEST, FARTHEST)
    return part.cases.play(material, settings, offsets) + errors

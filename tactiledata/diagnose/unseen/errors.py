"""Errors of force and torque on trajectories, indenters and sensors that had no part in a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.naming.held_out import HeldOutRefits, folds_of
from tactiledata.diagnose.naming.joint_fit import JointFit
from tactiledata.diagnose.naming.linearise import offset_steps
from tactiledata.diagnose.naming.parameters import JointModel
from tactiledata.diagnose.naming.signatures import own_field
from tactiledata.diagnose.residuals.gap import Gap, gap_closed
from tactiledata.diagnose.touches.whitened import WhitenedTouches
from tactiledata.diagnose.unseen.touch_residuals import known_rows
from tactiledata.errors import UsageError
from tactiledata.nuisance.offsets import FARTHEST, PRIOR
from tactiledata.nuisance.tare import tare_variance

ROUNDS = 2
"""Gauss-Newton steps of a trajectory's own contact offset."""


def held_out_wrenches(white: WhitenedTouches, fit: JointFit, groups: NDArray[np.int64]) -> Array:
    """Return wrenches (N, 6), N and N m, of each group predicted by a fit to the others; NaN where not simulated.

    E, nu, mu, the effects' numbers and the errors of the simulation are refitted to the other groups by one step, as in
    `tactiledata.diagnose.naming.held_out`. The wrench is then played anew. An indenter that was not fitted has no
    factor of its own. The contact offset and the sensor's zero are fitted to the trajectory itself, under their priors:
    no other trajectory knows them.

    Parameters
    ----------
    white : WhitenedTouches
    fit : JointFit
        The fit to all trajectories.
    groups : (t,)
        Number of each trajectory's group; at least two groups.
    """
    refits, model = HeldOutRefits.of(white, fit), fit.model
    numerical = white.simulation_error_wrenches(model.material, model.offsets, model.settings)
    predicted = np.full((len(white.trajectory), 6), np.nan)
    for group in np.unique(groups):
        out = groups == group
        rows = out[white.trajectory]
        refitted = refits.without(out)[0]
        moved = refitted.at(refitted.vector, refitted.offsets[out])
        part = white.part(out)
        predicted[rows] = _with_own_offsets(part, moved, numerical[rows])
        predicted[rows] += _own_zeros(part, predicted[rows])
    return predicted


def zero_shares(white: WhitenedTouches) -> Array:
    """Return the share (t,) of each trajectory's mean residual that its zero takes, by the prior from free air."""
    touches = white.touch_set.touches
    readings = np.array([case.noise.reading_variance for case in touches])
    tare = tare_variance(np.array([case.free_samples for case in touches]), readings)
    known = np.add.reduceat((white.weights / white.noise_factors) ** 2, white.starts) * tare
    return known / (1.0 + known)


def _own_zeros(part: WhitenedTouches, predicted: Array) -> Array:
    """Return the most likely zero of each row's trajectory (N, 6), N and N m, given the predicted wrenches (N, 6)."""
    weights = np.where(np.isfinite(predicted).all(axis=1), (part.weights / part.noise_factors) ** 2, 0.0)
    off = weights[:, None] * np.nan_to_num(part.measured - predicted)
    total = np.maximum(np.add.reduceat(weights, part.starts), 1e-300)
    zeros: Array = np.add.reduceat(off, part.starts, axis=0) * (zero_shares(part) / total)[:, None]
    return zeros[part.trajectory]


def _with_own_offsets(part: WhitenedTouches, model: JointModel, numerical: Array) -> Array:
    """Return the wrenches (N, 6), N and N m, that a model predicts with contact offsets fitted to the trajectories.

    Offsets stay as they are where gel and springs find no balance with the next ones.
    """
    material, settings, errors = model.material, model.settings, numerical @ model.errors
    offsets = model.offsets
    played = part.touch_set.played(material, settings, offsets)
    for _ in range(ROUNDS):
        own = own_field(part, material, settings, offsets, played, np.zeros(0))
        squares = 1.0 + np.add.reduceat(np.einsum("nk,nk->n", own, own), part.starts)
        steps = offset_steps(own, part.residual(played.wrench + errors), part.starts, squares, offsets / PRIOR)
        tried = np.clip(offsets + PRIOR * steps, -FARTHEST, FARTHEST)
        try:
            played = part.touch_set.played(material, settings, tried)
        except UsageError:
            break
        offsets = tried
    return played.wrench + errors


FORCE, TORQUE = slice(0, 3), slice(3, 6)
"""Columns of a wrench."""
NOISE_DRAWS = 8
"""Draws of noise over which the floor of the paper's loss is averaged."""
NOISE_DOUBT = 0.02
"""Share of the floor by which an error must exceed it for a gap to be worth a number."""


@dataclass(frozen=True)
class HeldOutErrors:
    """Errors on held-out data of the plain simulation ("before") and of the simulation with effects ("after").

    Parameters
    ----------
    unseen : str
        What was held out: "trajectories", "indenters" or "sensors".
    groups : int
        Number of what was held out; trajectories in five folds, the others one at a time.
    force : Gap
        Root mean square of the three components of force, N.
    torque : Gap
        Root mean square of the three components of torque about the gel's origin, N mm.
    paper : (before, after, floor)
        The SPLIT paper's loss, N: the mean over trajectories of the mean of | |F measured| - |F simulated| |.
    before, after : (N, 6) N, N m
        Predicted wrenches; NaN where not simulated.
    by_trajectory : (t,)
        Root mean square of the force components of each trajectory before, N.
    """

    unseen: str
    groups: int
    force: Gap
    torque: Gap
    paper: tuple[float, float, float]
    before: Array
    after: Array
    by_trajectory: Array

    @property
    def has_gap(self) -> bool:
        """Whether the force error before exceeds the noise floor by more than the floor is uncertain."""
        return self.force.before > (1.0 + NOISE_DOUBT) * self.force.floor

    @property
    def has_torque_gap(self) -> bool:
        """Whether the torque error before exceeds the noise floor by more than the floor is uncertain."""
        return self.torque.before > (1.0 + NOISE_DOUBT) * self.torque.floor

    @property
    def change(self) -> float:
        """Change of the force error as a share of the error before; negative where it falls."""
        return self.force.after / self.force.before - 1.0


def held_out_errors(white: WhitenedTouches, fits: Sequence[JointFit], seed: int) -> list[HeldOutErrors]:
    """Return the errors on held-out trajectories, and on held-out indenters and sensors where there are several.

    Parameters
    ----------
    white : WhitenedTouches
    fits : sequence of two JointFit
        The plain fit, and the fit with effects.
    seed : int
        Draws the folds of trajectories, the bootstraps of intervals and the noise of the floor.
    """
    sensors = np.unique([case.touch.sensor for case in white.touch_set.touches], return_inverse=True)[1]
    schemes = {
        "trajectories": folds_of(len(white.starts), seed),
        "indenters": white.indenter,
        "sensors": sensors.astype(np.int64),
    }
    listed = []
    for unseen, groups in schemes.items():
        if len(np.unique(groups)) < 2:
            continue
        before, after = (held_out_wrenches(white, fit, groups) for fit in fits)
        count = len(groups) if unseen == "trajectories" else len(np.unique(groups))
        listed.append(_errors(white, unseen, count, before, after, seed))
    return listed


def _errors(white: WhitenedTouches, unseen: str, count: int, before: Array, after: Array, seed: int) -> HeldOutErrors:
    """Return the errors of predicted wrenches before and after (N, 6), N and N m, on rows that both simulate."""
    rows = known_rows(white, before) & known_rows(white, after)
    frames = np.add.reduceat(rows.astype(np.float64), white.starts)
    floors = _noise(white, frames)

    # force and torque: sums of squares by trajectory, and the gap that is closed
    def squares(predicted: Array, part: slice) -> Array:
        off = np.where(rows[:, None], white.measured - predicted, 0.0)[:, part]
        return np.add.reduceat((off**2).sum(axis=1), white.starts)

    def gap(part: slice, unit: float) -> Gap:
        floor = float(np.sqrt((floors[rows][:, part] ** 2).mean()))
        first, second = (unit**2 * squares(predicted, part) for predicted in (before, after))
        return gap_closed(first, second, 3.0 * frames, unit * floor, seed)

    # the paper's loss: norms of force
    norm = np.linalg.norm(white.measured[:, FORCE], axis=1)

    def paper(measured: Array, predicted: Array) -> float:
        apart = np.where(rows, np.abs(measured - np.linalg.norm(predicted[:, FORCE], axis=1)), 0.0)
        means = np.add.reduceat(apart, white.starts) / np.maximum(frames, 1.0)
        return float(means[frames > 0].mean())

    chance = np.random.default_rng(seed)
    # noise floor of the paper's loss: a contact offset fits noise along the force, so the norm keeps less noise
    radial = _noise(white, frames, offsets=1.0)[:, FORCE]
    noisy = [after[:, FORCE] + radial * chance.normal(size=(len(after), 3)) for _ in range(NOISE_DRAWS)]
    floor = float(np.mean([paper(np.linalg.norm(force, axis=1), after) for force in noisy]))
    by_trajectory = np.sqrt(squares(before, FORCE) / np.maximum(3.0 * frames, 1.0))
    losses = paper(norm, before), paper(norm, after), floor
    return HeldOutErrors(unseen, count, gap(FORCE, 1.0), gap(TORQUE, 1e3), losses, before, after, by_trajectory)


def _noise(white: WhitenedTouches, frames: Array, offsets: float = 1.0 / 3.0) -> Array:
    """Return the standard deviation (N, 6), N and N m, of noise that each trajectory's own fitted numbers leave.

    Parameters
    ----------
    frames : (t,)
        Number of known frames of each trajectory.
    offsets : float
        Degrees of freedom that the contact offset takes from a component of force: one is shared by three components.
    """
    cases = white.touch_set.touches
    inflation = np.array([case.noise.inflation for case in cases])
    taken = (inflation * zero_shares(white))[:, None] + offsets * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    left = np.sqrt(np.maximum(1.0 - taken / np.maximum(frames, 1.0)[:, None], 0.0))
    deviations = np.stack([case.noise.deviations for case in cases]) * left
    return deviations[white.trajectory] * white.noise_factors[:, None]

"""Errors that mesh and solver leave in simulated forces, and how a fit allows for them.

An error that all forces share is the same as a factor on Young's modulus.
"""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.nuisance.offsets import OffsetSeries, profile_offsets

ROUNDS = 4
"""Newton steps for the factors of indenters."""

FORCE_ERROR = {"finite-strain": 0.03, "linear": 0.12, "mujoco-flex": 0.5}
"""Standard deviation, as a share, of the error that all forces of a simulation have in common.

Against converged reference solutions finite strain is 2 to 4 % off on the low mesh, linear 10 to 20 % at 1 mm depth
(docs/calibration.md), and MuJoCo's tetrahedra are 25 % to several times too stiff (docs/gel.md)."""

SHAPE_ERROR = {"finite-strain": 0.03, "linear": 0.06, "mujoco-flex": 0.15}
"""Standard deviation, as a share, of the error of one indenter's forces relative to the other indenters.

Two solvers with different discretisation and contact differ by this much from shape to shape (docs/calibration.md)."""

LAW_ERROR = {"finite-strain": 0.08, "linear": 0.1, "mujoco-flex": 0.2}
"""Standard deviation, as a share, of the error that the simulated force gains while the force grows by a factor e.

Two discretisations of one contact agree on a force better than on how it grows. Between finite strain and the rig's
layer solver the ratio drifts by 0 to 5 %, by indenter (benchmarks/solver_difference.py); 6 % was too little for
recorded worlds (docs/results.md). Linear has a larger error (docs/gel.md); that of flex is an estimate."""

SCATTER = 0.01
"""Standard deviation, as a share of the force, of the error that varies from frame to frame.

It comes from the solver's tolerance, from patches that enter and leave under a rim, and from the grid of responses."""


def frame_weights(forces: Array, noise: float, scatter: float = SCATTER) -> Array:
    """Weights (n,) of frames: noise of the measurement over that of measurement and simulation together.

    Parameters
    ----------
    forces : (n, 3) N
        Measured forces.
    noise : N
        Standard deviation of the noise of one component.
    scatter : float
        Standard deviation of the simulated force from frame to frame, as a share of the force.
    """
    return 1.0 / np.sqrt(1.0 + (scatter * np.linalg.norm(forces, axis=1) / noise) ** 2)


CENTRE_SCATTER = 5e-5
"""Standard deviation, m, of the error of the simulated centre of pressure from frame to frame; an estimate."""


def scatter_covariance(deviations: Array, centre: Array, places: Array) -> Array:
    """Covariance (n, 6, 6), N and N m, of the errors of simulated wrenches from frame to frame.

    Torques are about the origin of ``places``. A sensor on a long lever measures a lateral force far better by its
    torque than by the force itself, so the simulation's error must be compared with both.

    Parameters
    ----------
    deviations : (n, 3) N
        Standard deviations of the force.
    centre : (n,) N m
        Standard deviation of the torque about the contact.
    places : (n, 3) m
        Places of the contact; NaN counts as the origin.
    """
    x, y, z = np.nan_to_num(places).T
    zeros = np.zeros_like(x)
    cross = np.array([[zeros, -z, y], [z, zeros, -x], [-y, x, zeros]]).transpose(2, 0, 1)
    lever = np.concatenate([np.broadcast_to(np.eye(3), cross.shape), cross], axis=1) * deviations[:, None, :]
    covariance: Array = lever @ lever.transpose(0, 2, 1)
    covariance[:, 3:, 3:] += (centre**2)[:, None, None] * np.eye(3)
    return covariance


def with_law_error(wrenches: Array, share: float) -> Array:
    """Return wrenches (n, 6), N and N m, scaled by a factor that grows with the logarithm of their force.

    The factor grows by ``share`` while the force grows e times. It is 1 at the mean log force, weighted by the squared
    force, which is where least squares pay most attention.

    Parameters
    ----------
    wrenches : (n, 6) N, N m
        Measured or simulated.
    share : float
        Error of the force law, as a share: see ``LAW_ERROR``.
    """
    forces = np.linalg.norm(wrenches[:, :3], axis=1)
    if not (forces > 0).any():
        return wrenches
    logs = np.log(np.maximum(forces, 1e-3 * forces.max()))
    scaled: Array = wrenches * np.exp(share * (logs - np.average(logs, weights=forces**2)))[:, None]
    return scaled


def profile_shapes(
    measured: Array, series: OffsetSeries, starts: Indices, shapes: Indices, prior: float, share: float
) -> tuple[Array, Array]:
    """Fit contact offsets (t,), m, and a force factor (s,) of each indenter to whitened wrenches and their priors.

    Each round takes a Newton step for the factors, in which offsets follow to first order, and then refits the offsets.

    Parameters
    ----------
    measured : (n, k)
        Whitened measured wrenches.
    series : OffsetSeries
        Whitened simulated wrenches of the same n rows, over the offset.
    starts : (t,)
        First row of each trajectory, ascending.
    shapes : (t,)
        Indenter of each trajectory, 0 to s - 1.
    prior : m
        Standard deviation of the offsets about 0: see ``profile_offsets``.
    share : float
        Standard deviation of the factors about 1; 0 leaves them at 1.
    """
    factors = np.ones(int(shapes.max()) + 1)
    offsets = profile_offsets(measured, series, starts, prior)
    if share <= 0:
        return offsets, factors
    counts = np.diff(starts, append=len(measured))

    def dot(a: Array, b: Array) -> Array:
        """Inner products (t,) of the rows of each trajectory."""
        return np.add.reduceat(np.einsum("nk,nk->n", a, b), starts)

    for _ in range(ROUNDS):
        row_offsets = np.repeat(offsets, counts)
        scale = np.repeat(factors[shapes], counts)[:, None]
        simulated = series.at(row_offsets)
        slope = scale * (series.slope + 2.0 * row_offsets[:, None] * series.curvature)
        residual = measured - scale * simulated
        offset_curvature = dot(slope, slope) + prior**-2 if prior > 0 else np.full(len(starts), np.inf)
        # negative gradient and curvature of half the cost over the factors, with the offsets eliminated
        descent = np.bincount(shapes, dot(simulated, residual), len(factors)) - (factors - 1.0) / share**2
        curvature = (
            np.bincount(shapes, dot(simulated, simulated) - dot(simulated, slope) ** 2 / offset_curvature, len(factors))
            + share**-2
        )
        factors = np.clip(factors + descent / curvature, 1.0 - 5.0 * share, 1.0 + 5.0 * share)
        offsets = profile_offsets(measured, series.times(np.repeat(factors[shapes], counts)), starts, prior)
    return offsets, factors

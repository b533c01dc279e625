"""What mesh and solver leave of error in forces; a common factor on all forces is a factor on Young's modulus."""

from __future__ import annotations

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.nuisance.offsets import OffsetSeries, profile_offsets

ROUNDS = 4

FORCE_ERROR = {"finite-strain": 0.03, "linear": 0.12, "mujoco-flex": 0.5}
"""Standard deviation, as a share: against converged reference solutions finite strain is 2 to 4 % off on the low mesh,
linear 10 to 20 % at 1 mm depth (docs/calibration.md), and MuJoCo's tetrahedra are 25 % to several times too stiff
(docs/gel.md)."""

SHAPE_ERROR = {"finite-strain": 0.03, "linear": 0.06, "mujoco-flex": 0.15}
"""Standard deviation, as a share: by how much the forces of one indenter are off beside those of the others. Two
solvers of other discretisation and other contact differ so from shape to shape (docs/calibration.md)."""

LAW_ERROR = {"finite-strain": 0.08, "linear": 0.1, "mujoco-flex": 0.2}
"""Standard deviation, as a share: by how much the simulation's force is off over a factor e of the force. Two
discretisations of one contact agree on a force better than on how it grows: between finite strain and the rig's layer
solver it drifts by 0 to 5 %, by indenter (benchmarks/solver_difference.py), and 6 % was too little for recorded worlds
(docs/results.md); linear by what it lacks besides (docs/gel.md); of flex an estimate."""

SCATTER = 0.01
"""Standard deviation, as a share of the force: by how much frame by frame the solver's tolerance, patches that come and
go under a rim, and the grid of responses move a simulated force."""


def frame_weights(forces: Array, noise: float, scatter: float = SCATTER) -> Array:
    """Weights (n,) of frames whose simulated forces scatter beside the noise of the measured ones.

    Parameters
    ----------
    forces : (n, 3) N
    noise : N, standard deviation of one component
    scatter : share of the force
    """
    return 1.0 / np.sqrt(1.0 + (scatter * np.linalg.norm(forces, axis=1) / noise) ** 2)


CENTRE_SCATTER = 5e-5
"""m, standard deviation: by how much frame by frame the simulated centre of pressure is off; estimate."""
LOCKED_ERROR = 0.05
"""Standard deviation, as a share of the load that has been taken off: by how much the shear is off that friction holds
back then. It depends on the steps of the whole way, not on the force that is left: two solvers that agree within 1 %
under load are up to 5 % of the greatest load apart on the way out (benchmarks/solver_difference.py)."""


def scatter_covariance(deviations: Array, centre: Array, places: Array) -> Array:
    """Covariance (n, 6, 6), N and N m, of what simulated wrenches scatter, torques about the origin of the places.

    A sensor on a long lever knows a force across it far better by its torque than by itself: what the simulation
    scatters is to be held against that, too, not only against the noise of a force.

    Parameters
    ----------
    deviations : (n, 3) N
        Of the force.
    centre : (n,) N m
        Of the torque about the contact.
    places : (n, 3) m
        Of the contact.
    """
    x, y, z = np.nan_to_num(places).T
    nothing = np.zeros_like(x)
    cross = np.array([[nothing, -z, y], [z, nothing, -x], [-y, x, nothing]]).transpose(2, 0, 1)
    lever = np.concatenate([np.broadcast_to(np.eye(3), cross.shape), cross], axis=1) * deviations[:, None, :]
    covariance: Array = lever @ lever.transpose(0, 2, 1)
    covariance[:, 3:, 3:] += (centre**2)[:, None, None] * np.eye(3)
    return covariance


def with_law_error(wrenches: Array, share: float) -> Array:
    """Wrenches (n, 6), N and N m, each scaled by so much more the larger its force is.

    Where a share is added over a factor e of the force; 1 at the force that least squares heed most.

    Parameters
    ----------
    share : one standard deviation: see ``LAW_ERROR``
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
    """Contact offsets (t,), m, and a factor (s,) on the forces of each indenter, that make residual and priors least.

    Newton steps for the factors, in which the offsets follow them to first order, and the offsets anew after each.

    Parameters
    ----------
    measured : (n, k)
        Whitened, as the series.
    starts : (t,)
        First row of each trajectory, ascending.
    shapes : (t,)
        Indenter of each trajectory, 0 to s - 1.
    prior : m
        Of the offsets: see ``profile_offsets``.
    share : standard deviation of the factors about 1; 0 leaves them at 1
    """
    factors = np.ones(int(shapes.max()) + 1)
    offsets = profile_offsets(measured, series, starts, prior)
    if share <= 0:
        return offsets, factors
    counts = np.diff(starts, append=len(measured))

    def dot(a: Array, b: Array) -> Array:
        return np.add.reduceat(np.einsum("nk,nk->n", a, b), starts)

    for _ in range(ROUNDS):
        place = np.repeat(offsets, counts)
        scale = np.repeat(factors[shapes], counts)[:, None]
        unit = series.at(place)
        lean = scale * (series.slope + 2.0 * place[:, None] * series.curvature)
        residual = measured - scale * unit
        held = dot(lean, lean) + prior**-2 if prior > 0 else np.full(len(starts), np.inf)
        force = np.bincount(shapes, dot(unit, residual), len(factors)) - (factors - 1.0) / share**2
        bend = np.bincount(shapes, dot(unit, unit) - dot(unit, lean) ** 2 / held, len(factors)) + share**-2
        factors = np.clip(factors + force / bend, 1.0 - 5.0 * share, 1.0 + 5.0 * share)
        offsets = profile_offsets(measured, series.times(np.repeat(factors[shapes], counts)), starts, prior)
    return offsets, factors

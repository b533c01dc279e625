"""Trajectories in units of their noise, zeros of the force sensor marginalised; errors of the simulation as fields.

Whitened means: multiplied by the inverse square root of the covariance of noise, unknown zeros and frame-by-frame
scatter of the simulation, so that noise alone has variance 1 in every component and frame.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array, Indices, Mask
from tactiledata.diagnose.residuals.history import largest_so_far
from tactiledata.diagnose.touches.touch_case import TouchSet
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.numerical import (
    CENTRE_SCATTER,
    LAW_ERROR,
    LOCKED_ERROR,
    SCATTER,
    SHAPE_ERROR,
    scatter_covariance,
)
from tactiledata.nuisance.tare import tare_variance, zero_power

LAW_PRIOR = 0.06
"""Standard deviation of the force law's error, a share over a factor e of the force, where it is fitted beside effects.

It is less than ``LAW_ERROR`` because E, nu and the indenters' factors absorb most of that. The thresholds of a claim
were measured with this value (docs/naming.md)."""
SHEAR_ERROR = 0.04
"""Standard deviation of the error of sticking shear, as a share of the shear; an estimate."""


@dataclass(frozen=True)
class NumericalErrors:
    """Standard deviations of the errors that mesh, contact and solver of the simulation leave.

    Parameters
    ----------
    shape : float
        Of a factor on all forces of one indenter, about 1.
    law : float
        Of the growth of force: a share over a factor e of the force.
    shear : float
        Of a factor on shear that sticks, about 1.
    scatter : float
        Of each frame by itself, as a share of its force.
    centre : float
        Of the centre of pressure of each frame, in metres.
    locked : float
        Of shear that friction still holds, as a share of the normal load that has been taken off.
    """

    shape: float = SHAPE_ERROR["finite-strain"]
    law: float = LAW_PRIOR
    shear: float = SHEAR_ERROR
    scatter: float = SCATTER
    centre: float = CENTRE_SCATTER
    locked: float = LOCKED_ERROR

    @staticmethod
    def of(mechanics: str) -> NumericalErrors:
        """Return the errors of a kind of mechanics: a key of ``SHAPE_ERROR``, as "finite-strain" or "linear"."""
        law = LAW_PRIOR * (LAW_ERROR[mechanics] / LAW_ERROR["finite-strain"])
        return NumericalErrors(shape=SHAPE_ERROR[mechanics], law=law)


@dataclass(frozen=True)
class WhitenedTouches:
    """Trajectories ready for least squares: N rows, the frames of t trajectories one after the other.

    Parameters
    ----------
    touch_set : TouchSet
        Trajectories and simulation.
    errors : NumericalErrors
        Standard deviations of the simulation's own errors.
    trust : (N,)
        Factors on the whitened rows, of a robust fit; 1 in an ordinary one.
    """

    touch_set: TouchSet
    errors: NumericalErrors
    trust: Array

    @staticmethod
    def of(touch_set: TouchSet, errors: NumericalErrors | None = None) -> WhitenedTouches:
        """Return the whitened trajectories of a set, every frame with trust 1."""
        return WhitenedTouches(touch_set, errors or NumericalErrors(), np.ones(int(touch_set.counts.sum())))

    def with_trust(self, trust: Array) -> WhitenedTouches:
        """Return the same trajectories with factors (N,) on their whitened rows."""
        return replace(self, trust=trust)

    @cached_property
    def starts(self) -> Indices:
        """First row (t,) of each trajectory."""
        return np.concatenate([[0], np.cumsum(self.touch_set.counts)[:-1]]).astype(np.int64)

    @cached_property
    def trajectory(self) -> Indices:
        """Number of each row's trajectory (N,)."""
        return np.repeat(np.arange(len(self.starts)), self.touch_set.counts)

    @cached_property
    def indenter(self) -> Indices:
        """Number of each trajectory's indenter (t,)."""
        return np.unique(self.touch_set.indenters, return_inverse=True)[1].astype(np.int64)

    @cached_property
    def measured(self) -> Array:
        """Measured wrenches (N, 6), N and N m, gel frame; 0 where unknown."""
        return np.nan_to_num(np.concatenate([case.measured for case in self.touch_set.touches]))

    @cached_property
    def free_air(self) -> Mask:
        """Rows (N,) in which nothing touches the gel."""
        return np.concatenate([case.free_air for case in self.touch_set.touches])

    @cached_property
    def _scattered(self) -> tuple[Array, Array]:
        """Whitening matrices (N, 6, 6) and zero gains (N, 6, 6) of the rows.

        A wrench is multiplied by the first from the right, without regard to zeros. The second, symmetric, is what a
        zero of the size of a frame's noise becomes in a whitened row. Both are 0 where the wrench is unknown, and small
        where the simulation scatters much.
        """
        known = np.isfinite(np.concatenate([case.measured for case in self.touch_set.touches])).all(axis=1)
        trust = (self.trust * known)[:, None, None]
        of_noise = np.stack([case.noise.whitened(np.eye(6)) for case in self.touch_set.touches])[self.trajectory]
        scatter = self._scatter
        # in units of the noise the covariance is I + scatter: its inverse root, by eigenvalues
        values, axes = np.linalg.eigh(of_noise.transpose(0, 2, 1) @ scatter @ of_noise)
        shrunk = (axes / np.sqrt(1.0 + np.maximum(values, 0.0))[:, None, :]) @ axes.transpose(0, 2, 1)
        return trust * (of_noise @ shrunk), trust * shrunk

    @property
    def _scatter(self) -> Array:
        """Covariance (N, 6, 6), in squares and products of N and N m, of the simulation's frame-by-frame scatter."""
        errors, size = self.errors, np.linalg.norm(self.measured[:, :3], axis=1)
        load = np.where(self.free_air, 0.0, self.measured[:, 2])
        taken_off = np.where(self.free_air, 0.0, largest_so_far(load, self.starts) - load)
        along = errors.scatter * size
        across = np.hypot(along, errors.locked * taken_off)
        places = np.concatenate([case.touch.tips for case in self.touch_set.touches])
        return scatter_covariance(np.column_stack([across, across, along]), errors.centre * size, places)

    @property
    def zero_gains(self) -> Array:
        """Whitened change (N, 6, 6) over a zero of the size of a frame's noise, in each of six directions."""
        return self._scattered[1]

    @cached_property
    def weights(self) -> Array:
        """Weight (N,) of each row over all components: 1 where noise is all there is, 0 where the wrench is unknown.

        It is below 1 where the simulation scatters beside the noise.
        """
        square = np.einsum("nij,nij->n", self.zero_gains, self.zero_gains)
        weights: Array = np.sqrt(square / 6.0)
        return weights

    @cached_property
    def expected(self) -> Array:
        """Sum of whitened squares (t,) of each trajectory where noise is all there is.

        Neighbouring frames share some noise. The covariance is inflated for that, and the sum is smaller accordingly.
        """
        inflation = np.array([case.noise.inflation for case in self.touch_set.touches])
        squares: Array = 6.0 * np.add.reduceat(self.weights > 0, self.starts, dtype=np.float64) / inflation
        return squares

    @cached_property
    def tare(self) -> Array:
        """Variance (t,) of each trajectory's zero, over the variance of a wrench at a frame."""
        touches = self.touch_set.touches
        readings = np.array([case.noise.reading_variance for case in touches])
        return tare_variance(np.array([case.free_samples for case in touches]), readings)

    def whiten(self, rows: Array) -> Array:
        """Return wrenches (N, 6) or (N, 6, c), in N and N m, whitened, zeros marginalised; entries not finite are 0."""
        field = np.nan_to_num(rows.reshape(len(rows), 6, -1))
        white = self._scattered[0].transpose(0, 2, 1) @ field
        return zero_power(white, self.zero_gains, self.starts, self.tare, -0.5).reshape(rows.shape)

    def part(self, chosen: Mask) -> WhitenedTouches:
        """Return the chosen ones (t,) of the trajectories."""
        kept = [case for case, is_kept in zip(self.touch_set.touches, chosen, strict=True) if is_kept]
        return replace(self, touch_set=replace(self.touch_set, touches=kept), trust=self.trust[chosen[self.trajectory]])

    def with_zeros(self, white: Array) -> Array:
        """Return whitened rows (N, 6) or (N, 6, c) with the marginalisation of zeros undone: each frame by itself."""
        rows = white.reshape(len(white), 6, -1)
        return zero_power(rows, self.zero_gains, self.starts, self.tare, 0.5).reshape(white.shape)

    def in_newtons(self, rows: Array) -> Array:
        """Return rows (N, 6) of `with_zeros` as wrenches in N and N m; 0 where the wrench is unknown."""
        known = self.weights > 0
        raw = np.zeros_like(rows)
        raw[known] = np.einsum("nj,nji->ni", rows[known], np.linalg.inv(self._scattered[0][known]))
        return raw

    def residual(self, predicted: Array) -> Array:
        """Return measured less predicted wrenches (N, 6), whitened; components not simulated count as fitted."""
        return self.whiten(self.measured - np.where(np.isfinite(predicted), predicted, self.measured))

    def simulation_error_fields(self, material: GelMaterial, offsets: Array | None = None) -> Array:
        """Return the simulation's own errors as whitened wrenches (N, 6, i + 2), one standard deviation each.

        First a factor on all forces of each of i indenters, then the growth of force, then sticking shear.

        Parameters
        ----------
        material : GelMaterial
            Material of the plain simulation whose forces are off.
        offsets : (t,) m, optional
            Contact offset of each trajectory, where it is known.
        """
        return self.whiten(self.simulation_error_wrenches(material, offsets))

    def simulation_error_wrenches(self, material: GelMaterial, offsets: Array | None = None) -> Array:
        """Return the simulation's own errors as wrenches (N, 6, i + 2) in N and N m; see `simulation_error_fields`."""
        plain = np.nan_to_num(self.touch_set.play(material, [], offsets))
        # a factor on all forces of each indenter
        owner = self.indenter[self.trajectory]
        count = int(self.indenter.max()) + 1
        shapes = plain[:, :, None] * (owner[:, None] == np.arange(count))[:, None, :] * self.errors.shape
        # the growth of force: nothing at the geometric mean of the forces
        size = np.linalg.norm(plain[:, :3], axis=1)
        typical = np.exp(np.mean(np.log(size[size > 0]))) if (size > 0).any() else 1.0
        growth = np.log(np.maximum(size, 1e-3 * typical) / typical)
        law = plain * growth[:, None] * self.errors.law
        # shear that sticks, and its torque about the normal
        across = np.hypot(plain[:, 0], plain[:, 1])
        slips = across >= 0.98 * material.friction * np.abs(plain[:, 2])
        shear = plain * np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0]) * (~slips)[:, None] * self.errors.shear
        return np.concatenate([shapes, law[:, :, None], shear[:, :, None]], axis=2)

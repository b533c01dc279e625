"""Trajectories in units of their noise, their unknown zeros taken out, with what every explanation must allow for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
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
"""Standard deviation of the force law's factor where it is fitted beside effects: somewhat less than ``LAW_ERROR``,
since most of that E, nu and the indenters' factors take up; claims were set with it (docs/naming.md)."""
SHEAR_ERROR = 0.04
"""Standard deviation, as a share: by how much sticking shear is off beside the normal force; estimate."""


@dataclass(frozen=True)
class NumericalErrors:
    """What mesh, contact and solver leave, as normal priors on factors about 1.

    Parameters
    ----------
    shape : of all forces of one indenter
    law : of forces over e times smaller ones
    shear : of shear that sticks
    scatter : of each frame by itself, a share of its force
    centre : m, of each frame's centre of pressure
    locked : of shear that friction holds, a share of the load that has been taken off
    """

    shape: float = SHAPE_ERROR["finite-strain"]
    law: float = LAW_PRIOR
    shear: float = SHEAR_ERROR
    scatter: float = SCATTER
    centre: float = CENTRE_SCATTER
    locked: float = LOCKED_ERROR

    @staticmethod
    def of(mechanics: str) -> NumericalErrors:
        """Of a simulation whose errors are known beside those of finite strain: a key of ``SHAPE_ERROR``."""
        law = LAW_PRIOR * (LAW_ERROR[mechanics] / LAW_ERROR["finite-strain"])
        return NumericalErrors(shape=SHAPE_ERROR[mechanics], law=law)


@dataclass(frozen=True)
class WhitenedTouches:
    """The same trajectories, ready for least squares: N rows of t trajectories.

    Parameters
    ----------
    touch_set : TouchSet
    errors : NumericalErrors
    trust : (N,)
        Factors on the weight of frames, of a robust fit.
    """

    touch_set: TouchSet
    errors: NumericalErrors
    trust: Array

    @staticmethod
    def of(cases: TouchSet, errors: NumericalErrors | None = None) -> WhitenedTouches:
        """All frames trusted alike."""
        return WhitenedTouches(cases, errors or NumericalErrors(), np.ones(int(cases.counts.sum())))

    def trusting(self, trust: Array) -> WhitenedTouches:
        """The same with factors (N,) on the weight of frames."""
        return replace(self, trust=trust)

    @cached_property
    def starts(self) -> Indices:
        """First row of each trajectory (t,)."""
        return np.concatenate([[0], np.cumsum(self.touch_set.counts)[:-1]]).astype(np.int64)

    @cached_property
    def trajectory(self) -> Indices:
        """Trajectory of each row (N,)."""
        return np.repeat(np.arange(len(self.starts)), self.touch_set.counts)

    @cached_property
    def indenter(self) -> Indices:
        """Number of each trajectory's indenter (t,)."""
        return np.unique(self.touch_set.indenters, return_inverse=True)[1].astype(np.int64)

    @cached_property
    def measured(self) -> Array:
        """Wrenches (N, 6), 0 where unknown."""
        return np.nan_to_num(np.concatenate([case.measured for case in self.touch_set.touches]))

    @cached_property
    def free_air(self) -> NDArray[np.bool_]:
        """Rows (N,) in which nothing touches."""
        return np.concatenate([case.free_air for case in self.touch_set.touches])

    @cached_property
    def _scattered(self) -> tuple[Array, Array]:
        """Of rows: what a wrench is multiplied by from the right (N, 6, 6), and what a zero of the noise's size becomes
        of it (N, 6, 6), symmetric; both 0 where nothing is known, and small where the simulation scatters much.
        """
        known = np.isfinite(np.concatenate([case.measured for case in self.touch_set.touches])).all(axis=1)
        trust = (self.trust * known)[:, None, None]
        of_noise = np.stack([case.noise.whitened(np.eye(6)) for case in self.touch_set.touches])[self.trajectory]
        scatter = self._scatter
        values, axes = np.linalg.eigh(of_noise.transpose(0, 2, 1) @ scatter @ of_noise)
        shrunk = (axes / np.sqrt(1.0 + np.maximum(values, 0.0))[:, None, :]) @ axes.transpose(0, 2, 1)
        return trust * (of_noise @ shrunk), trust * shrunk

    @property
    def _scatter(self) -> Array:
        """Covariance (N, 6, 6), N and N m, of what the simulation scatters from frame to frame."""
        errors, size = self.errors, np.linalg.norm(self.measured[:, :3], axis=1)
        load = np.where(self.free_air, 0.0, self.measured[:, 2])
        taken_off = np.where(self.free_air, 0.0, largest_so_far(load, self.starts) - load)
        along = errors.scatter * size
        across = np.hypot(along, errors.locked * taken_off)
        places = np.concatenate([case.touch.tips for case in self.touch_set.touches])
        return scatter_covariance(np.column_stack([across, across, along]), errors.centre * size, places)

    @property
    def zero_gains(self) -> Array:
        """Whitened change (N, 6, 6) over zeros of the size of a frame's noise."""
        return self._scattered[1]

    @cached_property
    def weights(self) -> Array:
        """Of rows (N,), over all components: 0 where nothing is known, less where the simulation scatters beside the
        noise; 1 where noise is all there is.
        """
        square = np.einsum("nij,nij->n", self.zero_gains, self.zero_gains)
        weights: Array = np.sqrt(square / 6.0)
        return weights

    @cached_property
    def expected(self) -> Array:
        """The sum of whitened squares of each trajectory (t,) where noise is all there is.

        Noise that neighbours share has fewer independent numbers than readings, and its covariance is inflated so.
        """
        inflation = np.array([case.noise.inflation for case in self.touch_set.touches])
        squares: Array = 6.0 * np.add.reduceat(self.weights > 0, self.starts, dtype=np.float64) / inflation
        return squares

    @cached_property
    def tare(self) -> Array:
        """Variances (t,) of the zeros, over that of a wrench at a frame."""
        cases = self.touch_set.touches
        readings = np.array([case.noise.reading_variance for case in cases])
        return tare_variance(np.array([case.free_samples for case in cases]), readings)

    def whiten(self, rows: Array) -> Array:
        """Wrenches (N, 6) or (N, 6, c) in units of their noise; rows that are not finite count for nothing."""
        field = np.nan_to_num(rows.reshape(len(rows), 6, -1))
        white = self._scattered[0].transpose(0, 2, 1) @ field
        return zero_power(white, self.zero_gains, self.starts, self.tare, -0.5).reshape(rows.shape)

    def part(self, chosen: NDArray[np.bool_]) -> WhitenedTouches:
        """Some of the trajectories (t,)."""
        kept = [case for case, is_kept in zip(self.touch_set.touches, chosen, strict=True) if is_kept]
        return replace(self, touch_set=replace(self.touch_set, touches=kept), trust=self.trust[chosen[self.trajectory]])

    def with_zeros(self, white: Array) -> Array:
        """Whitened rows (N, 6) or (N, 6, c) with the trajectories' zeros in them again: each frame by itself."""
        rows = white.reshape(len(white), 6, -1)
        return zero_power(rows, self.zero_gains, self.starts, self.tare, 0.5).reshape(white.shape)

    def in_newtons(self, rows: Array) -> Array:
        """Rows (N, 6) of `with_zeros` as wrenches, N and N m; 0 where nothing is known."""
        known = self.weights > 0
        raw = np.zeros_like(rows)
        raw[known] = np.einsum("nj,nji->ni", rows[known], np.linalg.inv(self._scattered[0][known]))
        return raw

    def residual(self, predicted: Array) -> Array:
        """Measured less predicted (N, 6), whitened."""
        return self.whiten(self.measured - np.where(np.isfinite(predicted), predicted, self.measured))

    def simulation_error_fields(self, material: GelMaterial, offsets: Array | None = None) -> Array:
        """Whitened wrenches (N, 6, i + 2), one standard deviation each: an error per indenter, of law, of shear.

        Parameters
        ----------
        offsets : (t,) m
            Of the trajectories, where they are known.
        """
        return self.whiten(self.simulation_error_wrenches(material, offsets))

    def simulation_error_wrenches(self, material: GelMaterial, offsets: Array | None = None) -> Array:
        """The same as they are, N and N m."""
        plain = np.nan_to_num(self.touch_set.play(material, [], offsets))
        owner = self.indenter[self.trajectory]
        count = int(self.indenter.max()) + 1
        shapes = plain[:, :, None] * (owner[:, None] == np.arange(count))[:, None, :] * self.errors.shape
        size = np.linalg.norm(plain[:, :3], axis=1)
        typical = np.exp(np.mean(np.log(size[size > 0]))) if (size > 0).any() else 1.0
        growth = np.log(np.maximum(size, 1e-3 * typical) / typical)
        law = plain * growth[:, None] * self.errors.law
        across = np.hypot(plain[:, 0], plain[:, 1])
        slips = across >= 0.98 * material.friction * np.abs(plain[:, 2])
        shear = plain * np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0]) * (~slips)[:, None] * self.errors.shear
        return np.concatenate([shapes, law[:, :, None], shear[:, :, None]], axis=2)

"""Distance of measured from simulated wrenches: the vector loss, and the norm loss of the SPLIT paper."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Protocol

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.calibrate.response import Response
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.nuisance.numerical import frame_weights, profile_shapes
from tactiledata.nuisance.offsets import PRIOR, OffsetSeries
from tactiledata.nuisance.tare import tare_variance, without_tare

LossName = Literal["vector", "norm"]


class Loss(Protocol):
    """A function of E, nu and mu that a fit minimises."""

    def value(self, parameters: Array) -> float:
        """Value of the loss at parameters (3,): E (Pa), nu, mu."""

    def offsets(self, parameters: Array) -> Array:
        """Contact offsets (t,), m, that fit best at parameters (3,): E (Pa), nu, mu."""


@dataclass(frozen=True)
class VectorLoss:
    """Squared difference of whitened forces and torques; each trajectory has a force zero and a contact offset.

    Parameters
    ----------
    response : Response
        Simulated wrenches of the n frames of t trajectories.
    measured : (n, 6) N, N m
        Contact wrenches of the same frames.
    noise : WrenchNoise
        Covariance of the measurement; it whitens the difference.
    free_samples : (t,)
        Number of samples in free air from which each trajectory's zero was taken.
    prior : m
        Standard deviation of the contact offsets; 0 leaves them out.
    shapes : (t,), optional
        Number of each trajectory's indenter; simulated forces of one indenter share a factor. All are one by default.
    shape_error : float
        Standard deviation of those factors about 1; 0 leaves them out.
    """

    response: Response
    measured: Array
    noise: WrenchNoise
    free_samples: Array
    prior: float = PRIOR
    shapes: Indices | None = None
    shape_error: float = 0.0

    def value(self, parameters: Array) -> float:
        """Root mean square of the whitened residual, offsets profiled; about 1 where only noise is left."""
        residual = self.residual(parameters)
        return float(np.sqrt((residual @ residual) / self.measured.size))

    def residual(self, parameters: Array) -> Array:
        """Whitened residuals of all frames (6 n,), then offsets (t,) and factors (s,) over their prior deviations.

        Offsets and factors are profiled: fitted anew at these parameters.
        """
        series = self._series(parameters)
        offsets, factors = self._profiled(series)
        simulated = series.at(np.repeat(offsets, self.response.counts)) * self._by_row(factors)
        factor_rows = (factors - 1.0) / self.shape_error if self.shape_error > 0 else factors[:0]
        return np.concatenate(
            [
                (self._white_measured - simulated).ravel(),
                offsets / self.prior if self.prior > 0 else offsets,
                factor_rows,
            ]
        )

    def offsets(self, parameters: Array) -> Array:
        """Contact offsets (t,), m, that fit best at these parameters."""
        return self._profiled(self._series(parameters))[0]

    def factors(self, parameters: Array) -> Array:
        """Measured over simulated force of each indenter (s,) that fits best at these parameters."""
        return self._profiled(self._series(parameters))[1]

    def with_measured(self, measured: Array) -> VectorLoss:
        """Return this loss with other measured wrenches (n, 6), N and N m."""
        return replace(self, measured=measured)

    def owner(self) -> Indices:
        """Number of the trajectory to which each entry of ``residual`` belongs."""
        count = len(self.response.starts)
        rows = np.repeat(np.arange(count), self.response.counts * 6)
        # a factor belongs to all trajectories of its indenter; it is counted with the first of them
        firsts = np.unique(self._shapes, return_index=True)[1] if self.shape_error > 0 else np.arange(0)
        return np.concatenate([rows, np.arange(count), firsts])

    @cached_property
    def _white_measured(self) -> Array:
        """Measured wrenches (n, 6), whitened."""
        return self._white(self.measured)

    def _profiled(self, series: OffsetSeries) -> tuple[Array, Array]:
        """Contact offsets (t,), m, and indenter factors (s,) that fit best to a whitened response."""
        return profile_shapes(
            self._white_measured, series, self.response.starts, self._shapes, self.prior, self.shape_error
        )

    @property
    def _shapes(self) -> Indices:
        """Number (t,) of each trajectory's indenter; 0 for all by default."""
        return np.zeros(len(self.response.starts), dtype=np.int64) if self.shapes is None else self.shapes

    def _by_row(self, factors: Array) -> Array:
        """Factor (n, 1) of each frame's indenter."""
        return np.repeat(factors[self._shapes], self.response.counts)[:, None]

    def _series(self, parameters: Array) -> OffsetSeries:
        """Whitened response over the contact offset at parameters (3,)."""
        modulus, ratio, friction = parameters
        series = self.response.at(ratio, friction)
        return OffsetSeries(*(self._white(modulus * part) for part in (series.level, series.slope, series.curvature)))

    def _white(self, wrench: Array) -> Array:
        """Wrenches (n, 6), whitened, weighted and with the unknown zero of each trajectory removed."""
        rows = self.noise.whitened(wrench) * self.weights[:, None]
        zeros = tare_variance(self.free_samples, self.noise.reading_variance)
        return without_tare(rows, self.response.starts, zeros, self.weights)

    @cached_property
    def weights(self) -> Array:
        """Weights (n,) of the frames: large forces are simulated with larger errors and count less."""
        return frame_weights(self.measured[:, :3], float(self.noise.deviations[:3].mean()))


@dataclass(frozen=True)
class NormLoss:
    """The SPLIT paper's loss: the mean over trajectories of the mean over frames of | |F_real| - |F_sim| |, N.

    It sees neither directions nor torques, and takes the recorded poses as they are.

    Parameters
    ----------
    response : Response
        Simulated wrenches of the n frames of t trajectories.
    measured : (n, 6) N, N m
        Contact wrenches of the same frames.
    shares : (t,), optional
        Weight of each trajectory in the mean; equal by default.
    """

    response: Response
    measured: Array
    shares: Array | None = None

    def value(self, parameters: Array) -> float:
        """Mean difference of the force norms at parameters (3,), N."""
        modulus, ratio, friction = parameters
        simulated = modulus * np.linalg.norm(self.response.level_at(ratio, friction)[:, :3], axis=1)
        difference = np.abs(np.linalg.norm(self.measured[:, :3], axis=1) - simulated)
        means = np.add.reduceat(difference, self.response.starts) / self.response.counts
        return float(np.average(means, weights=self.shares))

    def offsets(self, parameters: Array) -> Array:
        """Zeros (t,): this loss has no contact offsets."""
        return np.zeros(len(self.response.starts))

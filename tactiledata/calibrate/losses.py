"""How far measured and simulated wrenches are apart: the vector loss, and the SPLIT paper's norm loss."""

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
    """What is made small."""

    def value(self, parameters: Array) -> float:
        """At E (Pa), nu, mu."""

    def offsets(self, parameters: Array) -> Array:
        """Contact offsets (t,), m, at E, nu, mu."""


@dataclass(frozen=True)
class VectorLoss:
    """Whitened forces and torques, each trajectory with a zero and an offset of its own.

    Parameters
    ----------
    response : Response
    measured : (n, 6) N, N m
    noise : WrenchNoise
    free_samples : (t,)
        Samples in free air from which each trajectory's zero was taken.
    prior : m
        Standard deviation of the offsets; 0 leaves them out.
    shapes : (t,), optional
        Number of each trajectory's indenter: its forces have a factor in common.
    shape_error : float
        Standard deviation of those factors about 1.
    """

    response: Response
    measured: Array
    noise: WrenchNoise
    free_samples: Array
    prior: float = PRIOR
    shapes: Indices | None = None
    shape_error: float = 0.0

    def value(self, parameters: Array) -> float:
        """Root mean square of the whitened residual, offsets profiled; about 1 where the noise is all there is."""
        whole = self.residual(parameters)
        return float(np.sqrt((whole @ whole) / self.measured.size))

    def residual(self, parameters: Array) -> Array:
        """Whitened rows of all frames (6 n,), offsets over their prior (t,), factors over theirs (s,); profiled."""
        series = self._series(parameters)
        offsets, factors = self._profiled(series)
        simulated = series.at(np.repeat(offsets, self.response.counts)) * self._by_row(factors)
        off = (factors - 1.0) / self.shape_error if self.shape_error > 0 else factors[:0]
        return np.concatenate(
            [(self._white_measured - simulated).ravel(), offsets / self.prior if self.prior > 0 else offsets, off]
        )

    def offsets(self, parameters: Array) -> Array:
        """Contact offsets (t,), m."""
        return self._profiled(self._series(parameters))[0]

    def factors(self, parameters: Array) -> Array:
        """On the forces of each indenter (s,)."""
        return self._profiled(self._series(parameters))[1]

    def with_measured(self, measured: Array) -> VectorLoss:
        """The same with other measurements (n, 6)."""
        return replace(self, measured=measured)

    def owner(self) -> Indices:
        """The trajectory of each entry of ``residual``."""
        count = len(self.response.starts)
        rows = np.repeat(np.arange(count), self.response.counts * 6)
        # a factor belongs to all trajectories of its indenter; it is counted with the first of them
        firsts = np.unique(self._shapes, return_index=True)[1] if self.shape_error > 0 else np.arange(0)
        return np.concatenate([rows, np.arange(count), firsts])

    @cached_property
    def _white_measured(self) -> Array:
        return self._white(self.measured)

    def _profiled(self, series: OffsetSeries) -> tuple[Array, Array]:
        return profile_shapes(
            self._white_measured, series, self.response.starts, self._shapes, self.prior, self.shape_error
        )

    @property
    def _shapes(self) -> Indices:
        return np.zeros(len(self.response.starts), dtype=np.int64) if self.shapes is None else self.shapes

    def _by_row(self, factors: Array) -> Array:
        return np.repeat(factors[self._shapes], self.response.counts)[:, None]

    def _series(self, parameters: Array) -> OffsetSeries:
        modulus, ratio, friction = parameters
        raw = self.response.at(ratio, friction)
        return OffsetSeries(*(self._white(modulus * part) for part in (raw.level, raw.slope, raw.curvature)))

    def _white(self, wrench: Array) -> Array:
        rows = self.noise.whitened(wrench) * self.weights[:, None]
        zeros = tare_variance(self.free_samples, self.noise.reading_variance)
        return without_tare(rows, self.response.starts, zeros, self.weights)

    @cached_property
    def weights(self) -> Array:
        """Of the frames (n,): large forces are simulated with larger errors."""
        return frame_weights(self.measured[:, :3], float(self.noise.deviations[:3].mean()))


@dataclass(frozen=True)
class NormLoss:
    """The SPLIT paper's loss: the mean over trajectories of the mean over frames of | |F_real| - |F_sim| |, N.

    It sees neither directions nor torques, and takes the recorded poses as they are.

    Parameters
    ----------
    response : Response
    measured : (n, 6) N, N m
    shares : (t,), optional
        How often each trajectory counts; 1 by default.
    """

    response: Response
    measured: Array
    shares: Array | None = None

    def value(self, parameters: Array) -> float:
        """N."""
        modulus, ratio, friction = parameters
        simulated = modulus * np.linalg.norm(self.response.level_at(ratio, friction)[:, :3], axis=1)
        apart = np.abs(np.linalg.norm(self.measured[:, :3], axis=1) - simulated)
        means = np.add.reduceat(apart, self.response.starts) / self.response.counts
        return float(np.average(means, weights=self.shares))

    def offsets(self, parameters: Array) -> Array:
        """None are sought."""
        return np.zeros(len(self.response.starts))

"""How far measured and simulated wrenches are apart: the vector loss, and the SPLIT paper's norm loss."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from tactiledata.calibrate.response import Response
from tactiledata.nuisance.noise import WrenchNoise
from tactiledata.nuisance.numerical import frame_weights
from tactiledata.nuisance.offsets import PRIOR, OffsetSeries, profile_offsets
from tactiledata.nuisance.tare import tare_variance, without_tare

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
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
    """

    response: Response
    measured: Array
    noise: WrenchNoise
    free_samples: Array
    prior: float = PRIOR

    def value(self, parameters: Array) -> float:
        """Root mean square of the whitened residual, offsets profiled; about 1 where the noise is all there is."""
        whole = self.residual(parameters)
        return float(np.sqrt((whole @ whole) / self.measured.size))

    def residual(self, parameters: Array) -> Array:
        """Whitened rows of all frames (6 n,), then the offsets over their prior (t,); profiled."""
        series = self._series(parameters)
        offsets = self._profiled(series)
        rows = self._white_measured - series.at(np.repeat(offsets, self.response.counts))
        return np.concatenate([rows.ravel(), offsets / self.prior if self.prior > 0 else offsets])

    def offsets(self, parameters: Array) -> Array:
        """Contact offsets (t,), m."""
        return self._profiled(self._series(parameters))

    def with_measured(self, measured: Array) -> VectorLoss:
        """The same with other measurements (n, 6)."""
        return replace(self, measured=measured)

    def owner(self) -> Indices:
        """The trajectory of each entry of ``residual``."""
        count = len(self.response.starts)
        rows = np.repeat(np.arange(count), self.response.counts * 6)
        return np.concatenate([rows, np.arange(count)])

    @cached_property
    def _white_measured(self) -> Array:
        return self._white(self.measured)

    def _profiled(self, series: OffsetSeries) -> Array:
        return profile_offsets(self._white_measured, series, self.response.starts, self.prior)

    def _series(self, parameters: Array) -> OffsetSeries:
        modulus, ratio, friction = parameters
        raw = self.response.at(ratio, friction)
        return OffsetSeries(*(self._white(modulus * part) for part in (raw.level, raw.slope, raw.curvature)))

    def _white(self, wrench: Array) -> Array:
        rows = self.noise.whitened(wrench) * self.weights[:, None]
        return without_tare(rows, self.response.starts, tare_variance(self.free_samples), self.weights)

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

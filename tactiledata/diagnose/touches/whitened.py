"""Trajectories in units of their noise, each one's own errors marginalised, and whitened errors of the simulation.

Whitened means: multiplied by the inverse square root of the covariance of noise, of what is off in a trajectory alone
(`own_errors`) and of frame-by-frame scatter of the simulation, so that noise alone has variance 1 in every component
and frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array, Indices, Mask
from tactiledata.diagnose.touches.error_wrenches import ErrorFrames
from tactiledata.diagnose.touches.own_errors import OwnErrors
from tactiledata.diagnose.touches.simulation_errors import (
    ErrorDirection,
    NumericalErrors,
    error_list,
)
from tactiledata.diagnose.touches.touch_case import Played, Simulated, TouchSet
from tactiledata.effects.simulate.setting import EffectSetting
from tactiledata.gel.elasticity.material import GelMaterial
from tactiledata.nuisance.low_rank import low_rank_core, low_rank_power, low_rank_product
from tactiledata.nuisance.numerical import scatter_covariance

USUAL_RATIO = 40.0
"""Force over the noise of one component in a frame of a usual recording: some 3.5 N with 0.085 N of noise."""


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
    own : OwnErrors
        Standard deviations of what is off in one trajectory alone.
    simulated : (N, 6) N, N m, optional
        Wrenches of a fit, in proportion to which simulation and touch are off; the measured ones where ``None``.
    """

    touch_set: TouchSet
    errors: NumericalErrors
    trust: Array
    own: OwnErrors = field(default_factory=OwnErrors)
    simulated: Array | None = None

    @staticmethod
    def of(touch_set: TouchSet, errors: NumericalErrors | None = None, own: OwnErrors | None = None) -> WhitenedTouches:
        """Return the whitened trajectories of a set, every frame with trust 1.

        Parameters
        ----------
        touch_set : TouchSet
            Trajectories and simulation.
        errors : NumericalErrors, optional
            Standard deviations of the simulation's own errors.
        own : OwnErrors, optional
            Standard deviations of what is off in one trajectory alone.
        """
        rows = np.ones(int(touch_set.counts.sum()))
        return WhitenedTouches(touch_set, errors or NumericalErrors(), rows, own or OwnErrors())

    def with_trust(self, trust: Array) -> WhitenedTouches:
        """Return the same trajectories with factors (N,) on their whitened rows."""
        return replace(self, trust=trust)

    def with_simulated(self, wrench: Array) -> WhitenedTouches:
        """Return the same trajectories with wrenches (N, 6) of a fit, N and N m, that set the size of errors."""
        return replace(self, simulated=np.where(np.isfinite(wrench), wrench, self.measured))

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

    @property
    def _wrench(self) -> Array:
        """Wrenches (N, 6), N and N m, in proportion to which simulation and touch are off."""
        return self.measured if self.simulated is None else self.simulated

    @cached_property
    def free_air(self) -> Mask:
        """Rows (N,) in which nothing touches the gel."""
        return np.concatenate([case.free_air for case in self.touch_set.touches])

    @cached_property
    def noise_factors(self) -> Array:
        """Deviation (N,) of the noise of each row over that of a wrench at one frame of its trajectory."""
        return np.concatenate([case.noise_factors for case in self.touch_set.touches])

    @cached_property
    def _of_noise(self) -> Array:
        """Matrix (N, 6, 6) of each row that whitens the noise alone, from the right."""
        whitening = np.stack([case.noise.whitened(np.eye(6)) for case in self.touch_set.touches])[self.trajectory]
        return whitening / self.noise_factors[:, None, None]

    @cached_property
    def _whitening(self) -> Array:
        """Matrix (N, 6, 6) of each row by which a wrench is multiplied from the right, own errors not considered.

        It is 0 where the wrench is unknown, and small where the simulation scatters much.
        """
        known = np.isfinite(np.concatenate([case.measured for case in self.touch_set.touches])).all(axis=1)
        trust = (self.trust * known)[:, None, None]
        of_noise = self._of_noise
        # in units of the noise the covariance is I + scatter: its inverse root, by eigenvalues
        values, axes = np.linalg.eigh(of_noise.transpose(0, 2, 1) @ self._scatter @ of_noise)
        shrunk = (axes / np.sqrt(1.0 + np.maximum(values, 0.0))[:, None, :]) @ axes.transpose(0, 2, 1)
        whitening: Array = trust * (of_noise @ shrunk)
        return whitening

    @property
    def _scatter(self) -> Array:
        """Covariance (N, 6, 6), in squares and products of N and N m, of the simulation's frame-by-frame scatter."""
        size = np.where(self.free_air, 0.0, np.linalg.norm(self._wrench[:, :3], axis=1))
        places = np.concatenate([case.touch.tips for case in self.touch_set.touches])
        along = np.repeat(self.errors.scatter * size[:, None], 3, axis=1)
        return scatter_covariance(along, self.errors.centre * size, places)

    @cached_property
    def own_fields(self) -> Array:
        """Whitened change (N, 6, r) over one standard deviation of each of the r unknowns of a trajectory."""
        wrenches = np.split(self._wrench, self.starts[1:])
        pairs = zip(self.touch_set.touches, wrenches, strict=True)
        fields = np.concatenate([self.own.fields(case, wrench) for case, wrench in pairs])
        whitened: Array = self._whitening.transpose(0, 2, 1) @ fields
        return whitened

    @cached_property
    def _marginalising(self) -> Array:
        """Matrices (t, r, r) that marginalise the own unknowns of each trajectory; see `low_rank_core`."""
        return low_rank_core(self.own_fields, self.starts, -0.5)

    @cached_property
    def weights(self) -> Array:
        """Weight (N,) of each row over all components: 1 where noise is all there is, 0 where the wrench is unknown.

        It is below 1 where the simulation scatters beside the noise.
        """
        share = np.linalg.inv(self._of_noise) @ self._whitening
        weights: Array = np.sqrt(np.einsum("nij,nij->n", share, share) / 6.0)
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
    def precision(self) -> float:
        """Mean square of force over noise in contact, over ``USUAL_RATIO`` squared; at least 1.

        A frame's errors of the simulation are shares of its force: in units of the noise they grow with this number.
        """
        force = np.linalg.norm(self.measured[:, :3], axis=1)
        deviations = np.stack([case.noise.deviations[:3].mean() for case in self.touch_set.touches])[self.trajectory]
        ratios = (force / (deviations * self.noise_factors))[~self.free_air & (self.weights > 0)]
        return max(1.0, float((ratios**2).mean()) / USUAL_RATIO**2) if len(ratios) else 1.0

    def whiten(self, rows: Array) -> Array:
        """Return wrenches (N, 6) or (N, 6, c), N and N m, whitened, own unknowns marginalised; 0 where not finite."""
        wrenches = np.nan_to_num(rows.reshape(len(rows), 6, -1))
        white = self._whitening.transpose(0, 2, 1) @ wrenches
        return low_rank_product(white, self.own_fields, self.starts, self._marginalising).reshape(rows.shape)

    def part(self, chosen: Mask) -> WhitenedTouches:
        """Return the chosen ones (t,) of the trajectories."""
        kept = [case for case, is_kept in zip(self.touch_set.touches, chosen, strict=True) if is_kept]
        rows = chosen[self.trajectory]
        simulated = None if self.simulated is None else self.simulated[rows]
        return replace(
            self, touch_set=replace(self.touch_set, touches=kept), trust=self.trust[rows], simulated=simulated
        )

    def with_own(self, white: Array) -> Array:
        """Return whitened rows (N, 6) or (N, 6, c) with the marginalisation of own unknowns undone: frame by frame."""
        rows = white.reshape(len(white), 6, -1)
        return low_rank_power(rows, self.own_fields, self.starts, 0.5).reshape(white.shape)

    def in_newtons(self, rows: Array) -> Array:
        """Return rows (N, 6) of `with_own` as wrenches in N and N m; 0 where the wrench is unknown."""
        known = self.weights > 0
        raw = np.zeros_like(rows)
        raw[known] = np.einsum("nj,nji->ni", rows[known], np.linalg.inv(self._whitening[known]))
        return raw

    def residual(self, predicted: Array) -> Array:
        """Return measured less predicted wrenches (N, 6), whitened; 0 for components that the simulation lacks."""
        return self.whiten(self.measured - np.where(np.isfinite(predicted), predicted, self.measured))

    def simulation_error_fields(
        self, material: GelMaterial, offsets: Array | None = None, settings: Sequence[EffectSetting] = ()
    ) -> Array:
        """Return the simulation's own errors as whitened wrenches (N, 6, e), one standard deviation each.

        Parameters
        ----------
        material : GelMaterial
            Material of the simulation whose forces are off.
        offsets : (t,) m, optional
            Contact offset of each trajectory, where it is known.
        settings : sequence of EffectSetting
            Effects of the simulation, which act on the errors of forces as on the forces.
        """
        return self.whiten(self.simulation_error_wrenches(material, offsets, settings))

    def simulation_error_wrenches(
        self, material: GelMaterial, offsets: Array | None = None, settings: Sequence[EffectSetting] = ()
    ) -> Array:
        """Return the simulation's own errors as wrenches (N, 6, e) in N and N m, one standard deviation each.

        Parameters
        ----------
        material : GelMaterial
            Material of the simulation whose forces are off.
        offsets : (t,) m, optional
            Contact offset of each trajectory, where it is known.
        settings : sequence of EffectSetting
            Effects of the simulation.
        """
        return self.error_frames.wrenches(*self.touch_set.simulate(material, settings, offsets))

    def erred(self, simulated: Simulated | Played, errors: Array) -> Array:
        """Return simulated wrenches (N, 6), N and N m, with the simulation's own errors; as they are without any.

        Parameters
        ----------
        simulated : Simulated or Played
            Simulated wrenches, and the friction that they met.
        errors : (e,)
            Errors in their standard deviations, in the order of `simulation_errors`; empty where there are none.
        """
        wrench = simulated.wrench
        return self.error_frames.erred(wrench, simulated.friction, errors) if len(errors) else wrench

    @cached_property
    def error_frames(self) -> ErrorFrames:
        """The frames, at which the simulation errs."""
        measured, poses = (
            np.concatenate(rows)
            for rows in zip(*((case.measured, case.touch.poses) for case in self.touch_set.touches), strict=True)
        )
        return ErrorFrames(
            self.errors, measured, poses, self.indenter_names, self.indenter[self.trajectory], self.starts
        )

    @property
    def indenter_names(self) -> list[str]:
        """Names of the indenters, in the order of their numbers."""
        return [str(name) for name in np.unique(self.touch_set.indenters)]

    @property
    def simulation_errors(self) -> tuple[ErrorDirection, ...]:
        """What the e errors of the simulation are, in the order of `simulation_error_fields`."""
        return error_list(self.errors, self.indenter_names)

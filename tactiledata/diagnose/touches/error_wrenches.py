"""Errors of simulated wrenches, as wrenches: the directions of `simulation_errors` at the frames of trajectories."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tactiledata.arrays import Array, Indices
from tactiledata.diagnose.residuals.history import largest_so_far
from tactiledata.diagnose.touches.played_columns import moved_wrench, wrench_at_height
from tactiledata.diagnose.touches.simulation_errors import KINDS, NumericalErrors, error_list

SLIDING = (0.9, 1.0)
"""Shares of the friction limit between which shear turns from sticking to sliding.

The turn is gradual: with a sharp one the errors would jump where a frame is near the limit."""
LARGEST_GROWTH = 2.5
"""Largest logarithm of a force over its typical one at which the growth of force is still counted."""


@dataclass(frozen=True)
class ErrorFrames:
    """Frames at which a simulation errs: what the directions of its errors need beside its wrenches.

    Parameters
    ----------
    errors : NumericalErrors
        Sizes.
    measured : (N, 6) N, N m
        Measured wrenches; not a number where unknown. Errors are shares of forces as large as these: a gel that is
        stiffer than the real one must not make them cheaper.
    poses : (N, 4, 4) m
        gel_from_indenter.
    names : list of i str
        Names of the indenters.
    owner : (N,)
        Index of each row's indenter.
    starts : (t,)
        First row of each trajectory.
    """

    errors: NumericalErrors
    measured: Array
    poses: Array
    names: Sequence[str]
    owner: Indices
    starts: Indices

    def wrenches(self, simulated: Array, friction: Array) -> Array:
        """Return the errors as wrenches (N, 6, e), N and N m, one standard deviation each, as in `error_list`.

        Parameters
        ----------
        simulated : (N, 6) N, N m
            Simulated wrenches; components that are not finite count as 0.
        friction : (N,)
            Friction coefficient, effects on it included: what lowers friction does not turn sliding into sticking.
        """
        of_each, of_all = self._directions(simulated, friction)
        rows, kinds = np.arange(len(simulated)), of_each.shape[2]
        own = np.zeros((len(simulated), 6, len(self.names), kinds))
        own[rows, :, self.owner] = of_each
        fields = np.concatenate([own.reshape(len(simulated), 6, -1), of_all], axis=2)
        return fields * self._deviations

    def erred(self, simulated: Array, friction: Array, errors: Array) -> Array:
        """Return simulated wrenches (N, 6), N and N m, with errors (e,) in standard deviations.

        Parameters
        ----------
        simulated, friction
            See `wrenches`.
        errors : (e,)
            Errors in the order of `error_list`.
        """
        of_each, of_all = self._directions(simulated, friction)
        scaled = errors * self._deviations
        shared = len(self.names) * len(KINDS)
        factors = scaled[:shared].reshape(len(self.names), len(KINDS))[self.owner]
        erred: Array = simulated + np.einsum("nck,nk->nc", of_each, factors) + of_all @ scaled[shared:]
        return erred

    @cached_property
    def _deviations(self) -> Array:
        """Standard deviations (e,) of the errors."""
        return np.array([error.deviation for error in error_list(self.errors, self.names)])

    @cached_property
    def _ways(self) -> Array:
        """Directions (N, 2, 2) of the indenter's x and y axes along the gel, one a row."""
        ways = np.transpose(np.nan_to_num(self.poses)[:, :2, :2], (0, 2, 1))
        lengths = np.maximum(np.linalg.norm(ways, axis=2, keepdims=True), 1e-9)
        return np.asarray(ways / lengths)

    def _directions(self, simulated: Array, friction: Array) -> tuple[Array, Array]:
        """Return changes by errors of size 1: of each row's own indenter (N, 6, k), and common ones (N, 6, c)."""
        simulated = np.nan_to_num(simulated)
        load, poses = simulated[:, 2], np.nan_to_num(self.poses)
        most = largest_so_far(load, self.starts)
        # a sensor that turns or mixes components can show a pull, which takes off no more than all
        unloaded = np.where(most > 0, np.clip(1.0 - load / np.where(most > 0, most, 1.0), 0.0, 1.0), 0.0)
        limit = friction * np.maximum(load, 0.0)
        since_turn = _since_largest(simulated[:, :3], limit, self.starts)
        contact = _Contact(simulated, poses[:, :3, 3], poses[:, :2, 2], self._ways, limit, since_turn)
        of_each = _directions(contact, *self._growth(simulated, self.owner, len(self.names)), unloaded)
        of_all = _directions(contact, *self._growth(simulated, np.zeros_like(self.owner), 1), unloaded)
        common = [unit for unit, kind in zip(of_all, KINDS, strict=True) if kind.is_common]
        own, all_alike = (
            self._scale(simulated, owner, count)[:, None, None]
            for owner, count in ((self.owner, len(self.names)), (np.zeros_like(self.owner), 1))
        )
        return np.stack(of_each, axis=2) * own, np.stack(common, axis=2) * all_alike

    def _scale(self, simulated: Array, owner: Indices, count: int) -> Array:
        """Return the factor (N,) that makes the simulated forces of each row's group as large as the measured ones."""
        size, real = (np.linalg.norm(wrench[:, :3], axis=1) for wrench in (simulated, self.measured))
        known = np.isfinite(real)
        products, squares = (np.bincount(owner[known], weights[known], count) for weights in (size * real, size**2))
        return np.asarray(np.divide(products, squares, out=np.ones(count), where=squares > 0)[owner])

    def _growth(self, simulated: Array, owner: Indices, count: int) -> tuple[Array, Array]:
        """Return the logarithm (N,) of the force over the typical one of the row's group, and its square's excess (N,).

        Typical is the geometric mean, the excess is that over the mean square; the logarithm has bounds. Both means are
        weighted by the force: frames where contact begins or ends would else move them by leaps.
        """
        size = np.linalg.norm(simulated[:, :3], axis=1)
        logarithms = np.log(np.maximum(size, 1e-300))
        typical = _mean_of(logarithms, size, owner, count)
        growth = np.clip(logarithms - typical, -LARGEST_GROWTH, LARGEST_GROWTH)
        return growth, growth**2 - _mean_of(growth**2, size, owner, count)


def _mean_of(values: Array, weights: Array, owner: Indices, count: int) -> Array:
    """Return the weighted mean (N,) of the values (N,) of each row's group; 0 where its weights (N,) are 0."""
    sums, totals = (np.bincount(owner, weighed, count) for weighed in (values * weights, weights))
    return np.asarray((sums / np.maximum(totals, 1e-300))[owner])


@dataclass(frozen=True)
class _Contact:
    """Simulated contact at N frames, from which the directions of errors are computed.

    Parameters
    ----------
    wrench : (N, 6) N, N m
        Simulated wrench.
    tips : (N, 3) m
        Tip of the indenter.
    axis : (N, 2)
        Components of the indenter's axis along the gel: its tilt.
    turned : (N, 2, 2)
        Directions of the indenter's x and y axes along the gel, one a row.
    limit : (N,) N
        Friction limit.
    since_turn : (N, 2) N
        Change of the shear since it was largest, in proportion to the load, times the square of the share of the
        friction limit at that moment: by so much a contact that slips at its edge comes back by another way.
    """

    wrench: Array
    tips: Array
    axis: Array
    turned: Array
    limit: Array
    since_turn: Array

    def sheared(self, shear: Array) -> Array:
        """Return the wrench (N, 6) of a tangential force (N, 2) at the tip."""
        return wrench_at_height(shear, self.tips[:, :2], self.tips[:, 2])

    def moved(self, motion: Array) -> Array:
        """Return the change (N, 6) of the wrench where its centre of pressure moves by (N, 2) metres."""
        return moved_wrench(self.wrench[:, :3], motion)


def _directions(contact: _Contact, growth: Array, bend: Array, unloaded: Array) -> list[Array]:
    """Return changes (N, 6) of the wrench by errors of size 1, in the order of ``KINDS``.

    Parameters
    ----------
    contact : _Contact
        Simulated contact.
    growth : (N,)
        Logarithm of the force over its typical one.
    bend : (N,)
        Square of it, less its mean in contact.
    unloaded : (N,)
        Share of the largest load so far that has been taken off.
    """
    wrench = contact.wrench
    load, shear = wrench[:, 2], wrench[:, :2]
    size = np.hypot(*shear.T)
    used = np.divide(size, contact.limit, out=np.zeros_like(size), where=contact.limit > 0)
    turned = np.clip((used - SLIDING[0]) / (SLIDING[1] - SLIDING[0]), 0.0, 1.0)
    slides = turned**2 * (3.0 - 2.0 * turned)
    sticking, sliding = (contact.sheared(shear * share[:, None]) for share in (1.0 - slides, slides))
    turned_back = contact.sheared(contact.since_turn * (1.0 - slides[:, None]))
    along, across = (np.einsum("ni,ni->n", shear, way)[:, None] * way for way in contact.turned.transpose(1, 0, 2))
    none = np.zeros_like(load)
    pushed = np.column_stack([none, none, load * np.minimum(used, 1.0) ** 2, none, none, none])
    factors = (growth, bend, unloaded)
    return [
        wrench, *(wrench * factor[:, None] for factor in factors), pushed,
        sticking, sticking * growth[:, None], sticking * used[:, None] ** 2, sticking * unloaded[:, None], turned_back,
        sliding, sliding * growth[:, None], sliding * unloaded[:, None],
        contact.sheared(along - across), contact.sheared(load[:, None] * contact.axis),
        contact.moved(contact.turned[:, 0]), contact.moved(contact.turned[:, 1]), contact.moved(contact.axis),
    ]  # fmt: skip


def _since_largest(force: Array, limit: Array, starts: Indices) -> Array:
    """Change (N, 2), N, of the shear of forces (N, 3) since it was largest in its trajectory; 0 while it grows.

    The largest shear is reduced with the load, so that the change ends with the contact. The change is multiplied by
    the square of the share of the friction limit (N,), N, that the largest shear was; at most 1.
    """
    shear, load = force[:, :2], np.maximum(force[:, 2], 0.0)
    size = np.hypot(*shear.T)
    rows = np.where(size >= largest_so_far(size, starts), np.arange(len(size)), 0)
    # the last row of each trajectory, so far, in which the shear was largest
    last = np.maximum(np.maximum.accumulate(rows), np.repeat(starts, np.diff([*starts, len(size)])))
    used = np.divide(size, limit, out=np.zeros_like(size), where=limit > 0)
    carried = np.minimum(np.divide(load, load[last], out=np.zeros_like(load), where=load[last] > 0), 1.0)
    change: Array = (shear - shear[last] * carried[:, None]) * np.minimum(used[last], 1.0)[:, None] ** 2
    return change

"""Errors of simulated wrenches by mesh, contact and solver: a few directions, with unknown sizes, for each indenter.

Two solvers of one gel differ by some per cent. The difference is smooth along a touch, differs from indenter to
indenter, and repeats in every touch of one indenter, so that more touches do not average it away. Here it is a sum of
a few directions for each indenter, each with a normal prior: factors on the force that grow with it, on shear that
sticks and that slides, on what a tilted indenter is pushed aside, and motions of the centre of pressure. A fit
determines their sizes with everything else.

Source: Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001), with a basis in place of a Gaussian process.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array, Indices, Mask
from tactiledata.diagnose.residuals.history import largest_so_far
from tactiledata.diagnose.touches.played_columns import moved_wrench, wrench_at_height
from tactiledata.nuisance.numerical import LAW_ERROR, SHAPE_ERROR

NORMAL, SHEAR, CENTRE = "normal force", "shear", "centre of pressure"
"""Families of errors, each with a size of its own."""
FAMILIES = (NORMAL, SHEAR, CENTRE)
SLIDING = (0.9, 1.0)
"""Shares of the friction limit between which shear turns from sticking to sliding.

The turn is gradual: with a sharp one the errors would jump where a frame is near the limit, and fits with errors about
different materials would differ by more than effects do."""
LARGEST_GROWTH = 2.5
"""Largest logarithm of a force over its typical one at which the growth of force is still counted."""


@dataclass(frozen=True)
class NumericalErrors:
    """Standard deviations of the errors of a simulation.

    Parameters
    ----------
    shape : float
        Of a factor on all forces of one indenter, about 1.
    law : float
        Of the growth of force: a share over a factor e of the force, common to all indenters and of each of them.
    shear : float
        Of a factor on shear that sticks, about 1, common to all indenters and of each of them.
    scatter : float
        Of each frame by itself, as a share of its force.
    centre : float
        Of the centre of pressure, in metres, under one indenter and of each frame by itself.
    sizes : dict, (family, indenter) -> float
        Factor on the errors of a family under an indenter, as estimated from the data at hand; the indenter is empty
        for errors that all have in common. It is 1 where nothing is known.
    """

    shape: float = SHAPE_ERROR["finite-strain"]
    law: float = 0.03
    shear: float = 0.04
    scatter: float = 0.007
    centre: float = 4e-5
    sizes: Mapping[tuple[str, str], float] | None = None

    @staticmethod
    def of(mechanics: str) -> NumericalErrors:
        """Return the errors of a kind of mechanics: a key of ``SHAPE_ERROR``, as "finite-strain" or "linear"."""
        law = 0.03 * (LAW_ERROR[mechanics] / LAW_ERROR["finite-strain"])
        return NumericalErrors(shape=SHAPE_ERROR[mechanics], law=law)

    def with_sizes(self, sizes: Mapping[tuple[str, str], float]) -> NumericalErrors:
        """Return the same errors with other factors, for each family and indenter."""
        return replace(self, sizes=dict(sizes))

    def size(self, family: str, indenter: str = "") -> float:
        """Return the factor on the errors of a family under an indenter, or on those that all have in common."""
        return 1.0 if self.sizes is None else self.sizes.get((family, indenter), 1.0)


@dataclass(frozen=True)
class ErrorDirection:
    """One direction in which the simulation may err.

    Parameters
    ----------
    what : str
        The error in words, without the indenter.
    family : str
        One of ``FAMILIES``.
    deviation : float
        Standard deviation, a share of the force, or metres.
    indenter : str
        Indenter whose simulation errs; empty where the error is common to all.
    """

    what: str
    family: str
    deviation: float
    indenter: str = ""

    @property
    def label(self) -> str:
        """The error in words, with the indenter."""
        return f"{self.what} of {self.indenter}" if self.indenter else self.what


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


def _directions(contact: _Contact, rows: Mask, growth: Array, unloaded: Array) -> list[Array]:
    """Return changes (N, 6) of the wrench by errors of size 1, of one indenter or of all, in the order of ``KINDS``.

    Parameters
    ----------
    rows : (N,) bool
        Frames of the indenter.
    growth : (N,)
        Logarithm of the force over its typical one.
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
    touched = rows & (load > 0)
    bend = growth**2 - float(np.mean(growth[touched] ** 2)) if touched.any() else growth
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


@dataclass(frozen=True)
class ErrorKind:
    """One kind of error of a simulation; its standard deviation is a multiple of one of `NumericalErrors`.

    Parameters
    ----------
    what : str
        The error in words, without the indenter.
    family : str
        One of ``FAMILIES``.
    of : str
        Name of the field of `NumericalErrors`.
    times : float
        Factor on it.
    is_common : bool
        Whether all indenters have such an error in common, beside that of each of them.
    """

    what: str
    family: str
    of: str
    times: float = 1.0
    is_common: bool = False


KINDS = (
    ErrorKind("all forces", NORMAL, "shape"),
    ErrorKind("the growth of force with depth", NORMAL, "law", is_common=True),
    ErrorKind("the curve of force over depth", NORMAL, "law", 0.5),
    ErrorKind("force while it is taken off", NORMAL, "law", 0.5),
    ErrorKind("normal force under shear", NORMAL, "law", 0.5),
    ErrorKind("shear that sticks", SHEAR, "shear", is_common=True),
    ErrorKind("the growth of shear with depth", SHEAR, "shear", 0.5),
    ErrorKind("shear that begins to slide", SHEAR, "shear"),
    ErrorKind("shear that sticks while the force is taken off", SHEAR, "shear", 0.5),
    ErrorKind("shear after a turn", SHEAR, "shear"),
    ErrorKind("shear that slides", SHEAR, "shear", 0.5),
    ErrorKind("the growth of sliding shear with depth", SHEAR, "shear", 0.5),
    ErrorKind("sliding shear while the force is taken off", SHEAR, "shear", 0.5),
    ErrorKind("shear along the indenter's x against its y", SHEAR, "shear", 0.5),
    ErrorKind("the push aside by a tilt", SHEAR, "shear", 4.0),
    ErrorKind("the centre of pressure along the indenter's x", CENTRE, "centre"),
    ErrorKind("the centre of pressure along the indenter's y", CENTRE, "centre"),
    ErrorKind("the centre of pressure under a tilt", CENTRE, "centre", 20.0),
)
"""Kinds of errors, in the order of the fields."""


def error_list(errors: NumericalErrors, names: Sequence[str]) -> tuple[ErrorDirection, ...]:
    """Return the directions in which a simulation may err: those of each indenter, then those of all together.

    Parameters
    ----------
    errors : NumericalErrors
        Sizes.
    names : sequence of str
        Names of the indenters.
    """

    def error(kind: ErrorKind, name: str) -> ErrorDirection:
        deviation = kind.times * getattr(errors, kind.of) * errors.size(kind.family, name)
        return ErrorDirection(kind.what, kind.family, deviation, name)

    of_each = [error(kind, name) for name in names for kind in KINDS]
    return (*of_each, *(error(kind, "") for kind in KINDS if kind.is_common))


def error_wrenches(
    errors: NumericalErrors,
    plain: Array,
    poses: Array,
    friction: float,
    names: Sequence[str],
    owner: Indices,
    starts: Indices,
) -> Array:
    """Return the errors of a simulation as wrenches (N, 6, e), one standard deviation each, as in `error_list`.

    Parameters
    ----------
    errors : NumericalErrors
        Sizes.
    plain : (N, 6) N, N m
        Simulated wrenches.
    poses : (N, 4, 4) m
        gel_from_indenter.
    friction : float
        Friction coefficient of the gel.
    names : sequence of i str
        Names of the indenters.
    owner : (N,)
        Index of each row's indenter.
    starts : (t,)
        First row of each trajectory.
    """
    load = plain[:, 2]
    poses = np.nan_to_num(poses)
    ways = np.transpose(poses[:, :2, :2], (0, 2, 1))
    lengths = np.maximum(np.linalg.norm(ways, axis=2, keepdims=True), 1e-9)
    most = largest_so_far(load, starts)
    unloaded = np.where(most > 0, 1.0 - load / np.where(most > 0, most, 1.0), 0.0)
    limit = friction * np.maximum(load, 0.0)
    since_turn = _since_largest(plain[:, :3], limit, starts)
    whole = _Contact(plain, poses[:, :3, 3], poses[:, :2, 2], ways / lengths, limit, since_turn)
    size = np.linalg.norm(plain[:, :3], axis=1)

    def growth(rows: Array) -> Array:
        """Logarithm (N,) of the force over the geometric mean of the forces of some rows, within bounds."""
        touched = size[rows & (size > 0)]
        typical = np.exp(np.mean(np.log(touched))) if len(touched) else 1.0
        logarithm = np.log(np.maximum(size, 1e-300) / typical)
        return np.where(size > 0, np.clip(logarithm, -LARGEST_GROWTH, LARGEST_GROWTH), 0.0)

    units: list[Array] = []
    for number in range(len(names)):
        rows = owner == number
        units += [unit * rows[:, None] for unit in _directions(whole, rows, growth(rows), unloaded)]
    every = np.ones(len(load), dtype=bool)
    together = _directions(whole, every, growth(every), unloaded)
    units += [unit for unit, kind in zip(together, KINDS, strict=True) if kind.is_common]
    deviations = [error.deviation for error in error_list(errors, names)]
    return np.stack(units, axis=2) * np.array(deviations)

"""Residuals (measured minus simulated) of all frames, with the covariates, labels and parameters they may depend on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
from tactiledata.errors import TactileDataError, UsageError

Names = NDArray[np.str_]
"""Texts (n,), one for each frame."""

FEWEST_UNITS = 8
"""Fewest units of exchange for any test: the signs of 8 units have 256 patterns, and fewer allow no small p-value."""


@dataclass(frozen=True)
class Covariate:
    """A number of each frame that a residual may depend on, such as depth or speed.

    Parameters
    ----------
    values : (n,)
        Finite, one for each frame.
    unit : str
        ``"mm/s"``, ``"N"``, ``"1"`` where it has none, ``"?"`` where it is not known.
    definition : str
        How the covariate is computed from others, in words; empty for one that was recorded.
    steps_of : str
        Set where the covariate is the time since the last step of another one: the name of that one, with the
        condition under which the time counts. Empty for all others.
    """

    values: Array
    unit: str = "1"
    definition: str = ""
    steps_of: str = ""


@dataclass(frozen=True)
class ResidualParameter:
    """A parameter of the simulation that was fitted, or could have been.

    Parameters
    ----------
    name, unit : str
        Name and unit in sentences.
    value : float
        Fitted value in ``unit``; changes are reported as shares of it. NaN: changes are reported in ``unit``.
    own_deviation : float, optional
        Standard deviation of a normal prior from which each trajectory draws its own value (``inf``: no prior);
        ``None``: all trajectories share one value.
    is_tested : bool
        Whether locators test if the parameter drifts, or what its values follow where each trajectory has its own.
        Nuisance parameters, such as errors of the simulation itself, are refitted and never tested.
    prior_deviation : float
        Standard deviation of a normal prior about 0 of a value that all trajectories share; ``inf`` (the default): no
        prior. Most tests refit shared values freely. Values of trajectories' own parameters heed the prior.
    """

    name: str
    unit: str = "1"
    value: float = float("nan")
    own_deviation: float | None = None
    is_tested: bool = True
    prior_deviation: float = float("inf")


@dataclass(frozen=True)
class Residuals:
    """Whitened residuals of n frames and k components, with what is known of the frames.

    Parameters
    ----------
    values : (n, k)
        Measured minus simulated, in units in which the noise is white and of variance 1.
    components : tuple of k str
        Name of each component, such as ``"fz"``.
    groups : (n,)
        Trajectory number of each frame; frames of one trajectory lie together, in order of time.
    covariates : dict, name -> Covariate
        Numbers of each frame that the residual may depend on.
    labels : dict, name -> (n,) texts
        For example indenter, sensor, ``phase`` ("free air", "approach", "press", "dwell", "shear", "leave") and
        ``contact`` ("stick", "slip").
    parameters : tuple of p ResidualParameter
        Parameters of the simulation, in the order of ``sensitivities``.
    sensitivities : (n, k, p), optional
        Derivative of the whitened simulation by each parameter; ``None`` where there are no parameters.
    blocks : (n,), optional
        Number of each frame's unit of exchange, where units are larger than trajectories, such as days of recording.
    units : tuple of k str, optional
        Unit of each component before whitening.
    deviations : (k,), optional
        Standard deviation of the noise of each component, in ``units``.
    ways : dict, name -> (n, k)
        Further directions, of unit length or 0, in which departures are sought. Example: the direction of slide, which
        no single component shows, as trajectories slide to all sides.
    scale : str
        What the values are multiples of, in words: ``"times the noise"``, or the scatter where noise is not known.

    Raises
    ------
    UsageError
        Shapes do not fit, values are not finite, or a trajectory lies in several pieces.
    """

    values: Array
    components: tuple[str, ...]
    groups: Indices
    covariates: Mapping[str, Covariate] = field(default_factory=dict)
    labels: Mapping[str, Names] = field(default_factory=dict)
    parameters: tuple[ResidualParameter, ...] = ()
    sensitivities: Array | None = None
    blocks: Indices | None = None
    units: tuple[str, ...] = ()
    deviations: Array | None = None
    ways: Mapping[str, Array] = field(default_factory=dict)
    scale: str = "times the noise"

    def __post_init__(self) -> None:
        """Refuse shapes that do not fit, values that are not finite, and trajectories in several pieces."""
        rows, width = self.values.shape
        _fits(width == len(self.components), f"{width} columns and {len(self.components)} names of components")
        _finite("residuals", self.values)
        for name, covariate in self.covariates.items():
            _fits(covariate.values.shape == (rows,), f"covariate {name} of shape {covariate.values.shape}")
            _finite(f"covariate {name}", covariate.values)
        for name, texts in self.labels.items():
            _fits(texts.shape == (rows,), f"label {name} of shape {texts.shape}")
        for name, way in self.ways.items():
            _fits(way.shape == (rows, width), f"way {name} of shape {way.shape}")
        _fits(self.slopes.shape == (rows, width, len(self.parameters)), f"sensitivities of shape {self.slopes.shape}")
        _finite("sensitivities", self.slopes)
        _fits(self.groups.shape == (rows,), f"groups of shape {self.groups.shape}")
        pieces = self.groups[self.starts]
        _fits(len(np.unique(pieces)) == len(pieces), "a trajectory whose frames do not lie together")

    @property
    def slopes(self) -> Array:
        """The sensitivities (n, k, p); p is 0 where none were given."""
        if self.sensitivities is not None:
            return self.sensitivities
        return np.zeros((*self.values.shape, 0))

    @cached_property
    def starts(self) -> Indices:
        """Row (t,) at which each trajectory begins."""
        if not len(self.groups):
            return np.zeros(0, dtype=np.int64)
        return np.flatnonzero(np.concatenate([[True], np.diff(self.groups) != 0])).astype(np.int64)

    @property
    def counts(self) -> Indices:
        """Number of frames (t,) of each trajectory."""
        return np.diff(self.starts, append=len(self.groups)).astype(np.int64)

    @cached_property
    def trajectory(self) -> Indices:
        """Index (n,) of each frame's trajectory, counted from 0 in order of the rows."""
        return np.repeat(np.arange(len(self.starts)), self.counts)

    @cached_property
    def unit_of_trajectory(self) -> Indices:
        """Index (t,) of each trajectory's unit of exchange, counted from 0."""
        if self.blocks is None:
            return np.arange(len(self.starts))
        return np.unique(self.blocks[self.starts], return_inverse=True)[1].astype(np.int64)

    @property
    def unit_count(self) -> int:
        """Number of units of exchange."""
        return int(self.unit_of_trajectory.max(initial=-1)) + 1

    @property
    def tested(self) -> tuple[int, ...]:
        """Indices of the parameters that all trajectories share and that locators test."""
        return tuple(
            place
            for place, parameter in enumerate(self.parameters)
            if parameter.own_deviation is None and parameter.is_tested
        )

    @property
    def shared(self) -> tuple[int, ...]:
        """Indices of the parameters that all trajectories share; those that are tested come first."""
        others = (
            place
            for place, parameter in enumerate(self.parameters)
            if parameter.own_deviation is None and not parameter.is_tested
        )
        return (*self.tested, *others)

    def by_unit(self, per_frame: Array) -> Array:
        """Return sums (u, …) of per-frame values (n, …) over each unit of exchange."""
        return self.units_of(np.add.reduceat(per_frame, self.starts, axis=0))

    def products(self, left: Array, right: Array) -> Array:
        """Return the products (t, a, c) of columns (n, a) with columns (n, c), summed over each trajectory's frames."""
        found = np.zeros((len(self.starts), left.shape[1], right.shape[1]))
        for place, (start, count) in enumerate(zip(self.starts, self.counts, strict=True)):
            found[place] = left[start : start + count].T @ right[start : start + count]
        return found

    def units_of(self, per_trajectory: Array) -> Array:
        """Return sums (u, …) of per-trajectory values (t, …) over each unit of exchange."""
        if self.blocks is None:
            return per_trajectory
        total = np.zeros((self.unit_count, *per_trajectory.shape[1:]))
        np.add.at(total, self.unit_of_trajectory, per_trajectory)
        return total

    def part(self, rows: NDArray[np.bool_]) -> Residuals:
        """Return the residuals of the frames in a mask (n,), with their covariates, labels and sensitivities."""
        return replace(
            self,
            values=self.values[rows],
            groups=self.groups[rows],
            covariates={
                name: replace(covariate, values=covariate.values[rows]) for name, covariate in self.covariates.items()
            },
            labels={name: texts[rows] for name, texts in self.labels.items()},
            sensitivities=None if self.sensitivities is None else self.sensitivities[rows],
            blocks=None if self.blocks is None else self.blocks[rows],
            ways={name: way[rows] for name, way in self.ways.items()},
        )

    def with_values(self, values: Array) -> Residuals:
        """Return a copy with other whitened residuals (n, k) of the same frames."""
        return replace(self, values=values)

    def with_fields(self, fields: Mapping[str, Array]) -> Residuals:
        """Return a copy with further shared parameters at the end, whose whitened sensitivities are fields (n, k)."""
        if not fields:
            return self
        return replace(
            self,
            parameters=(*self.parameters, *(ResidualParameter(name) for name in fields)),
            sensitivities=np.concatenate([self.slopes, np.stack(list(fields.values()), axis=2)], axis=2),
        )

    def need_units(self, what: str) -> None:
        """Refuse a test, named ``what``, for which there are too few units of exchange.

        Raises
        ------
        TactileDataError
            There are fewer than `FEWEST_UNITS` units.
        """
        if self.unit_count < FEWEST_UNITS:
            raise TactileDataError(
                f"{self.unit_count} trajectories or blocks for {what}",
                f"at least {FEWEST_UNITS}: whole trajectories are exchanged, never frames",
                "Record more trajectories.",
                units=self.unit_count,
            )


def joined_names(names: Sequence[str]) -> str:
    """Return the names joined for a sentence: ``"a"``, ``"a and b"``, ``"a, b and c"``."""
    listed = list(names)
    return listed[0] if len(listed) == 1 else f"{', '.join(listed[:-1])} and {listed[-1]}" if listed else ""


def _fits(is_right: bool, found: str) -> None:
    """Refuse residuals whose parts do not fit together; ``found`` says which."""
    if not is_right:
        raise UsageError(f"residuals with {found}", "one row for each frame, frames of a trajectory together")


def _finite(what: str, values: Array) -> None:
    """Refuse values that are NaN or infinite."""
    if not np.isfinite(values).all():
        raise UsageError(f"{what} with values that are not finite", "finite values", "Leave these frames out.")

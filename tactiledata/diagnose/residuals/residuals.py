"""What is left of recordings after their simulation, with all that it may depend on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from tactiledata.arrays import Array, Indices
from tactiledata.errors import TactileDataError, UsageError

Names = NDArray[np.str_]

FEWEST_UNITS = 8
"""Signs of 8 units have 256 patterns; with fewer no p-value can be small enough to be worth a sentence."""


@dataclass(frozen=True)
class Covariate:
    """What a residual may depend on.

    Parameters
    ----------
    values : (n,)
        Finite, one for each frame.
    unit : str
        ``"mm/s"``, ``"N"``, ``"1"`` where it has none, ``"?"`` where it is not known.
    definition : str
        How it is computed, of one that is made of others.
    steps_of : str
        Since whose last step it is the time, and while what, in words; empty for all others.
    """

    values: Array
    unit: str = "1"
    definition: str = ""
    steps_of: str = ""


@dataclass(frozen=True)
class ResidualParameter:
    """A parameter of the simulation that was fitted, or might have been.

    Parameters
    ----------
    name, unit : str
    value : float
        Where it stands; changes are said as shares of it. NaN: they are said in ``unit``.
    own_deviation : float, optional
        Each trajectory has a value of its own, normal with this standard deviation (``inf``: any); ``None``: all
        share one.
    is_tested : bool
        Whether locators ask if it drifts, or what it follows where each trajectory has its own. Numbers that a fit
        has and nobody doubts, as errors of the simulation itself, are refitted and never asked.
    """

    name: str
    unit: str = "1"
    value: float = float("nan")
    own_deviation: float | None = None
    is_tested: bool = True


@dataclass(frozen=True)
class Residuals:
    """Whitened residuals of n frames, k components, and what is known of the frames.

    Parameters
    ----------
    values : (n, k)
        Measured minus simulated, in units in which the noise is white and of variance 1.
    components : k names
    groups : (n,)
        The trajectory of each frame; frames of one trajectory lie together, in order of time.
    covariates : dict, name -> Covariate
    labels : dict, name -> (n,) texts
        For example indenter, sensor, ``phase`` ("free air", "approach", "press", "dwell", "shear", "leave") and
        ``contact`` ("stick", "slip").
    parameters : sequence of ResidualParameter
    sensitivities : (n, k, p)
        Change of the whitened simulation over that of each parameter.
    blocks : (n,), optional
        Units of exchange where they are larger than trajectories, as days of recording are.
    units : k texts, optional
        Unit of each component before it was whitened.
    deviations : (k,), optional
        Standard deviation of the noise in those units.
    ways : dict, name -> (n, k)
        Further directions, of unit length or 0, in which departures are sought: what goes with the slide of each
        trajectory shows in no component, as trajectories slide to all sides.
    scale : str
        What the values are multiples of, in words: the scatter where the noise is not known.

    Raises
    ------
    UsageError
        Shapes that do not fit, values that are not finite, or a trajectory in several pieces.
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
        """The sensitivities (n, k, p), empty where none were given."""
        if self.sensitivities is not None:
            return self.sensitivities
        return np.zeros((*self.values.shape, 0))

    @cached_property
    def starts(self) -> Indices:
        """First row of each trajectory (t,)."""
        if not len(self.groups):
            return np.zeros(0, dtype=np.int64)
        return np.flatnonzero(np.concatenate([[True], np.diff(self.groups) != 0])).astype(np.int64)

    @property
    def counts(self) -> Indices:
        """Frames of each trajectory (t,)."""
        return np.diff(self.starts, append=len(self.groups)).astype(np.int64)

    @cached_property
    def trajectory(self) -> Indices:
        """Number of each frame's trajectory (n,), counted from 0 in order of the rows."""
        return np.repeat(np.arange(len(self.starts)), self.counts)

    @cached_property
    def unit_of_trajectory(self) -> Indices:
        """Unit of exchange of each trajectory (t,), counted from 0."""
        if self.blocks is None:
            return np.arange(len(self.starts))
        return np.unique(self.blocks[self.starts], return_inverse=True)[1].astype(np.int64)

    @property
    def unit_count(self) -> int:
        """Units of exchange."""
        return int(self.unit_of_trajectory.max(initial=-1)) + 1

    @property
    def tested(self) -> tuple[int, ...]:
        """Places of the parameters that all trajectories share and locators ask about."""
        return tuple(place for place, one in enumerate(self.parameters) if one.own_deviation is None and one.is_tested)

    @property
    def shared(self) -> tuple[int, ...]:
        """Places of the parameters that all trajectories share, those that are tested first."""
        others = (place for place, one in enumerate(self.parameters) if one.own_deviation is None and not one.is_tested)
        return (*self.tested, *others)

    def by_unit(self, per_frame: Array) -> Array:
        """Sums (u, …) over the units of exchange of what each frame holds (n, …)."""
        return self.units_of(np.add.reduceat(per_frame, self.starts, axis=0))

    def units_of(self, per_trajectory: Array) -> Array:
        """Sums (u, …) over the units of exchange of what each trajectory holds (t, …)."""
        if self.blocks is None:
            return per_trajectory
        total = np.zeros((self.unit_count, *per_trajectory.shape[1:]))
        np.add.at(total, self.unit_of_trajectory, per_trajectory)
        return total

    def part(self, rows: NDArray[np.bool_]) -> Residuals:
        """The frames of a mask (n,)."""
        return replace(
            self,
            values=self.values[rows],
            groups=self.groups[rows],
            covariates={name: replace(one, values=one.values[rows]) for name, one in self.covariates.items()},
            labels={name: texts[rows] for name, texts in self.labels.items()},
            sensitivities=None if self.sensitivities is None else self.sensitivities[rows],
            blocks=None if self.blocks is None else self.blocks[rows],
            ways={name: way[rows] for name, way in self.ways.items()},
        )

    def with_values(self, values: Array) -> Residuals:
        """The same frames with other residuals (n, k)."""
        return replace(self, values=values)

    def with_fields(self, fields: Mapping[str, Array]) -> Residuals:
        """The same with whitened fields (n, k) as further shared parameters, at the end."""
        if not fields:
            return self
        return replace(
            self,
            parameters=(*self.parameters, *(ResidualParameter(name) for name in fields)),
            sensitivities=np.concatenate([self.slopes, np.stack(list(fields.values()), axis=2)], axis=2),
        )

    def need_units(self, what: str) -> None:
        """Nothing, where there are units enough.

        Raises
        ------
        TactileDataError
            Fewer than `FEWEST_UNITS` of them.
        """
        if self.unit_count < FEWEST_UNITS:
            raise TactileDataError(
                f"{self.unit_count} trajectories or blocks for {what}",
                f"at least {FEWEST_UNITS}: whole trajectories are exchanged, never frames",
                "Record more of them.",
                units=self.unit_count,
            )


def joined_names(names: Sequence[str]) -> str:
    """Names in a sentence: ``"a"``, ``"a and b"``, ``"a, b and c"``."""
    listed = list(names)
    return listed[0] if len(listed) == 1 else f"{', '.join(listed[:-1])} and {listed[-1]}" if listed else ""


def _fits(is_right: bool, found: str) -> None:
    if not is_right:
        raise UsageError(f"residuals with {found}", "one row for each frame, frames of a trajectory together")


def _finite(what: str, values: Array) -> None:
    if not np.isfinite(values).all():
        raise UsageError(f"{what} with values that are not finite", "finite values", "Leave such frames out before.")

"""A parameter of an effect: its meaning, its unit, and which of its values can be believed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tactiledata.errors import UsageError

DIMENSIONS: dict[str, tuple[int, int, int]] = {
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "s": (0, 0, 1),
    "Hz": (0, 0, -1),
    "m": (1, 0, 0),
    "m/s": (1, 0, -1),
    "1/m": (-1, 0, 0),
    "1/m^2": (-2, 0, 0),
    "N": (0, 1, 0),
    "N m": (1, 1, 0),
    "N/m": (-1, 1, 0),
    "m/N": (1, -1, 0),
    "1/N": (0, -1, 0),
    "N/rad": (0, 1, 0),
    "N m/rad": (1, 1, 0),
    "rad/(N m)": (-1, -1, 0),
    "Pa": (-2, 1, 0),
    "1/Pa": (2, -1, 0),
    "J/m^2": (-1, 1, 0),
    "kg": (-1, 1, 2),
    "kg m": (0, 1, 2),
}
"""Exponents of length, force and time of each unit that a parameter may have; another unit is added here."""

FARTHER = 2.0
"""Factor on the ends of a plausible range beyond which another cause is suspected: ranges are estimates, and a tenth
more proves nothing."""
Interval = tuple[float, float]
"""Lower and upper end of a range."""


@dataclass(frozen=True)
class Parameter:
    """A number that an effect needs; made by `strength` or `shape`.

    Parameters
    ----------
    name : str
        Name in settings.
    unit : str
        One of ``DIMENSIONS``.
    meaning : str
        What the number says, for pages and messages.
    null : float, optional
        Value at which the effect is absent; ``None`` for a shape, which alone changes nothing.
    default : float
        Value where none is given; the null of a strength.
    bounds : (low, high)
        Values that a fit may try, and a setting may hold.
    plausible : (low, high)
        Values that can be believed on such a rig; a fit outside suggests another cause.
    deviation : float, optional
        Standard deviation of the normal prior of a strength about its null; ``None`` for a shape, whose prior is flat
        within its bounds.
    source : str
        Where the plausible range comes from; an estimate of ours says so.
    grid : tuple of float
        Values of a shape that a screen tries. For a strength that acts from a threshold on, the sizes that a screen
        tries.
    """

    name: str
    unit: str
    meaning: str
    null: float | None
    default: float
    bounds: Interval
    plausible: Interval
    deviation: float | None
    source: str
    grid: tuple[float, ...] = ()

    def check(self, value: float, effect: str) -> float:
        """Return the value, as a float, where it is a finite number within the bounds.

        Raises
        ------
        UsageError
            The value is no number, not finite, or out of bounds.
        """
        low, high = self.bounds
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not math.isfinite(value) or not low <= value <= high:
            raise UsageError(
                f"{self.name} of effect {effect!r} is {value!r}",
                f"a number from {low:g} to {high:g} [{self.unit}]: {self.meaning}",
                f"Plausible values lie between {self.plausible[0]:g} and {self.plausible[1]:g}.",
                parameter=self.name,
                value=value,
            )
        return float(value)

    def is_plausible(self, value: float) -> bool:
        """Whether a fitted value lies within the plausible range."""
        return self.plausible[0] <= value <= self.plausible[1]

    def beyond(self, value: float) -> float:
        """Distance of a value from the plausible range stretched by ``FARTHER`` away from 0; 0 within it."""
        low, high = self.plausible
        return max(min(low, FARTHER * low) - value, value - max(high, FARTHER * high), 0.0)

    def log_prior(self, value: float) -> float:
        """Logarithm of the prior density of a value, up to a constant; minus infinity out of bounds."""
        if not self.bounds[0] <= value <= self.bounds[1]:
            return -math.inf
        if self.null is None or self.deviation is None:
            return 0.0
        return -0.5 * ((value - self.null) / self.deviation) ** 2


def strength(
    name: str, unit: str, meaning: str, *, bounds: Interval, plausible: Interval, deviation: float, source: str,
    grid: tuple[float, ...] = (),
) -> Parameter:  # fmt: skip
    """Return a parameter that says how strong an effect is; at its null, 0, the effect is absent.

    Parameters
    ----------
    name, unit, meaning : str
        As in `Parameter`.
    bounds, plausible : (low, high)
        As in `Parameter`; both hold 0.
    deviation : float
        Standard deviation of the normal prior about 0, in the unit of the parameter.
    source : str
        Where the plausible range comes from.
    grid : tuple of float
        Sizes that a screen tries where the effect acts from a threshold on; empty where it grows in proportion.
    """
    return Parameter(
        name, unit, meaning, null=0.0, default=0.0, bounds=bounds, plausible=plausible, deviation=deviation,
        source=source, grid=grid,
    )  # fmt: skip


def shape(
    name: str, unit: str, meaning: str, *, default: float, bounds: Interval, grid: tuple[float, ...], source: str
) -> Parameter:
    """Return a parameter that says what form an effect has; where every strength is null it changes nothing.

    Parameters
    ----------
    name, unit, meaning : str
        As in `Parameter`.
    default : float
        Value where none is given.
    bounds : (low, high)
        Values that a setting may hold; they count as plausible, too.
    grid : tuple of float
        Values that a screen tries.
    source : str
        Where the bounds come from.
    """
    return Parameter(
        name, unit, meaning, null=None, default=default, bounds=bounds, plausible=bounds, deviation=None,
        source=source, grid=grid,
    )  # fmt: skip

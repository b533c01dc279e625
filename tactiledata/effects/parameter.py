"""A parameter of an effect: what it means, in which unit, and what of it can be believed."""

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
    "1/m^2": (-2, 0, 0),
    "N": (0, 1, 0),
    "N m": (1, 1, 0),
    "N/m": (-1, 1, 0),
    "m/N": (1, -1, 0),
    "1/N": (0, -1, 0),
    "N/rad": (0, 1, 0),
    "rad/(N m)": (-1, -1, 0),
    "Pa": (-2, 1, 0),
    "J/m^2": (-1, 1, 0),
    "kg": (-1, 1, 2),
    "kg m": (0, 1, 2),
}
"""Units that parameters have, as exponents of length, force and time; another unit is added here."""

FARTHER = 2.0
"""Times the end of a plausible range: ranges are estimates, and what is a tenth beyond is no proof of another cause."""
Interval = tuple[float, float]


@dataclass(frozen=True)
class Parameter:
    """A number that an effect needs; made by `strength` or `shape`.

    Parameters
    ----------
    name, unit, meaning : str
        The unit is one of ``DIMENSIONS``.
    null : float, optional
        Where the effect is absent. ``None`` for a shape parameter, which alone changes nothing.
    default : float
        What it is where nobody says it; the null of a strength.
    bounds : (low, high)
        What a fit may try, and a setting may hold.
    plausible : (low, high)
        What can be believed on such a rig; a fit outside names another cause.
    deviation : float, optional
        Standard deviation of the normal prior about the null, of a strength; a shape's prior is flat within its bounds.
    source : str
        Where the plausible range comes from; an estimate of ours says so.
    grid : tuple of float
        Values of a shape that a screen tries; of a strength that acts from a threshold on, sizes at which it looks.
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
        """The value, where it is a number within the bounds.

        Raises
        ------
        UsageError
            It is not.
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
        """Whether a fitted value can be believed."""
        return self.plausible[0] <= value <= self.plausible[1]

    def beyond(self, value: float) -> float:
        """By how much a value lies farther from nothing than ``FARTHER`` times what is plausible, or 0."""
        low, high = self.plausible
        return max(min(low, FARTHER * low) - value, value - max(high, FARTHER * high), 0.0)

    def log_prior(self, value: float) -> float:
        """Logarithm of the prior density, up to a constant."""
        if not self.bounds[0] <= value <= self.bounds[1]:
            return -math.inf
        if self.null is None or self.deviation is None:
            return 0.0
        return -0.5 * ((value - self.null) / self.deviation) ** 2


def strength(
    name: str, unit: str, meaning: str, *, bounds: Interval, plausible: Interval, deviation: float, source: str,
    grid: tuple[float, ...] = (),
) -> Parameter:  # fmt: skip
    """How strong an effect is; at its null value, 0, the effect is absent."""
    return Parameter(name, unit, meaning, 0.0, 0.0, bounds, plausible, deviation, source, grid)


def shape(
    name: str, unit: str, meaning: str, *, default: float, bounds: Interval, grid: tuple[float, ...], source: str
) -> Parameter:
    """What form an effect has; without strength it changes nothing."""
    return Parameter(name, unit, meaning, None, default, bounds, bounds, None, source, grid)

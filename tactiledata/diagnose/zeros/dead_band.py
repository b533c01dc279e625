"""Whether a force sensor reads small loads as zero: how often each number occurs among its readings.

Noise and moves bring every small load into the readings. A sensor with a dead-band reads 0 in place of them: 0 occurs
far too often, and on both sides of it numbers are missing. No force of a gel, and no error of a simulation, does that.
The readings are those of the log, in the sensor's own frame: an offset or a rotation would hide the band.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tactiledata.arrays import Array
from tactiledata.diagnose.residuals.residuals import joined_names
from tactiledata.diagnose.residuals.wording import percent, quantity
from tactiledata.diagnose.zeros.coarse_steps import DIGITS, step_of

AXES = ("fx", "fy", "fz", "tx", "ty", "tz")
"""Components of a wrench."""
KINDS: Mapping[str, tuple[str, slice]] = {"force": ("N", slice(0, 3)), "torque": ("N m", slice(3, 6))}
"""Unit and components of forces and of torques."""
FEWEST_BESIDE = 100
"""Fewest readings on either side beyond a gap."""
EMPTY = 0.5
"""Largest density of readings in a gap, as a share of that beyond it. About one centre it is never below 1 on both
sides."""
CROWDED = 0.25
"""Least number of zeros, as a share of the readings that the density beyond the gap would put in its place."""
FEW = 0.01
"""Share of the density beyond a gap below which the readings in it are strays, not a border."""
FEWEST_AXES = 2
"""Fewest components of one kind that must show a dead-band; one alone may be broken otherwise."""
MISSING = 1.5
"""Least border of a gap over the distance between numbers beyond it. Numbers of a sensor with steps are one step apart
at 0 as elsewhere: at two steps one is missing on either side."""
WIDTHS = 60
"""Widths that are tried, at even distances of their logarithm."""


@dataclass(frozen=True)
class DeadBand:
    """Load on an axis below which a force sensor reads 0.

    Parameters
    ----------
    band : dict, kind -> N or N m
        Half width of the dead-band of ``"force"`` and ``"torque"``, for the kinds that show one.
    axes : tuple of str
        Components that show it.
    zeros : float
        Share of the readings of these components that are exactly 0.
    """

    band: Mapping[str, float]
    axes: tuple[str, ...]
    zeros: float

    @property
    def force(self) -> float:
        """Half width, N, of the dead-band of forces; 0 where they show none."""
        return self.band.get("force", 0.0)

    @property
    def words(self) -> str:
        """What was found, as sentences for the user."""
        widths = joined_names([f"{quantity(self.band[kind], KINDS[kind][0])} ({kind})" for kind in self.band])
        return (
            f"The force sensor reads small loads as 0, up to {widths}: {percent(self.zeros)} of the readings of"
            f" {joined_names(self.axes)} are exactly 0, and the numbers beside 0 are missing. Small forces are lost."
            " Switch the dead-band of the sensor or its driver off."
        )

    @property
    def document(self) -> dict[str, object]:
        """The dead-band as it stands in ``diagnosis.json`` (schemas/diagnosis.json)."""
        return {"effect": "quantisation", "values": {**self.band, "zeros": self.zeros}, "words": self.words}


def find_dead_band(readings: Sequence[Array]) -> DeadBand | None:
    """Return the dead-band that readings of a force sensor show; ``None`` where they show none.

    Parameters
    ----------
    readings : sequence of (m, 6) N, N m
        Readings of each trajectory as they were logged, sensor's frame; readings that are not finite are left out.
    """
    rows = np.concatenate([*readings, np.empty((0, 6))])
    rows = rows[np.isfinite(rows).all(axis=1)]
    bands, axes = {}, []
    for kind, (_, columns) in KINDS.items():
        of_axes = {
            name: band
            for name, column in zip(AXES[columns], rows[:, columns].T, strict=True)
            if (band := _band_of(column)) is not None
        }
        if len(of_axes) >= FEWEST_AXES:
            bands[kind] = float(np.median(list(of_axes.values())))
            axes += list(of_axes)
    if not bands:
        return None
    shown = rows[:, [AXES.index(name) for name in axes]]
    return DeadBand(bands, tuple(axes), float((shown == 0).mean()))


def _band_of(column: Array) -> float | None:
    """Return the half width of the gap about 0 in one component (m,), in its unit; ``None`` where there is none.

    A gap of half width b is emptier than the numbers from b to 2 b on either side, and zeros stand in for what is
    missing in it. Of the widths for which that is so, the one with the emptiest gap is taken. The half width that is
    returned is the size of the smallest readings, strays left out. It has to be wider than numbers beyond it are apart.
    """
    count = int((column == 0).sum())
    # a load that rests is one reading, however long it rests: it would be a lump in place of a density
    is_new = np.concatenate([np.ones(min(len(column), 1), dtype=bool), np.diff(column) != 0])
    sides = np.sort(-column[is_new & (column < 0)]), np.sort(column[is_new & (column > 0)])
    smallest = np.sort(np.concatenate(sides))
    if count < FEWEST_BESIDE or min(map(len, sides)) < FEWEST_BESIDE:
        return None
    step = step_of(column[is_new])
    # the narrowest gap ends below the smallest reading
    widths = np.geomspace(max(smallest[0] - step, step), np.quantile(smallest, 0.9), WIDTHS)
    if step > 0:
        # borders halfway between two numbers of the sensor
        widths = step * (np.unique(np.maximum(np.floor(widths / step), 1)) + 0.5)
    within, beyond = np.array([_between(sides, low * widths, (low + 1) * widths) for low in (0, 1)])
    # readings for each unit of the component beyond the gap, and how much of that there is in the gap
    density = beyond.mean(axis=0) / widths
    shares = np.where(beyond.min(axis=0) < FEWEST_BESIDE, np.inf, (within / np.maximum(beyond, 1)).max(axis=0))
    is_gap = (shares <= EMPTY) & (count >= CROWDED * 2.0 * density * widths)
    if not is_gap.any():
        return None
    best = int(np.argmin(np.where(is_gap, shares, np.inf)))
    is_border = np.arange(1, len(smallest) + 1) > FEW * 2.0 * density[best] * smallest
    border = float(smallest[np.argmax(is_border)])
    numbers = np.unique(np.round(smallest[(smallest >= border) & (smallest <= 3.0 * border)], DIGITS))
    is_missing = len(numbers) > 1 and border >= MISSING * np.median(np.diff(numbers))
    return border if is_missing else None


def _between(sides: tuple[Array, Array], low: Array, high: Array) -> Array:
    """Return how many readings below and above 0 lie between two sizes (w,), low excluded: (2, w).

    Parameters
    ----------
    sides : two arrays
        Sizes of the readings below 0 and of those above, ascending.
    low, high : (w,)
        Sizes, in the unit of the component.
    """
    return np.array([np.searchsorted(sizes, high, "right") - np.searchsorted(sizes, low, "right") for sizes in sides])

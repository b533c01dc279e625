"""Where the excess of squared residuals sits: shares by component, phase, rate, depth, indenter, sensor and time.

A description, not a test: it says where to look once another test has found that there is something.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tactiledata.arrays import Array, Mask
from tactiledata.diagnose.residuals.instruments import MOST_LEVELS
from tactiledata.diagnose.residuals.projection import ProjectedResiduals
from tactiledata.diagnose.residuals.residuals import Residuals
from tactiledata.diagnose.residuals.wording import percent, quantity

MOST_CONDITIONS = 3
FEWEST_GAIN = 0.03
"""By how much a further condition must sharpen a statement."""
BOOTSTRAPS = 400
TOGETHER = (("fx", "fy"), ("tx", "ty"), ("fx", "fy", "fz"), ("tx", "ty", "tz"))
"""Components that are one thing to whoever reads."""


@dataclass(frozen=True)
class Cell:
    """A condition on frames or components, or several of them.

    Parameters
    ----------
    words : str
    factors : names of what it speaks of
    share : float
        Of the excess that lies in it.
    interval : (low, high)
        95 %, by a bootstrap over trajectories for this very cell.
    of_values : float
        Share of all values that lies in it: what an even spread would give.
    """

    words: str
    factors: tuple[str, ...]
    share: float
    interval: tuple[float, float]
    of_values: float


@dataclass(frozen=True)
class EnergyShares:
    """The excess and its shares.

    Parameters
    ----------
    excess : float
        Mean square of the residual, less 1 for the noise and less what fits have taken.
    cells : tuple of Cell
        Every single condition, by factor.
    sharpest : Cell, optional
        The conjunction of conditions that holds much of the excess in few values; ``None`` without excess.
    words : str
    """

    excess: float
    cells: tuple[Cell, ...]
    sharpest: Cell | None
    words: str

    @property
    def is_uneven(self) -> bool:
        """Whether the sharpest cell surely holds more than an even spread would put there, and that by a margin: it is
        the sharpest of many.
        """
        return self.sharpest is not None and self.sharpest.interval[0] > self.sharpest.of_values + FEWEST_GAIN


@dataclass(frozen=True)
class _Condition:
    factor: str
    words: str
    frames: Mask  # (n,)
    columns: Mask  # (k,)


def energy_shares(projection: ProjectedResiduals, noise: float = 1.0, seed: int = 0) -> EnergyShares:
    """Shares of the excess over ``noise`` (the variance of a value, 0 where it is not known) after the refit."""
    residuals = projection.residuals
    square = projection.left * projection.score - noise
    total = float(square.sum())
    size = square.size
    if total <= 0:
        return EnergyShares(total / size, (), None, "The residual is no larger than the noise.")
    resamples = _resamples(residuals, seed)
    if noise > 0 and np.quantile(resamples @ residuals.by_unit(square.sum(axis=1)), 0.025) <= 0:
        return EnergyShares(total / size, (), None, "The residual is hardly larger than the noise.")
    conditions = list(_conditions(residuals))

    def cell(chosen: tuple[_Condition, ...]) -> Cell:
        frames, columns = _all(chosen, residuals)
        inside = np.where(frames, square[:, columns].sum(axis=1), 0.0)
        sums = residuals.by_unit(np.column_stack([inside, square.sum(axis=1)]))
        drawn = resamples @ sums
        shares = drawn[:, 0] / np.where(drawn[:, 1] > 0, drawn[:, 1], np.nan)
        low, high = np.nanquantile(shares, [0.025, 0.975])
        return Cell(
            _joined(chosen),
            tuple(one.factor for one in chosen),
            float(inside.sum()) / total,
            (float(low), float(high)),
            float(frames.sum() * columns.sum()) / size,
        )

    sharpest = cell(_sharpest(conditions, square, residuals)) if conditions else None
    what = "excess" if noise > 0 else "squared residual"
    found = EnergyShares(
        total / size, tuple(cell((one,)) for one in conditions), sharpest,
        f"No part of the data surely holds more of the {what} than an even spread would put there.",
    )  # fmt: skip
    if sharpest is not None and found.is_uneven:
        # where others hold less than noise, a cell may hold more than the whole
        share, low, high = (percent(min(end, 1.0)) for end in (sharpest.share, *sharpest.interval))
        part = f"all of the {what}" if low == "100 %" else f"{share} ({low} to {high}) of the {what}"
        words = f"{part} sits in {sharpest.words}, which is {percent(sharpest.of_values)} of the values"
        return replace(found, words=words)
    return found


def _sharpest(conditions: list[_Condition], square: Array, residuals: Residuals) -> tuple[_Condition, ...]:
    """Greedily, the conjunction whose share of the excess most exceeds its share of the values."""
    total, size = float(square.sum()), square.size
    chosen: tuple[_Condition, ...] = ()
    reached = 0.0
    for _ in range(MOST_CONDITIONS):
        best, best_gain = None, reached + FEWEST_GAIN
        for one in conditions:
            if one.factor in {other.factor for other in chosen}:
                continue
            frames, columns = _all((*chosen, one), residuals)
            share = float(square[np.ix_(frames, columns)].sum()) / total
            gain = share - float(frames.sum() * columns.sum()) / size
            if gain > best_gain:
                best, best_gain = one, gain
        if best is None:
            break
        chosen, reached = (*chosen, best), best_gain
    return chosen


def _all(chosen: tuple[_Condition, ...], residuals: Residuals) -> tuple[Mask, Mask]:
    frames: Mask = np.ones(len(residuals.values), dtype=bool)
    columns: Mask = np.ones(len(residuals.components), dtype=bool)
    for one in chosen:
        frames, columns = frames & one.frames, columns & one.columns
    return frames, columns


def _conditions(residuals: Residuals) -> Iterator[_Condition]:
    every: Mask = np.ones(len(residuals.values), dtype=bool)
    names = residuals.components
    for together in (*((name,) for name in names), *TOGETHER):
        columns = np.isin(names, together)
        if columns.sum() == len(together) and not columns.all():
            yield _Condition("component", ", ".join(together), every, columns)
    both: Mask = np.ones(len(names), dtype=bool)
    for label, texts in residuals.labels.items():
        levels = np.unique(texts)
        if 2 <= len(levels) <= MOST_LEVELS:
            for level in levels:
                yield _Condition(label, f"{label} {level}", texts == level, both)
    for name, covariate in residuals.covariates.items():
        low, high = np.quantile(covariate.values, [1 / 3, 2 / 3])
        if not covariate.values.min() < low < high < covariate.values.max():
            continue
        parts = {
            f"{name} below {quantity(low, covariate.unit)}": covariate.values <= low,
            f"{name} from {quantity(low, covariate.unit)} to {quantity(high, covariate.unit)}": (
                (covariate.values > low) & (covariate.values <= high)
            ),
            f"{name} above {quantity(high, covariate.unit)}": covariate.values > high,
        }
        for words, frames in parts.items():
            yield _Condition(name, words, frames, both)


def _joined(chosen: tuple[_Condition, ...]) -> str:
    order = sorted(chosen, key=lambda one: one.factor != "component")
    return ", ".join(one.words for one in order) if order else "all values alike"


def _resamples(residuals: Residuals, seed: int) -> Array:
    """How often each unit of exchange is drawn (b, u)."""
    units = residuals.unit_count
    rng = np.random.default_rng(seed)
    return rng.multinomial(units, np.full(units, 1.0 / units), size=BOOTSTRAPS).astype(np.float64)

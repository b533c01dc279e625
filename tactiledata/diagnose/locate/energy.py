"""Which data hold the excess of squared residuals: shares by component, phase, rate, depth, indenter, sensor and time.

This is a description, not a test: it says where to look once a test has found structure.
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
"""Most conditions of the sharpest cell."""
LEAST_GAIN = 0.03
"""Least gain in share by a further condition, and least margin by which an uneven cell exceeds an even spread."""
BOOTSTRAPS = 400
"""Bootstrap samples of the interval of a share."""
TOGETHER = (("fx", "fy"), ("tx", "ty"), ("fx", "fy", "fz"), ("tx", "ty", "tz"))
"""Components that are also considered together: shear force, tilting torque, force and torque."""


@dataclass(frozen=True)
class Cell:
    """A part of the data, given by one or several conditions on frames or components, and its share of the excess.

    Parameters
    ----------
    words : str
        The conditions in words.
    factors : tuple of str
        Covariate, label or ``"component"`` of each condition.
    share : float
        Share of the excess in the cell; above 1 where the rest holds less than noise.
    interval : (low, high)
        95 % interval of the share, by a bootstrap over units of exchange.
    of_values : float
        Share of all values that lie in the cell: the share of the excess under an even spread.
    """

    words: str
    factors: tuple[str, ...]
    share: float
    interval: tuple[float, float]
    of_values: float


@dataclass(frozen=True)
class EnergyShares:
    """The excess of the squared residual over the noise, and its shares in parts of the data.

    Parameters
    ----------
    excess : float
        Mean square of the residual after the refit, minus the noise variance (1, or 0 where it is not known).
    cells : tuple of Cell
        One cell for every single condition.
    sharpest : Cell, optional
        The conjunction of conditions that holds much of the excess in few values; ``None`` without excess.
    words : str
        The result as a clause or sentence.
    """

    excess: float
    cells: tuple[Cell, ...]
    sharpest: Cell | None
    words: str

    @property
    def is_uneven(self) -> bool:
        """Whether the lower end of the sharpest cell's interval exceeds an even spread by more than `LEAST_GAIN`.

        The margin allows for the cell having been selected among many.
        """
        return self.sharpest is not None and self.sharpest.interval[0] > self.sharpest.of_values + LEAST_GAIN


@dataclass(frozen=True)
class _Condition:
    """A condition on frames and components; ``factor`` is its covariate or label, or ``"component"``."""

    factor: str
    words: str
    frames: Mask  # (n,)
    columns: Mask  # (k,)


def energy_shares(projection: ProjectedResiduals, noise: float = 1.0, seed: int = 0) -> EnergyShares:
    """Return shares of the excess of the squared residual over the noise, after the refit.

    Parameters
    ----------
    projection : ProjectedResiduals
        Residuals after the refit.
    noise : float
        Variance of one whitened value by noise: 1, or 0 where the noise is not known.
    seed : int
        Random seed of the bootstrap.
    """
    # without an excess, or with one whose interval includes 0, there are no shares
    residuals = projection.residuals
    square = projection.left * projection.score - noise
    total = float(square.sum())
    size = square.size
    if total <= 0:
        return EnergyShares(total / size, (), None, "The residual is no larger than the noise.")
    resamples = _resamples(residuals, seed)
    if noise > 0 and np.quantile(resamples @ residuals.by_unit(square.sum(axis=1)), 0.025) <= 0:
        return EnergyShares(total / size, (), None, "The residual is not significantly larger than the noise.")
    conditions = list(_conditions(residuals))

    def cell(chosen: tuple[_Condition, ...]) -> Cell:
        """The cell of a conjunction of conditions."""
        frames, columns = _all(chosen, residuals)
        inside = np.where(frames, square[:, columns].sum(axis=1), 0.0)
        sums = residuals.by_unit(np.column_stack([inside, square.sum(axis=1)]))
        drawn = resamples @ sums
        shares = drawn[:, 0] / np.where(drawn[:, 1] > 0, drawn[:, 1], np.nan)
        low, high = np.nanquantile(shares, [0.025, 0.975])
        return Cell(
            _joined(chosen),
            tuple(condition.factor for condition in chosen),
            float(inside.sum()) / total,
            (float(low), float(high)),
            float(frames.sum() * columns.sum()) / size,
        )

    sharpest = cell(_sharpest(conditions, square, residuals)) if conditions else None
    what = "excess" if noise > 0 else "squared residual"
    result = EnergyShares(
        total / size, tuple(cell((condition,)) for condition in conditions), sharpest,
        f"No part of the data surely holds more of the {what} than an even spread would put there.",
    )  # fmt: skip
    if sharpest is not None and result.is_uneven:
        # a share exceeds 1 where the rest of the data holds less than noise
        share, low, high = (percent(min(end, 1.0)) for end in (sharpest.share, *sharpest.interval))
        part = f"all of the {what}" if low == "100 %" else f"{share} ({low} to {high}) of the {what}"
        words = f"{part} lies in {sharpest.words}, which is {percent(sharpest.of_values)} of the values"
        return replace(result, words=words)
    return result


def _sharpest(conditions: list[_Condition], square: Array, residuals: Residuals) -> tuple[_Condition, ...]:
    """Return the conjunction whose share of the excess most exceeds its share of the values, by a greedy search.

    Parameters
    ----------
    conditions : list of _Condition
        The conditions that may be combined, at most one for each factor.
    square : (n, k)
        Excess of each value.
    residuals : Residuals
        Shapes of frames and components.
    """
    total, size = float(square.sum()), square.size
    chosen: tuple[_Condition, ...] = ()
    reached = 0.0
    for _ in range(MOST_CONDITIONS):
        best, best_gain = None, reached + LEAST_GAIN
        for condition in conditions:
            if condition.factor in {other.factor for other in chosen}:
                continue
            frames, columns = _all((*chosen, condition), residuals)
            share = float(square[np.ix_(frames, columns)].sum()) / total
            gain = share - float(frames.sum() * columns.sum()) / size
            if gain > best_gain:
                best, best_gain = condition, gain
        if best is None:
            break
        chosen, reached = (*chosen, best), best_gain
    return chosen


def _all(chosen: tuple[_Condition, ...], residuals: Residuals) -> tuple[Mask, Mask]:
    """Return masks of the frames (n,) and components (k,) that meet all chosen conditions."""
    frames: Mask = np.ones(len(residuals.values), dtype=bool)
    columns: Mask = np.ones(len(residuals.components), dtype=bool)
    for condition in chosen:
        frames, columns = frames & condition.frames, columns & condition.columns
    return frames, columns


def _conditions(residuals: Residuals) -> Iterator[_Condition]:
    """Return every single condition: components, levels of labels, and thirds of covariates."""
    all_frames: Mask = np.ones(len(residuals.values), dtype=bool)
    # single components and groups of them, then levels of labels, then thirds of covariates
    names = residuals.components
    for group in (*((name,) for name in names), *TOGETHER):
        columns = np.isin(names, group)
        if columns.sum() == len(group) and not columns.all():
            yield _Condition("component", ", ".join(group), all_frames, columns)
    all_components: Mask = np.ones(len(names), dtype=bool)
    for label, texts in residuals.labels.items():
        levels = np.unique(texts)
        if 2 <= len(levels) <= MOST_LEVELS:
            for level in levels:
                yield _Condition(label, f"{label} {level}", texts == level, all_components)
    for name, covariate in residuals.covariates.items():
        low, high = np.quantile(covariate.values, [1 / 3, 2 / 3])
        if not covariate.values.min() < low < high < covariate.values.max():
            continue
        lower, upper = quantity(low, covariate.unit), quantity(high, covariate.unit)
        parts = {
            f"{name} below {lower}": covariate.values <= low,
            f"{name} about {lower}" if lower == upper else f"{name} from {lower} to {upper}": (
                (covariate.values > low) & (covariate.values <= high)
            ),
            f"{name} above {upper}": covariate.values > high,
        }
        for words, frames in parts.items():
            yield _Condition(name, words, frames, all_components)


def _joined(chosen: tuple[_Condition, ...]) -> str:
    """Return the conditions in words, components first."""
    order = sorted(chosen, key=lambda condition: condition.factor != "component")
    return ", ".join(condition.words for condition in order) if order else "all values alike"


def _resamples(residuals: Residuals, seed: int) -> Array:
    """Return the number of times (b, u) that each unit of exchange is drawn in each of b bootstrap samples."""
    units = residuals.unit_count
    rng = np.random.default_rng(seed)
    return rng.multinomial(units, np.full(units, 1.0 / units), size=BOOTSTRAPS).astype(np.float64)

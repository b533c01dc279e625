"""A table of predictions and observations as residuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.contract.wording import counted
from tactiledata.diagnose.locate.free_air import in_contact
from tactiledata.diagnose.residuals.instruments import MOST_LEVELS
from tactiledata.diagnose.residuals.residuals import FEWEST_UNITS, Covariate, ResidualParameter, Residuals
from tactiledata.diagnose.residuals.wording import quantity
from tactiledata.diagnose.table_input.columns import Columns, columns_of, is_text
from tactiledata.diagnose.table_input.held_steps import times_since_steps
from tactiledata.errors import TactileDataError

FAR = 30.0
"""Times the median distance from the median: 20 standard deviations of a normal distribution."""
MOST_STRAYS = 0.02
"""Share of the rows; more are no strays."""
MOST_ROWS = 20_000
"""More rows of the same groups cost time and tell little."""
LARGEST, SMALLEST = 1e30, 1e-30
"""Of numbers, and of a noise; what lies beyond is a slip, and squares of it cannot be computed with."""
SMALLEST_SPREAD = 0.2
"""Least range of a prediction, over the scatter about it, with which a scale is told from an offset."""
MOST_MISSING = 0.2
"""Share of rows without it from which on a covariate is left out rather than the rows."""


@dataclass(frozen=True)
class Table:
    """What was read.

    Parameters
    ----------
    columns : Columns
    residuals : Residuals
        Over the noise, or over their own scatter where the noise is not known.
    is_noise_known : bool
    notes : what was left out, in words
    """

    columns: Columns
    residuals: Residuals
    is_noise_known: bool
    notes: tuple[str, ...]


def residuals_of(frame: pd.DataFrame, document: dict[str, Any] | None = None, group: str | None = None) -> Table:
    """Residuals of a table; see docs/diagnose-table.md for what its columns are called.

    Each quantity has two parameters, its offset and its scale, so that a prediction that is only off by a constant or a
    factor is said to be that.

    Raises
    ------
    UsageError
        Columns that are not there.
    TactileDataError
        Too few groups, or nothing that could be diagnosed.
    """
    columns = columns_of(frame, document, group)
    notes: list[str] = []
    rows = _without_strays(_whole_rows(frame, columns, notes), columns, notes)
    groups = _group_numbers(rows[columns.group])
    time = columns.covariates[columns.time][0] if columns.time else None
    order = np.lexsort((rows[time].to_numpy(dtype=float), groups)) if time else np.argsort(groups, kind="stable")
    rows, groups = _thinned(rows.iloc[order], groups[order], notes)
    _enough_groups(rows[columns.group], columns.group)
    covariates = _covariates(rows, columns, notes)
    covariates.setdefault("index", Covariate(groups.astype(np.float64), "1"))
    starts = np.flatnonzero(np.diff(groups, prepend=-1) != 0)
    covariates = times_since_steps(covariates, starts, columns.time) | covariates
    observed, predicted, noise = _quantities(rows, columns)
    is_known = all(one.noise is not None for one in columns.quantities)
    scatter = _own_scatter(observed, predicted, columns)
    if not is_known:
        noise = np.broadcast_to(scatter, observed.shape)
    parameters, slopes = _offset_and_scale(columns, observed, predicted, scatter, noise, notes)
    residuals = Residuals(
        (observed - predicted) / noise,
        tuple(one.name for one in columns.quantities),
        groups,
        covariates,
        _labels(rows, columns, notes),
        parameters,
        slopes,
        units=tuple(one.unit for one in columns.quantities),
        deviations=np.median(noise, axis=0),
        scale="times the noise" if is_known else "times the scatter",
    )
    if not in_contact(residuals).any():
        raise TactileDataError(
            "phase says of no row that something touches", "rows in contact, where prediction and observation differ",
            "Rename or drop the column if it means something else.",
        )  # fmt: skip
    return Table(columns, residuals, is_known, tuple(notes))


def _whole_rows(frame: pd.DataFrame, columns: Columns, notes: list[str]) -> pd.DataFrame:
    """Rows in which everything that counts is known."""
    needed = [column for one in columns.quantities for column in (one.observed, one.predicted)]
    needed += [one.noise for one in columns.quantities if isinstance(one.noise, str)]
    wanted = [column for column, _ in columns.covariates.values()]
    for column in (*needed, *wanted):
        if is_text(frame[column]):
            texts = frame[column][pd.to_numeric(frame[column], errors="coerce").isna()].dropna()
            example = f", as {str(texts.iloc[0])!r}" if len(texts) else ""
            raise TactileDataError(f"column {column} holds what is no number{example}", "numbers", "Mend or drop it.")
    numbers = frame[[*needed, *wanted]].astype(np.float64)
    numbers = numbers.where(numbers.abs() < LARGEST)
    missing = numbers[wanted].isna().mean()
    sparse = [column for column in wanted if missing[column] > MOST_MISSING and column != columns.time]
    kept = numbers.drop(columns=sparse).notna().all(axis=1) & frame[columns.group].notna()
    for column in sparse:
        share = f"{100 * missing[column]:.0f} %"
        notes.append(f"column {column} is left out: {share} of its rows are empty, or beyond {LARGEST:g}")
    if not kept.all():
        gaps = [column for column in [*needed, *wanted] if column not in sparse and numbers[column].isna().any()]
        gaps += [columns.group] if frame[columns.group].isna().any() else []
        where = f"empty, or beyond {LARGEST:g}, in {', '.join(gaps)}"
        notes.append(f"{counted(int((~kept).sum()), 'row')} of {len(kept)} left out: {where}")
        if not kept.any():
            raise TactileDataError(
                f"no row is whole: {where}", "group, observed, predicted and covariates in one row",
                "Fill the gaps, drop a column, or write numbers in larger units.",
            )  # fmt: skip
    return frame.loc[kept]


def _without_strays(rows: pd.DataFrame, columns: Columns, notes: list[str]) -> pd.DataFrame:
    """Rows without those, where they are few, that lie so far off that no law of the rest could be seen beside them."""
    stray = pd.Series(False, index=rows.index)
    for one in columns.quantities:
        left = rows[one.observed] - rows[one.predicted]
        apart = (left - left.median()).abs()
        stray |= (apart > FAR * apart.median()) & (apart.median() > 0)
    if not 0 < stray.mean() <= MOST_STRAYS:
        return rows
    first = ", ".join(str(number) for number in rows.index[stray][:5])
    notes.append(
        f"{counted(int(stray.sum()), 'row')} left out: observed minus predicted lies more than {FAR:.0f} times as far "
        f"from its median as it usually does (first: {first}, counted from 0)"
    )
    return rows[~stray]


def _thinned(rows: pd.DataFrame, groups: NDArray[np.int64], notes: list[str]) -> tuple[pd.DataFrame, NDArray[np.int64]]:
    """Every so many-th row of each group, where there are more than serve a test of whole groups."""
    every = -(-len(rows) // MOST_ROWS)
    if every == 1:
        return rows, groups
    starts = np.flatnonzero(np.diff(groups, prepend=-1) != 0)
    place = np.arange(len(groups)) - np.repeat(starts, np.diff(starts, append=len(groups)))
    kept = place % every == 0
    notes.append(f"one row of {every} of each group is used: {int(kept.sum())} of {len(rows)}")
    return rows.loc[kept], groups[kept]


def _group_numbers(column: pd.Series) -> NDArray[np.int64]:
    """Groups by number, in the order in which they appear."""
    try:
        return pd.factorize(column)[0].astype(np.int64)
    except TypeError as error:
        raise TactileDataError(
            f"column {column.name} holds lists or tables", "one number or text a row", "Name another column of groups."
        ) from error


def _enough_groups(column: pd.Series, name: str) -> None:
    count = column.nunique()
    if count < FEWEST_UNITS:
        found = f"one group only ({column.iloc[0]})" if count == 1 else f"{count} groups only"
        raise TactileDataError(
            f"{found} in column {name}",
            f"at least {FEWEST_UNITS}: whole groups are exchanged to tell structure from chance, never single rows",
            "Take the column that says which rows were recorded in one go (--group), or record more of them.",
            groups=count,
        )


def _covariates(rows: pd.DataFrame, columns: Columns, notes: list[str]) -> dict[str, Covariate]:
    covariates, constant = {}, []
    for name, (column, unit) in columns.covariates.items():
        values = rows[column].to_numpy(dtype=np.float64)
        if not (np.abs(values) < LARGEST).all():
            continue
        if np.ptp(values) > 0:
            covariates[name] = Covariate(values, unit)
        else:
            constant.append(column)
    if constant:
        notes.append(f"left out, as they never change: {', '.join(constant)}")
    return covariates


def _labels(rows: pd.DataFrame, columns: Columns, notes: list[str]) -> dict[str, NDArray[np.str_]]:
    labels = {}
    for name in columns.labels:
        known = rows[name].astype(object).where(rows[name].notna(), "unknown")
        texts = np.array([_printable(str(one)) for one in known], dtype=str)
        if len(np.unique(texts)) <= MOST_LEVELS:
            labels[name] = texts
        else:
            notes.append(f"column {name} is left out: more than {MOST_LEVELS} different texts")
    return labels


def _printable(text: str) -> str:
    return "".join(one if one.isprintable() else "\N{REPLACEMENT CHARACTER}" for one in text)


def _quantities(rows: pd.DataFrame, columns: Columns) -> tuple[Array, Array, Array]:
    """Observed, predicted and noise (n, k); the noise is 1 where it is not known."""
    observed, predicted, noise = (np.ones((len(rows), len(columns.quantities))) for _ in range(3))
    for place, one in enumerate(columns.quantities):
        observed[:, place], predicted[:, place] = rows[one.observed], rows[one.predicted]
        if np.ptp(observed[:, place]) == 0:
            raise TactileDataError(
                f"column {one.observed} is {observed[0, place]:g} in every row", "an observation that varies",
                "Is the instrument connected? Leave the column out, or take other rows.",
            )  # fmt: skip
        if one.noise is not None:
            noise[:, place] = rows[one.noise] if isinstance(one.noise, str) else one.noise
        if not (noise[:, place] > SMALLEST).all():
            bad = noise[:, place][~(noise[:, place] > SMALLEST)][0]
            raise TactileDataError(
                f"the noise of {one.name} ({one.noise}) is {bad:g} somewhere",
                f"standard deviations above {SMALLEST:g}",
                "Mend the column, or leave the noise out: its size is then taken from the scatter.",
            )  # fmt: skip
    return observed, predicted, noise


def _own_scatter(observed: Array, predicted: Array, columns: Columns) -> Array:
    """Standard deviation (k,) of what an offset and a scale leave."""
    scatter = np.empty(observed.shape[1])
    for place, one in enumerate(columns.quantities):
        line = np.column_stack([np.ones(len(predicted)), predicted[:, place]])
        left = observed[:, place] - line @ np.linalg.lstsq(line, observed[:, place], rcond=None)[0]
        scatter[place] = np.sqrt(np.mean(left**2))
        if scatter[place] <= 1e-9 * np.std(observed[:, place]):
            raise TactileDataError(
                f"{one.predicted} gives {one.observed} exactly, up to an offset and a factor", "residuals that vary",
                "There is nothing to diagnose; is one column a copy of the other?",
            )  # fmt: skip
    return scatter


def _offset_and_scale(
    columns: Columns, observed: Array, predicted: Array, scatter: Array, noise: Array, notes: list[str]
) -> tuple[tuple[ResidualParameter, ...], Array]:
    parameters, slopes = [], []
    for place, one in enumerate(columns.quantities):
        has_scale = _tells_scale(observed[:, place], predicted[:, place], float(scatter[place]))
        if not has_scale:
            notes.append(
                f"scale and offset of {one.name} cannot be told apart from these data: its prediction varies by "
                f"{quantity(float(np.std(predicted[:, place])), one.unit)}, and observations scatter by "
                f"{quantity(float(scatter[place]), one.unit)} about it; only the offset is asked"
            )
        for name, field, value in (("offset", np.ones(len(predicted)), np.nan), ("scale", predicted[:, place], 1.0)):
            if name == "scale" and not has_scale:
                continue
            slope = np.zeros_like(predicted)
            slope[:, place] = field / noise[:, place]
            slopes.append(slope)
            parameters.append(
                ResidualParameter(f"the {name} of {one.name}", one.unit if name == "offset" else "1", value)
            )
    return tuple(parameters), np.stack(slopes, axis=2)


def _tells_scale(observed: Array, predicted: Array, scatter: float) -> bool:
    """Whether a prediction tells its scale from an offset: it varies enough, or explains most of the observation."""
    spread = float(np.std(predicted))
    is_followed = scatter**2 < 0.5 * float(np.var(observed))
    return spread > 0 and (is_followed or spread > SMALLEST_SPREAD * scatter)

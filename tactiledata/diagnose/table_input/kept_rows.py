"""Rows of a table that are used: without gaps, outliers and repeats, and thinned where there are very many."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactiledata.contract.wording import counted
from tactiledata.diagnose.table_input.columns import Columns, is_text
from tactiledata.errors import TactileDataError

FAR = 30.0
"""Distance of an outlier from the median, in median distances: 20 standard deviations of a normal distribution."""
MOST_STRAYS = 0.02
"""Largest share of the rows that are removed as outliers; if there are more, all rows are kept."""
MOST_ROWS = 20_000
"""Rows above which groups are thinned: more rows of the same groups cost time and add little information."""
MOST_MISSING = 0.2
"""Largest share of rows that a covariate may lack; above it the covariate is left out, not the rows."""
LARGEST = 1e30
"""Largest number that is accepted: squares of values beyond would overflow."""


def whole_rows(frame: pd.DataFrame, columns: Columns, notes: list[str]) -> pd.DataFrame:
    """Return the rows whose group, quantities and covariates are finite numbers; a sparse covariate is left out.

    Parameters
    ----------
    frame : DataFrame
        The table as it was read.
    columns : Columns
        Meaning of each column.
    notes : list of str
        Takes a sentence on what is left out.
    """
    needed = [column for pair in columns.quantities for column in (pair.observed, pair.predicted)]
    needed += [pair.noise for pair in columns.quantities if isinstance(pair.noise, str)]
    optional = [column for column, _ in columns.covariates.values()]
    for column in (*needed, *optional):
        if is_text(frame[column]):
            texts = frame[column][pd.to_numeric(frame[column], errors="coerce").isna()].dropna()
            example = f", such as {str(texts.iloc[0])!r}" if len(texts) else ""
            raise TactileDataError(f"column {column} holds texts{example}", "numbers", "Correct or drop the column.")
    # a covariate that many rows lack is dropped; rows with other gaps are dropped
    numbers = frame[[*needed, *optional]].astype(np.float64)
    numbers = numbers.where(numbers.abs() < LARGEST)
    missing = numbers[optional].isna().mean()
    sparse = [column for column in optional if missing[column] > MOST_MISSING and column != columns.time]
    kept = numbers.drop(columns=sparse).notna().all(axis=1) & frame[columns.group].notna()
    for column in sparse:
        share = f"{100 * missing[column]:.0f} %"
        notes.append(f"column {column} is left out: {share} of its rows are empty, or beyond {LARGEST:g}")
    if not kept.all():
        gaps = [column for column in [*needed, *optional] if column not in sparse and numbers[column].isna().any()]
        gaps += [columns.group] if frame[columns.group].isna().any() else []
        where = f"empty, or beyond {LARGEST:g}, in {', '.join(gaps)}"
        notes.append(f"{counted(int((~kept).sum()), 'row')} of {len(kept)} left out: {where}")
        if not kept.any():
            raise TactileDataError(
                f"no row is complete: {where}", "group, observed, predicted and covariates in one row",
                "Fill the gaps, drop a column, or write numbers in larger units.",
            )  # fmt: skip
    return frame.loc[kept]


def without_strays(rows: pd.DataFrame, columns: Columns, notes: list[str]) -> pd.DataFrame:
    """Return the rows without outliers, which would dominate every statistic; all rows where outliers are not rare.

    Parameters
    ----------
    rows : DataFrame
        Rows of the table.
    columns : Columns
        Meaning of each column.
    notes : list of str
        Takes a sentence on what is left out.
    """
    is_stray = pd.Series(False, index=rows.index)
    for pair in columns.quantities:
        difference = rows[pair.observed] - rows[pair.predicted]
        distance = (difference - difference.median()).abs()
        is_stray |= (distance > FAR * distance.median()) & (distance.median() > 0)
    if not 0 < is_stray.mean() <= MOST_STRAYS:
        return rows
    first = ", ".join(str(number) for number in rows.index[is_stray][:5])
    notes.append(
        f"{counted(int(is_stray.sum()), 'row')} left out: the distance of observed minus predicted from its median is "
        f"more than {FAR:.0f} times the median distance (first: {first}, counted from 0)"
    )
    return rows[~is_stray]


def without_repeats(
    rows: pd.DataFrame, groups: NDArray[np.int64], columns: Columns, notes: list[str]
) -> tuple[pd.DataFrame, NDArray[np.int64]]:
    """Return the rows, each once, and their groups, where a time tells a row that stands twice from an equal reading.

    Twice the same row is no second reading: it would halve the scatter from row to row, to which the gap is measured.

    Parameters
    ----------
    rows : DataFrame
        Rows of the table.
    groups : (n,) int
        Number of the group of each row.
    columns : Columns
        Meaning of each column.
    notes : list of str
        Takes a sentence on what is left out.
    """
    times = rows[columns.covariates[columns.time][0]] if columns.time else pd.Series(0.0, index=rows.index)
    if times.nunique() < 2:
        return rows, groups
    said = [pair.observed for pair in columns.quantities] + [pair.predicted for pair in columns.quantities]
    values = rows[said].to_numpy(dtype=np.float64)
    keys = np.column_stack([groups, times.to_numpy(dtype=np.float64, na_value=np.nan), values])
    is_repeat = pd.DataFrame(keys).duplicated().to_numpy()
    if is_repeat.any():
        n_repeats = int(is_repeat.sum())
        notes.append(
            f"{counted(n_repeats, 'row')} of {len(rows)} left out: another row of the group has the same time, "
            "observations and predictions"
        )
    return rows.loc[~is_repeat], groups[~is_repeat]


def thinned(rows: pd.DataFrame, groups: NDArray[np.int64], notes: list[str]) -> tuple[pd.DataFrame, NDArray[np.int64]]:
    """Return evenly spaced rows of each group, its first one included, where there are more than `MOST_ROWS` rows.

    Parameters
    ----------
    rows : DataFrame
        Rows of the table, in order of groups.
    groups : (n,) int
        Number of the group of each row.
    notes : list of str
        Takes a sentence on what is left out.
    """
    stride = -(-len(rows) // MOST_ROWS)
    if stride == 1:
        return rows, groups
    starts = np.flatnonzero(np.diff(groups, prepend=-1) != 0)
    place = np.arange(len(groups)) - np.repeat(starts, np.diff(starts, append=len(groups)))
    kept = place % stride == 0
    notes.append(f"one row of {stride} of each group is used: {int(kept.sum())} of {len(rows)}")
    return rows.loc[kept], groups[kept]

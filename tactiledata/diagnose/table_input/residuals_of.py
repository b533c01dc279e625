"""A table of predictions and observations as whitened residuals, each quantity with an offset and a scale."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactiledata.arrays import Array
from tactiledata.diagnose.locate.free_air import in_contact
from tactiledata.diagnose.residuals.instruments import MOST_LEVELS
from tactiledata.diagnose.residuals.residuals import FEWEST_UNITS, Covariate, ResidualParameter, Residuals
from tactiledata.diagnose.residuals.wording import quantity
from tactiledata.diagnose.table_input.columns import Columns, columns_of
from tactiledata.diagnose.table_input.held_steps import times_since_steps
from tactiledata.diagnose.table_input.kept_rows import LARGEST, thinned, whole_rows, without_repeats, without_strays
from tactiledata.errors import TactileDataError

SMALLEST = 1e-30
"""Smallest noise that is accepted: the square of a smaller one would underflow."""
SMALLEST_SPREAD = 0.2
"""Least standard deviation of a prediction, over the scatter about it, that separates a scale from an offset."""


@dataclass(frozen=True)
class Table:
    """A table as residuals, with the meaning of its columns and notes on what was left out.

    Parameters
    ----------
    columns : Columns
        Meaning of each column.
    residuals : Residuals
        Observed minus predicted, divided by the noise, or by the scatter where the noise is not known.
    is_noise_known : bool
        Whether the noise of every quantity is known.
    notes : tuple of str
        What was left out and why, in sentences without full stop.
    """

    columns: Columns
    residuals: Residuals
    is_noise_known: bool
    notes: tuple[str, ...]


def residuals_of(frame: pd.DataFrame, document: dict[str, Any] | None = None, group: str | None = None) -> Table:
    """Return whitened residuals of a table of observations and predictions; docs/diagnose-table.md has the names.

    Each quantity has two parameters, an offset and a scale, so that a prediction that is wrong by a constant or a
    factor is recognised as a matter of calibration.

    Parameters
    ----------
    frame : DataFrame
        One row for each frame.
    document : dict, optional
        Meaning of the columns as in schemas/columns.json, already checked; without it the names decide.
    group : str, optional
        Name of the column of groups; it takes precedence over the document.

    Raises
    ------
    UsageError
        A column does not exist or has two meanings.
    TactileDataError
        There are too few groups, or the table holds nothing that could be diagnosed.
    """
    # rows: without gaps and outliers, in order of groups and time, thinned where there are very many
    columns = columns_of(frame, document, group)
    notes: list[str] = []
    rows = without_strays(whole_rows(frame, columns, notes), columns, notes)
    rows, groups = without_repeats(rows, _group_numbers(rows[columns.group]), columns, notes)
    time = columns.covariates[columns.time][0] if columns.time else None
    if time and not (np.abs(rows[time].to_numpy(dtype=float, na_value=np.nan)) < LARGEST).all():
        time = None
    order = np.lexsort((rows[time].to_numpy(dtype=float), groups)) if time else np.argsort(groups, kind="stable")
    rows, groups = thinned(rows.iloc[order], groups[order], notes)
    _enough_groups(rows[columns.group], columns.group)
    # covariates, also the number of the group and the time since steps of a held covariate
    covariates = _covariates(rows, columns, notes)
    if columns.time not in covariates:
        columns = replace(columns, time=None)
    covariates.setdefault("index", Covariate(groups.astype(np.float64), "1"))
    starts = np.flatnonzero(np.diff(groups, prepend=-1) != 0)
    covariates = times_since_steps(covariates, starts, columns.time) | covariates
    # whiten by the noise, or by the scatter about the best line where the noise of a quantity is not known
    observed, predicted, noise = _quantities(rows, columns)
    is_known = all(pair.noise is not None for pair in columns.quantities)
    scatter = _own_scatter(observed, predicted, columns)
    if not is_known:
        noise = np.broadcast_to(scatter, observed.shape)
    parameters, slopes = _offset_and_scale(columns, observed, predicted, scatter, noise, notes)
    residuals = Residuals(
        (observed - predicted) / noise,
        tuple(pair.name for pair in columns.quantities),
        groups,
        covariates,
        _labels(rows, columns, notes),
        parameters,
        slopes,
        units=tuple(pair.unit for pair in columns.quantities),
        deviations=np.median(noise, axis=0),
        scale="times the noise" if is_known else "times the scatter",
    )
    if not in_contact(residuals).any():
        raise TactileDataError(
            "in column phase no row is in contact", "rows in contact, where prediction and observation differ",
            "Rename or drop the column if it means something else.",
        )  # fmt: skip
    return Table(columns, residuals, is_known, tuple(notes))


def _group_numbers(column: pd.Series) -> NDArray[np.int64]:
    """Return the number (n,) of each row's group, in the order in which groups appear; refuse cells that are lists."""
    try:
        return pd.factorize(column)[0].astype(np.int64)
    except TypeError as error:
        raise TactileDataError(
            f"column {column.name} holds lists or tables",
            "one number or text in each row",
            "Name another column of groups.",
        ) from error


def _enough_groups(column: pd.Series, name: str) -> None:
    """Refuse a table with fewer than `FEWEST_UNITS` groups."""
    count = column.nunique()
    if count < FEWEST_UNITS:
        found = f"one group only ({column.iloc[0]})" if count == 1 else f"{count} groups only"
        raise TactileDataError(
            f"{found} in column {name}",
            f"at least {FEWEST_UNITS}: the tests compare whole groups, never single rows",
            "Name the column that says which rows were recorded in one go (--group), or record more groups.",
            groups=count,
        )


def _covariates(rows: pd.DataFrame, columns: Columns, notes: list[str]) -> dict[str, Covariate]:
    """Return the covariates that are complete and vary; a note names those that never change."""
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
    """Return the labels with at most `MOST_LEVELS` different texts; empty cells are "unknown"."""
    labels = {}
    for name in columns.labels:
        known = rows[name].astype(object).where(rows[name].notna(), "unknown")
        texts = np.array([_printable(str(text)) for text in known], dtype=str)
        if len(np.unique(texts)) <= MOST_LEVELS:
            labels[name] = texts
        else:
            notes.append(f"column {name} is left out: more than {MOST_LEVELS} different texts")
    return labels


def _printable(text: str) -> str:
    """Return the text with a replacement character for each one that cannot be printed, as in escape sequences."""
    return "".join(character if character.isprintable() else "\N{REPLACEMENT CHARACTER}" for character in text)


def _quantities(rows: pd.DataFrame, columns: Columns) -> tuple[Array, Array, Array]:
    """Return observed, predicted and noise (n, k) in the quantities' units; the noise is 1 where it is not known.

    A constant observation and a noise that is not positive are refused.
    """
    observed, predicted, noise = (np.ones((len(rows), len(columns.quantities))) for _ in range(3))
    for place, pair in enumerate(columns.quantities):
        observed[:, place], predicted[:, place] = rows[pair.observed], rows[pair.predicted]
        spread = float(np.ptp(observed[:, place]))
        if spread == 0:
            raise TactileDataError(
                f"column {pair.observed} is {observed[0, place]:g} in every row", "an observation that varies",
                "Is the instrument connected? Leave the column out, or use other rows.",
            )  # fmt: skip
        if spread <= SMALLEST:
            raise TactileDataError(
                f"column {pair.observed} varies by {spread:.3g} only",
                f"an observation that varies by more than {SMALLEST:g}: the square of less is rounded to 0",
                "Give observation and prediction in a smaller unit.",
            )
        if pair.noise is not None:
            noise[:, place] = rows[pair.noise] if isinstance(pair.noise, str) else pair.noise
        if not (noise[:, place] > SMALLEST).all():
            bad = noise[:, place][~(noise[:, place] > SMALLEST)][0]
            raise TactileDataError(
                f"the noise of {pair.name} ({pair.noise}) is {bad:g} somewhere",
                f"standard deviations above {SMALLEST:g}",
                "Correct the column, or leave the noise out: it is then estimated from the scatter.",
            )  # fmt: skip
    return observed, predicted, noise


def _own_scatter(observed: Array, predicted: Array, columns: Columns) -> Array:
    """Return the root mean square (k,) of each quantity's residual from an offset and a scale; refuse exact copies."""
    scatter = np.empty(observed.shape[1])
    for place, pair in enumerate(columns.quantities):
        line = np.column_stack([np.ones(len(predicted)), predicted[:, place]])
        difference = observed[:, place] - line @ np.linalg.lstsq(line, observed[:, place], rcond=None)[0]
        scatter[place] = np.sqrt(np.mean(difference**2))
        if scatter[place] <= 1e-9 * np.std(observed[:, place]):
            raise TactileDataError(
                f"{pair.predicted} gives {pair.observed} exactly, up to an offset and a factor", "residuals that vary",
                "There is nothing to diagnose. Is one column a copy of the other?",
            )  # fmt: skip
    return scatter


def _offset_and_scale(
    columns: Columns, observed: Array, predicted: Array, scatter: Array, noise: Array, notes: list[str]
) -> tuple[tuple[ResidualParameter, ...], Array]:
    """Return offset and scale of each quantity as parameters, with whitened sensitivities (n, k, p).

    Parameters
    ----------
    columns : Columns
        The k quantities and their units.
    observed, predicted : (n, k)
        Values in the quantities' units.
    scatter : (k,)
        Root mean square of what offset and scale leave.
    noise : (n, k)
        Standard deviation by which residuals are divided.
    notes : list of str
        Receives a note for each quantity whose scale cannot be separated from its offset.
    """
    parameters, slopes = [], []
    for place, pair in enumerate(columns.quantities):
        has_scale = _tells_scale(observed[:, place], predicted[:, place], float(scatter[place]))
        if not has_scale:
            notes.append(
                f"scale and offset of {pair.name} cannot be separated with these data: its prediction varies by "
                f"{quantity(float(np.std(predicted[:, place])), pair.unit)}, and observations scatter by "
                f"{quantity(float(scatter[place]), pair.unit)} about it; only the offset is estimated"
            )
        for name, field, value in (("offset", np.ones(len(predicted)), np.nan), ("scale", predicted[:, place], 1.0)):
            if name == "scale" and not has_scale:
                continue
            slope = np.zeros_like(predicted)
            slope[:, place] = field / noise[:, place]
            slopes.append(slope)
            parameters.append(
                ResidualParameter(f"the {name} of {pair.name}", pair.unit if name == "offset" else "1", value)
            )
    return tuple(parameters), np.stack(slopes, axis=2)


def _tells_scale(observed: Array, predicted: Array, scatter: float) -> bool:
    """Return whether the data separate a scale from an offset: the prediction varies or explains enough.

    Parameters
    ----------
    observed, predicted : (n,)
        Values of one quantity.
    scatter : float
        Root mean square of what offset and scale leave.
    """
    spread = float(np.std(predicted))
    is_followed = scatter**2 < 0.5 * float(np.var(observed))
    return spread > 0 and (is_followed or spread > SMALLEST_SPREAD * scatter)

"""The meaning of a table's columns, from a document or from their names: ``"speed_mm_per_s"`` is speed in mm/s."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from tactiledata.diagnose.residuals.dimensions import find_unit
from tactiledata.errors import TactileDataError, UnknownName, UsageError

FORCES, LENGTHS = ("N", "mN", "uN", "kN"), ("m", "mm", "cm", "um")
"""A force unit followed by a length unit is a torque, not a quotient."""


def split_unit(column: str) -> tuple[str, str]:
    """Return name and unit of a column: ``"depth_mm"`` is depth in mm, ``"speed_mm_per_s"`` speed in mm/s.

    A unit after ``per`` divides: ``"rate_per_s"`` is in 1/s, ``"k_N_m_per_rad"`` in N m/rad. Without ``per`` the second
    of two adjacent units divides, except in a force times a length, as in ``N_m`` and ``N_mm``. An ending that is no
    unit belongs to the name, and the unit is ``"?"``.
    """
    parts = column.split("_")
    for position in range(1, len(parts)):
        unit = _chained(parts[position:])
        if unit is not None and find_unit(unit) is not None:
            return "_".join(parts[:position]), unit
    return column, "?"


def _chained(words: Sequence[str]) -> str | None:
    """Return the unit text of adjacent words, such as ``"N m/rad"``; ``None`` where they cannot be one."""
    if "deg" in words[:-1] and words[words.index("deg") + 1] == "C":
        place = words.index("deg")
        words = [*words[:place], "degC", *words[place + 2 :]]
    if words[-1] == "per" or any(word[:1].isdigit() or not word for word in words):
        return None
    chained, divides, before = "", False, ""
    for word in words:
        if word == "per":
            divides, chained = True, chained or "1"
            continue
        is_product = not divides and (not before or _is_product(before, word, "per" in words))
        chained += word if not chained else f" {word}" if is_product else f"/{word}"
        before = word
    return chained


def _is_product(before: str, word: str, is_per: bool) -> bool:
    """Return whether a unit multiplies the one before it: in a torque, with a negative power, or after ``per``."""
    return is_per or "-" in word or (before in FORCES and word in LENGTHS)


TIMES = ("time", "t", "seconds")
"""Names of covariates that are taken for the time."""
GROUP_NAMES = ("group", "trajectory", "trial")
"""Names of columns that are taken for the group."""
OBSERVED, PREDICTED, NOISE = "observed", "predicted", "noise"
"""Words in a column's name that give it a role."""
PAGE = "docs/diagnose-table.md shows both ways of naming columns."
"""Remedy of errors that concern the names of columns."""


@dataclass(frozen=True)
class Quantity:
    """A quantity that was both observed and predicted, such as a force component.

    Parameters
    ----------
    name, unit : str
        Name and unit in sentences; the unit is ``"?"`` where it is not known.
    observed, predicted : str
        Names of the two columns.
    noise : float or str, optional
        Standard deviation of the observation in ``unit``: a number or a column's name; ``None`` where it is not known.
    """

    name: str
    unit: str
    observed: str
    predicted: str
    noise: float | str | None = None


@dataclass(frozen=True)
class Columns:
    """The meaning of each column of a table.

    Parameters
    ----------
    group : str
        Column that says which rows were recorded together.
    quantities : tuple of Quantity
        What was observed and predicted; each becomes a component of the residuals.
    covariates : dict, name -> (column, unit)
        Numbers that the residuals may depend on.
    labels : tuple of str
        Columns of texts that the residuals may depend on.
    time : str, optional
        The covariate that is the time inside a group.
    order : str
        The covariate along which steps between groups are sought; ``"index"`` is the order of appearance.
    plane : (str, str)
        The two covariates over which a map is drawn.
    scales : dict, covariate -> float
        Reference value of a covariate in formulas, in the covariate's unit.
    noise_correlation : float, optional
        Correlation of the noise of neighbouring rows of a group; ``None`` where it is not known.
    """

    group: str
    quantities: tuple[Quantity, ...]
    covariates: dict[str, tuple[str, str]]
    labels: tuple[str, ...]
    time: str | None = None
    order: str = "index"
    plane: tuple[str, str] = ("x", "y")
    scales: dict[str, float] = field(default_factory=dict)
    noise_correlation: float | None = None


def columns_of(frame: pd.DataFrame, document: Mapping[str, Any] | None = None, group: str | None = None) -> Columns:
    """Return the meaning of each column of a table, from a document or else from the columns' names.

    Parameters
    ----------
    frame : DataFrame
        The table; only names and types of its columns are used, and texts where numbers are expected.
    document : mapping, optional
        Meaning of the columns as in schemas/columns.json, already checked; without it the names decide.
    group : str, optional
        Name of the column of groups; it takes precedence over the document.

    Raises
    ------
    UsageError
        A column does not exist (similar names are listed), has two meanings, or no column is observed and predicted.
    TactileDataError
        A column whose name states a unit holds texts.
    """
    names = [str(name) for name in frame.columns]
    if document is not None:
        return _from_document(names, frame, document, group)
    # columns with a role; what is left is a label or a covariate
    grouped = _group(names, group)
    quantities = _quantities(names)
    _each_once(grouped, quantities, [])
    used = {grouped} | {
        column for quantity in quantities for column in (quantity.observed, quantity.predicted, quantity.noise)
    }
    left = [name for name in names if name not in used]
    labels = tuple(name for name in left if is_text(frame[name]))
    for name in labels:
        _no_number(frame[name])
    covariates = {}
    for column in left:
        if column not in labels:
            name, unit = split_unit(column)
            covariates[column if name in covariates else name] = (column, unit)
    time = next((name for name in covariates if name in TIMES), None)
    return Columns(grouped, quantities, covariates, labels, time)


def _no_number(column: pd.Series) -> None:
    """Refuse texts in a column that is the time or whose name states a unit: as a label its numbers would be lost.

    Raises
    ------
    TactileDataError
        Such a column holds a text.
    """
    bare, unit = split_unit(str(column.name))
    texts = column[pd.to_numeric(column, errors="coerce").isna()].dropna()
    if len(texts) and (unit != "?" or bare in TIMES):
        raise TactileDataError(
            f"column {column.name} holds a text, {str(texts.iloc[0])!r}",
            "numbers" if unit == "?" else f"numbers in {unit}", "Correct this cell, or rename the column.",
        )  # fmt: skip


def is_text(column: pd.Series) -> bool:
    """Return whether a column holds texts or booleans rather than numbers."""
    return not pd.api.types.is_numeric_dtype(column) or pd.api.types.is_bool_dtype(column)


def known_column(name: str, names: Sequence[str]) -> str:
    """Return the name itself; refuse a name that no column has.

    Raises
    ------
    UnknownName
        No column has this name; similar ones are listed.
    """
    if name not in names:
        raise UnknownName("column", name, names, PAGE)
    return name


def _group(names: Sequence[str], group: str | None) -> str:
    """Return the column of groups: the one that the user names, else the first of `GROUP_NAMES` that exists."""
    if group is not None:
        return known_column(group, names)
    column = next((name for name in GROUP_NAMES if name in names), None)
    if column is None:
        similar = [similar for name in GROUP_NAMES for similar in difflib.get_close_matches(name, names, n=1)]
        hint = f"Is it {' or '.join(dict.fromkeys(similar))}? " if similar else ""
        raise UsageError(
            f"no column says which rows belong together; the columns are {', '.join(names)}",
            f"a column named {', '.join(GROUP_NAMES)}",
            f"{hint}Name the column with --group COLUMN. Rows that were recorded in one go are one group.",
        )
    return column


def _role(column: str, names: Sequence[str]) -> tuple[str, str, str] | None:
    """Return the quantity, role and unit of a column, from its name; ``None`` for a column without a role.

    The words after the role are the unit: a known unit, or any words with which both observed and predicted end.
    """
    bare, unit = split_unit(column)
    for role in (OBSERVED, PREDICTED, NOISE):
        if bare.endswith(f"_{role}"):
            return bare.removesuffix(f"_{role}"), role, unit
        name, _, ending = column.rpartition(f"_{role}_")
        if name and all(f"{name}_{part}_{ending}" in names for part in (OBSERVED, PREDICTED)):
            return name, role, ending.replace("_", " ")
    return None


def _quantities(names: Sequence[str]) -> tuple[Quantity, ...]:
    """Return the quantities that the columns' names describe; refuse contradictory, incomplete or missing pairs."""
    # quantity -> role -> (column, unit)
    roles_of: dict[str, dict[str, tuple[str, str]]] = {}
    for column in names:
        described = _role(column, names)
        if described is None:
            continue
        name, role, unit = described
        roles = roles_of.setdefault(name, {})
        if role in roles:
            raise UsageError(
                f"{roles[role][0]} and {column} mean the same",
                f"one column that is {role}; the words after it are the unit",
                "Drop or rename one of the two columns.",
            )
        roles[role] = (column, unit)
    # a pair needs both columns, in one unit
    quantities = []
    for name, roles in roles_of.items():
        for role, other in ((OBSERVED, PREDICTED), (PREDICTED, OBSERVED)):
            if role in roles and other not in roles:
                partner = roles[role][0].replace(f"_{role}", f"_{other}")
                known = {column for listed in roles_of.values() for column, _ in listed.values()}
                others = [column for column in names if column not in known]
                raise UnknownName("column", partner, others, f"{roles[role][0]} has no partner. {PAGE}")
        if OBSERVED not in roles:
            continue
        units = {unit for _, unit in roles.values()}
        if len(units) > 1:
            raise UsageError(
                f"{' and '.join(column for column, _ in roles.values())} are in different units", "one unit for both",
                "Convert one of them.",
            )  # fmt: skip
        noise = roles[NOISE][0] if NOISE in roles else None
        quantities.append(Quantity(name, roles[OBSERVED][1], roles[OBSERVED][0], roles[PREDICTED][0], noise))
    if not quantities:
        raise UsageError(
            f"no column is both observed and predicted; the columns are {', '.join(names)}",
            "pairs as fz_observed_N and fz_predicted_N",
            f"Rename the columns, or describe them with --columns. {PAGE}",
        )
    return tuple(quantities)


def _each_once(group: str, quantities: Sequence[Quantity], covariates: Sequence[str]) -> None:
    """Refuse a column that has two meanings among group, quantities and covariates.

    Raises
    ------
    UsageError
        A column has two meanings.
    """
    taken = [group, *covariates]
    for quantity in quantities:
        taken += [quantity.observed, quantity.predicted, *([quantity.noise] if isinstance(quantity.noise, str) else [])]
    twice = [name for name, count in Counter(taken).items() if count > 1 and name not in covariates]
    twice += [name for quantity in quantities for name in (quantity.observed, quantity.predicted) if name in covariates]
    if twice:
        raise UsageError(
            f"column {twice[0]} would mean two things", "one meaning for each column", f"Name another column. {PAGE}"
        )


def _numbers(document: Mapping[str, Any]) -> list[tuple[str, Any]]:
    """Return every number in a columns' document, with its place in words."""
    numbers = [("noise_correlation", document.get("noise_correlation"))]
    numbers += [(f"noise of {name}", entry.get("noise")) for name, entry in document["quantities"].items()]
    numbers += [(f"scale of {name}", entry.get("scale")) for name, entry in document.get("covariates", {}).items()]
    return [(where, number) for where, number in numbers if number is not None and not isinstance(number, str)]


def _is_sane(number: float) -> bool:
    """Return whether a number is 0 or of a size whose square can be computed; False for NaN and infinity."""
    return number == 0 or 1e-30 < abs(number) < 1e30


def _from_document(
    names: Sequence[str], frame: pd.DataFrame, document: Mapping[str, Any], group: str | None
) -> Columns:
    """Return the meaning of the columns as a document states it; refuse columns or covariates that do not exist."""
    quantities = tuple(
        Quantity(
            name,
            entry.get("unit", "?"),
            known_column(entry["observed"], names),
            known_column(entry["predicted"], names),
            known_column(entry["noise"], names) if isinstance(entry.get("noise"), str) else entry.get("noise"),
        )
        for name, entry in document["quantities"].items()
    )
    covariates = {
        name: (known_column(entry["column"], names), entry.get("unit", "?"))
        for name, entry in document.get("covariates", {}).items()
    }
    labels = tuple(known_column(name, names) for name in document.get("labels", ()))
    _each_once(group or document["group"], quantities, [column for column, _ in covariates.values()])
    for where, number in _numbers(document):
        if not _is_sane(number):
            raise UsageError(f"{where} in the columns' document is {number!r:.40}", "a finite number", PAGE)
    # time, order and plane must name covariates
    plane = tuple(document.get("plane", ("x", "y")))
    time, order = document.get("time"), document.get("order", "index")
    for name in (*([time] if time else []), *document.get("plane", ()), *([order] if "order" in document else [])):
        if name not in covariates:
            raise UnknownName("covariate", name, covariates, PAGE)
    return Columns(
        known_column(group or document["group"], names),
        quantities,
        covariates,
        labels,
        time,
        order,
        (plane[0], plane[1]),
        {name: entry["scale"] for name, entry in document.get("covariates", {}).items() if "scale" in entry},
        document.get("noise_correlation"),
    )

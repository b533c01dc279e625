"""Units at the end of a column's name: ``"speed_mm_per_s"`` is speed in mm/s."""

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
"""Side by side they are a torque."""


def split_unit(column: str) -> tuple[str, str]:
    """Name and unit of a column: ``"depth_mm"`` is depth in mm, ``"speed_mm_s"`` and ``"speed_mm_per_s"`` are in mm/s.

    What follows ``per`` divides: ``"rate_per_s"`` is in 1/s, ``"k_N_m_per_rad"`` in N m/rad. Without ``per`` the second
    of two units side by side divides, but in ``N_m`` and ``N_mm``. An ending that is no unit belongs to the name, and
    the unit is ``"?"``.
    """
    parts = column.split("_")
    for position in range(1, len(parts)):
        unit = _chained(parts[position:])
        if unit is not None and find_unit(unit) is not None:
            return "_".join(parts[:position]), unit
    return column, "?"


def _chained(words: Sequence[str]) -> str | None:
    """The unit that words side by side mean, as ``"N m/rad"``; ``None`` where they mean none."""
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
    """Whether a unit beside another one multiplies it: before ``per``, with its own sign, or a force's length."""
    return is_per or "-" in word or (before in FORCES and word in LENGTHS)


TIMES = ("time", "t", "seconds")
GROUP_NAMES = ("group", "trajectory", "trial")
OBSERVED, PREDICTED, NOISE = "observed", "predicted", "noise"
PAGE = "docs/diagnose-table.md shows both ways of naming columns."


@dataclass(frozen=True)
class Quantity:
    """Something that was observed and predicted.

    Parameters
    ----------
    name, unit : str
    observed, predicted : names of columns
    noise : float or str, optional
        Standard deviation of the observation: a number or a column; ``None`` where it is not known.
    """

    name: str
    unit: str
    observed: str
    predicted: str
    noise: float | str | None = None


@dataclass(frozen=True)
class Columns:
    """The meaning of a table's columns.

    Parameters
    ----------
    group : str
    quantities : tuple of Quantity
    covariates : dict, name -> (column, unit)
    labels : columns of texts
    time : str, optional
        The covariate that is the time inside a group.
    order : str
        The covariate along which steps are sought.
    plane : two covariates
    scales : dict, covariate -> float, by which it is measured
    noise_correlation : float, optional
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
    """The columns of a table.

    Parameters
    ----------
    document : mapping, optional
        As in schemas/columns.json, checked; without one the names decide.
    group : str, optional
        The column of groups, where it is named apart.

    Raises
    ------
    UsageError
        A column that is not there (near names are listed), or none that is observed and predicted.
    """
    names = [str(name) for name in frame.columns]
    if document is not None:
        return _from_document(names, frame, document, group)
    grouped = _group(names, group)
    quantities = _quantities(names)
    _each_once(grouped, quantities, [])
    used = {grouped} | {column for one in quantities for column in (one.observed, one.predicted, one.noise)}
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
    """Texts in a column whose name has a unit, or that is the time.

    Raises
    ------
    TactileDataError
        Such a column: taken as names, its numbers would be lost.
    """
    bare, unit = split_unit(str(column.name))
    texts = column[pd.to_numeric(column, errors="coerce").isna()].dropna()
    if len(texts) and (unit != "?" or bare in TIMES):
        raise TactileDataError(
            f"column {column.name} holds what is no number, as {str(texts.iloc[0])!r}",
            "numbers" if unit == "?" else f"numbers in {unit}", "Mend that cell, or rename the column.",
        )  # fmt: skip


def is_text(column: pd.Series) -> bool:
    """Whether a column holds names rather than numbers."""
    return not pd.api.types.is_numeric_dtype(column) or pd.api.types.is_bool_dtype(column)


def known_column(name: str, names: Sequence[str]) -> str:
    """The name, where such a column is there.

    Raises
    ------
    UnknownName
        It is not; near ones are listed.
    """
    if name not in names:
        raise UnknownName("column", name, names, PAGE)
    return name


def _group(names: Sequence[str], group: str | None) -> str:
    if group is not None:
        return known_column(group, names)
    found = next((name for name in GROUP_NAMES if name in names), None)
    if found is None:
        near = [near for name in GROUP_NAMES for near in difflib.get_close_matches(name, names, n=1)]
        hint = f"Is it {' or '.join(dict.fromkeys(near))}? " if near else ""
        raise UsageError(
            f"no column says which rows belong together; the columns are {', '.join(names)}",
            f"one named {', '.join(GROUP_NAMES)}",
            f"{hint}Name it: --group COLUMN. Rows that were recorded in one go are one group.",
        )
    return found


def _role(column: str, names: Sequence[str]) -> tuple[str, str, str] | None:
    """Name of the quantity, role and unit of a column; ``None`` of one that has no role.

    What follows the role is a unit: a known one, or any other where observed and predicted end alike.
    """
    bare, unit = split_unit(column)
    for role in (OBSERVED, PREDICTED, NOISE):
        if bare.endswith(f"_{role}"):
            return bare.removesuffix(f"_{role}"), role, unit
        name, _, ending = column.rpartition(f"_{role}_")
        if name and all(f"{name}_{each}_{ending}" in names for each in (OBSERVED, PREDICTED)):
            return name, role, ending.replace("_", " ")
    return None


def _quantities(names: Sequence[str]) -> tuple[Quantity, ...]:
    found: dict[str, dict[str, tuple[str, str]]] = {}
    for column in names:
        meant = _role(column, names)
        if meant is None:
            continue
        name, role, unit = meant
        roles = found.setdefault(name, {})
        if role in roles:
            raise UsageError(
                f"{roles[role][0]} and {column} mean the same",
                f"one column that is {role}; what follows that word is the unit",
                "Drop or rename one.",
            )
        roles[role] = (column, unit)
    quantities = []
    for name, roles in found.items():
        for role, other in ((OBSERVED, PREDICTED), (PREDICTED, OBSERVED)):
            if role in roles and other not in roles:
                wanted = roles[role][0].replace(f"_{role}", f"_{other}")
                known = {column for each in found.values() for column, _ in each.values()}
                others = [one for one in names if one not in known]
                raise UnknownName("column", wanted, others, f"{roles[role][0]} has no partner. {PAGE}")
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
            f"Rename them, or say what they are with --columns. {PAGE}",
        )
    return tuple(quantities)


def _each_once(group: str, quantities: Sequence[Quantity], covariates: Sequence[str]) -> None:
    """One column has one meaning.

    Raises
    ------
    UsageError
        One has two.
    """
    taken = [group, *covariates]
    for one in quantities:
        taken += [one.observed, one.predicted, *([one.noise] if isinstance(one.noise, str) else [])]
    twice = [name for name, count in Counter(taken).items() if count > 1 and name not in covariates]
    twice += [name for one in quantities for name in (one.observed, one.predicted) if name in covariates]
    if twice:
        raise UsageError(
            f"column {twice[0]} is asked to mean two things", "one meaning a column", f"Name another. {PAGE}"
        )


def _numbers(document: Mapping[str, Any]) -> list[tuple[str, Any]]:
    found = [("noise_correlation", document.get("noise_correlation"))]
    found += [(f"noise of {name}", one.get("noise")) for name, one in document["quantities"].items()]
    found += [(f"scale of {name}", one.get("scale")) for name, one in document.get("covariates", {}).items()]
    return [(where, number) for where, number in found if number is not None and not isinstance(number, str)]


def _is_sane(number: float) -> bool:
    return number == 0 or 1e-30 < abs(number) < 1e30


def _from_document(
    names: Sequence[str], frame: pd.DataFrame, document: Mapping[str, Any], group: str | None
) -> Columns:
    quantities = tuple(
        Quantity(
            name,
            one.get("unit", "?"),
            known_column(one["observed"], names),
            known_column(one["predicted"], names),
            known_column(one["noise"], names) if isinstance(one.get("noise"), str) else one.get("noise"),
        )
        for name, one in document["quantities"].items()
    )
    covariates = {
        name: (known_column(one["column"], names), one.get("unit", "?"))
        for name, one in document.get("covariates", {}).items()
    }
    labels = tuple(known_column(name, names) for name in document.get("labels", ()))
    _each_once(group or document["group"], quantities, [column for column, _ in covariates.values()])
    for where, number in _numbers(document):
        if not _is_sane(number):
            raise UsageError(f"{where} in the columns' document is {number!r:.40}", "a finite number", PAGE)
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
        {name: one["scale"] for name, one in document.get("covariates", {}).items() if "scale" in one},
        document.get("noise_correlation"),
    )

"""Cells of a CSV file as numbers and times: integers exact, what does not read masked rather than guessed.

Shared by all formats, as `base` is: members of the family may import it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from tactiledata.arrays import Mask
from tactiledata.contract.records import Finding, Times, Values
from tactiledata.errors import BrokenLog

SHOWN = 5
"""Faulty lines that a message names."""

_PLAIN_FLOAT = r"^-?\d+(\.\d*)?([eE][+-]?\d{1,3})?$"
_PLAIN_INTEGER = r"^-?\d{1,18}$"
_DECIMAL_POINT = re.compile(r"^\s*[+-]?\d*\.\d*([eE][+-]?\d+)?\s*$|^\s*[+-]?\d+[eE][+-]?\d+\s*$")


@dataclass(frozen=True)
class CsvTable:
    """The cells of a CSV file as text, rows of a wrong length left out and reported.

    Parameters
    ----------
    name : str
        The file's name, for messages.
    columns : tuple of str
        As the header names them, spaces around them removed.
    cells : pa.Table
        (n_rows, n_columns) strings.
    lines : (n_rows,) int64
        Line of each row in the file, blank lines not counted.
    findings : tuple of Finding
        What was wrong with the file as text.
    """

    name: str
    columns: tuple[str, ...]
    cells: pa.Table
    lines: Times
    findings: tuple[Finding, ...] = ()

    def __len__(self) -> int:
        return len(self.lines)

    def text(self, column: str) -> list[str]:
        """The cells of a column, spaces around them removed."""
        return [value.strip() for value in self.cells.column(column).to_pylist()]

    def require(self, columns: Sequence[str], remedy: str = "") -> None:
        """Refuse a table that lacks one of these columns; the `BrokenLog` names the columns that it has."""
        missing = [column for column in columns if column not in self.columns]
        if missing:
            raise BrokenLog(
                f"{self.name} has the columns {listed(self.columns)}; {listed(missing)} missing",
                f"the columns {listed(columns)}, in any order, named in the first line",
                remedy or "Name the columns as `tactiledata formats` lists them.",
                file=self.name,
                columns=list(self.columns),
                missing=missing,
            )

    def numbers(self, columns: Sequence[str]) -> tuple[Values, Mask]:
        """Values (n, k) float64 of columns, and a mask (n,) of the rows in which all of them are finite numbers."""
        values = np.empty((len(self), len(columns)))
        for index, column in enumerate(columns):
            values[:, index] = _cast(self.cells.column(column), pa.float64(), _PLAIN_FLOAT, _float, np.float64(np.nan))[
                0
            ]
        return values, np.asarray(np.isfinite(values).all(axis=1))

    def nanoseconds(self, column: str) -> tuple[Times, Mask]:
        """Times (n,) int64 of a column of integer nanoseconds, exact, and a mask (n,) of the readable ones.

        Raises
        ------
        BrokenLog
            Most cells have a decimal point or an exponent: seconds, or nanoseconds that went through floats.
        """
        cells = self.cells.column(column)
        times, is_readable = _cast(cells, pa.int64(), _PLAIN_INTEGER, _integer, np.int64(0))
        if (~is_readable).sum() * 2 > len(self):
            faulty = [cells[int(row)].as_py() for row in np.flatnonzero(~is_readable)]
            floats = [value for value in faulty if _DECIMAL_POINT.match(value)]
            if len(floats) * 2 > len(self):
                raise BrokenLog(
                    f"{self.name} has the times {listed(floats[:3])} in column {column}",
                    "integer nanoseconds, for example 1700000000123456789",
                    "Write the clock's integer nanoseconds as they are (in Python time.time_ns()): a float of today's "
                    "date keeps them to 256 ns only.",
                    file=self.name,
                    column=column,
                )
        return times, is_readable

    def seconds(self, column: str) -> tuple[Times, Mask]:
        """Times (n,) int64 ns of a column of decimal seconds, never through floats, and a mask of the readable ones."""
        cells = self.cells.column(column)
        try:
            exact = pc.round(pc.cast(cells, pa.decimal128(38, 18)), 9)
            nanoseconds = pc.multiply(pc.cast(exact, pa.decimal128(27, 9)), pa.scalar(10**9, pa.decimal128(10, 0)))
            return np.array(pc.cast(nanoseconds, pa.int64())), np.ones(len(self), bool)
        except pa.ArrowInvalid:
            return _one_by_one(cells, _decimal_nanoseconds, np.int64(0))

    def row_finding(self, code: str, is_faulty: Mask, what: str, stream: str = "") -> list[Finding]:
        """One finding of severity damage about the faulty rows; an empty list where there are none.

        Parameters
        ----------
        code : str
            Code of the finding.
        is_faulty : (n,) bool
            Which rows of the table are faulty.
        what : str
            What is wrong with them, as the message goes on after "3 of 10 rows".
        stream : str
            The stream that the finding is about.
        """
        rows = np.flatnonzero(is_faulty)
        if not len(rows):
            return []
        message = f"{self.name}: {len(rows)} of {len(self)} rows {what} (lines {some_lines(self.lines[rows])})"
        return [Finding(code, "damage", message, stream, count=len(rows))]


def free_values(cells: Iterable[str]) -> list[int | float | str | None]:
    """Cells of a free column as JSON values: integers or floats where all of them are, else text; empty ones ``None``.

    Numbers with leading zeros (``007``) are names and stay text.
    """
    column = [None if cell.lower() in ("", "nan") else cell for cell in cells]
    present = [cell for cell in column if cell is not None]
    read: Callable[[str], Any] = str
    if all(re.fullmatch(r"-?(0|[1-9]\d{0,17})", cell) for cell in present):
        read = int
    elif all(re.fullmatch(r"[+-]?(0|[1-9]\d*)?(\.\d*)?([eE][+-]?\d+)?", cell) and _is_float(cell) for cell in present):
        read = float
    return [None if cell is None else read(cell) for cell in column]


def some_lines(lines: Sequence[int] | Times) -> str:
    """The first few line numbers, for a message."""
    return ", ".join(str(line) for line in lines[:SHOWN]) + (", …" if len(lines) > SHOWN else "")


def listed(names: Iterable[str]) -> str:
    """Names in quotes, for a message."""
    return ", ".join(repr(shortened(name, 40)) for name in names) or "none"


def shortened(text: str, limit: int = 120) -> str:
    """A text, cut where it is too long for a message."""
    return text if len(text) <= limit else text[: limit - 1] + "…"


def _cast(
    cells: pa.ChunkedArray, kind: pa.DataType, pattern: str, read: Callable[[str], Any], fill: Any
) -> tuple[Any, Mask]:
    """All cells at once; where one does not read, those that fit the pattern at once and the others one by one."""
    try:
        return np.array(pc.cast(cells, kind)), np.ones(len(cells), bool)
    except pa.ArrowInvalid:
        is_plain = pc.match_substring_regex(cells, pattern)
    values, is_readable = np.full(len(cells), fill), np.array(is_plain, bool)
    values[is_readable] = np.array(pc.cast(cells.filter(is_plain), kind))
    others = np.flatnonzero(~is_readable)
    values[others], is_readable[others] = _one_by_one(cells.take(others), read, fill)
    return values, is_readable


def _one_by_one(cells: pa.ChunkedArray, read: Callable[[str], Any], fill: Any) -> tuple[Any, Mask]:
    values = np.full(len(cells), fill)
    is_readable = np.zeros(len(cells), bool)
    for row, cell in enumerate(cells.to_pylist()):
        try:
            values[row] = read(cell)
            is_readable[row] = True
        except (ValueError, InvalidOperation, OverflowError):
            continue
    return values, is_readable


def _float(cell: str) -> float:
    if "_" in cell:
        raise ValueError(cell)
    return float(cell)


def _is_float(cell: str) -> bool:
    try:
        return bool(np.isfinite(float(cell)))
    except ValueError:
        return False


def _integer(cell: str) -> int:
    if not re.fullmatch(r"\s*[+-]?\d{1,19}\s*", cell, re.ASCII):
        raise ValueError(cell)
    return int(cell)


def _decimal_nanoseconds(cell: str) -> int:
    if "_" in cell:
        raise ValueError(cell)
    value = Decimal(cell.strip())
    if not value.is_finite() or abs(value) > 10**10:
        raise ValueError(cell)
    return round(value * 10**9)

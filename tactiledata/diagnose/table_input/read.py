"""A CSV, TSV or Parquet file as a data frame; a file that could be misread is refused with the reason."""

from __future__ import annotations

import csv
import os
from collections import Counter
from numbers import Number
from pathlib import Path

import pandas as pd

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.errors import MissingFile, TactileDataError, UsageError

SUFFIXES = (".csv", ".tsv", ".parquet")
"""Endings of file names that are read; upper case is accepted."""
SEPARATORS = {".csv": ",", ".tsv": "\t"}
"""Separator of the fields, by the ending of the file's name."""
GZIP = b"\x1f\x8b"
"""First bytes of a file that gzip compressed."""
LINE_ENDS = (b"\n", b"\r")
BLOCK = 2**20
"""Bytes of a text that are looked at together."""
OTHER_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}
"""Separators that are suspected where a table seems to have one column."""


def read_table(path: Path) -> pd.DataFrame:
    """Return the rows of a CSV, TSV or Parquet file; dates are seconds since the first one, durations seconds.

    Raises
    ------
    MissingFile
        The file does not exist.
    UsageError
        The name does not end as a table's, or belongs to a folder.
    TactileDataError
        The file cannot be read, holds no rows, or names its columns ambiguously.
    """
    if not path.exists():
        raise MissingFile(f"{path} does not exist", f"a table: {', '.join(SUFFIXES)}", path=str(path))
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(f"{path} is in no table format", f"a file that ends in {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise UsageError(f"{path} is a folder or a device", "a file", "Name the table itself.")
    # the libraries' errors become refusals that name the file and a remedy
    refuse_lfs_pointer(path)
    try:
        frame = _parquet(path) if suffix == ".parquet" else _text(path, SEPARATORS[suffix])
    except UnicodeDecodeError as error:
        raise TactileDataError(
            f"{path} holds bytes that are no UTF-8: {error.reason} at {error.start}",
            "text in UTF-8",
            "It is compressed: unpack it." if error.object.startswith(GZIP) else "Save the file as UTF-8.",
        ) from error
    except (ValueError, OSError, csv.Error) as error:
        raise TactileDataError(
            f"{path} cannot be read: {' '.join(str(error).split())}",
            f"a table in {suffix[1:]}",
            "Write the file again.",
        ) from error
    if frame.empty:
        raise TactileDataError(f"{path} holds no rows", "one row for each frame", "Was the file written completely?")
    for name in frame.columns:
        if not str(name).isprintable():
            raise TactileDataError(
                f"the name of column {str(name)!r} holds characters that cannot be printed",
                "printable names",
                "Rename the column.",
            )
    return frame.apply(_as_numbers)


def doubts_of(path: Path) -> tuple[str, ...]:
    """Return a sentence where the last line of a text has no line end: its last number may have been cut.

    Parameters
    ----------
    path : Path
        A table that `read_table` reads.
    """
    with path.open("rb") as file:
        file.seek(-1, os.SEEK_END)
        is_open = path.suffix.lower() in SEPARATORS and file.read(1) not in LINE_ENDS
    if not is_open:
        return ()
    return (f"the last line of {path.name} has no line end: if the file was cut there, its last number is wrong",)


def _text(path: Path, separator: str) -> pd.DataFrame:
    """Return the rows of a text file; refuse an unexpected separator, and rows longer than the header."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        names = next(csv.reader(file, delimiter=separator), [])
    _without_zeros(path)
    _once(names, path)
    if blank := [place for place, name in enumerate(names, start=1) if not name.strip()]:
        raise TactileDataError(f"column {blank[0]} of {path} has no name", "a name for every column",
                               "Name it, or leave it out (pandas: index=False).")  # fmt: skip
    if len(names) == 1:
        for other, words in OTHER_SEPARATORS.items():
            if other in names[0] and other != separator:
                raise TactileDataError(
                    f"{path} has one column, {names[0]!r}: it seems to be separated by {words}",
                    f"{'commas' if separator == ',' else 'tabs'}, as its name says",
                    "Save the table with this separator.",
                )  # fmt: skip
    frame = pd.read_csv(path, sep=separator, encoding="utf-8-sig")
    if not isinstance(frame.index, pd.RangeIndex):
        raise TactileDataError(
            f"rows of {path} have more fields than its header, which names {len(names)}", "a name for every field",
            "Is there a separator at the end of each row, or a column without a name?",
        )  # fmt: skip
    return frame


def _without_zeros(path: Path) -> None:
    """Refuse a text with zero bytes, as a crash leaves them: cells around them would be read as other values."""
    place = 0
    with path.open("rb") as file:
        if file.read(len(GZIP)) == GZIP:
            return  # no text at all: decoding it says what it is
        file.seek(0)
        while block := file.read(BLOCK):
            if b"\0" in block:
                raise TactileDataError(
                    f"{path} holds zero bytes, the first at byte {place + block.index(0)}",
                    "text in UTF-8",
                    "Copy the file again, or write it anew; rows around them may be lost.",
                )
            place += len(block)


def _parquet(path: Path) -> pd.DataFrame:
    """Return the rows of a Parquet file; named levels of its index become columns, as the group may be one of them."""
    from pyarrow import parquet

    _once(parquet.read_schema(path).names, path)
    frame = pd.read_parquet(path)
    return frame.reset_index(drop=all(name is None for name in frame.index.names))


def _once(names: list[str], path: Path) -> None:
    """Refuse a file that names a column twice."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise TactileDataError(
            f"{path} names column {twice[0]!r} twice", "a different name for each column", "Rename one of them."
        )


def _as_numbers(column: pd.Series) -> pd.Series:
    """Return a column of dates, durations (both in seconds) or numeric objects as floats; others unchanged."""
    if pd.api.types.is_datetime64_any_dtype(column):
        column = column - column.min()
    if pd.api.types.is_timedelta64_dtype(column):
        return column.dt.total_seconds()
    known = column.dropna()
    is_number = column.dtype == object and len(known) > 0 and all(
        isinstance(value, Number) and not isinstance(value, bool | complex) for value in known
    )  # fmt: skip
    return pd.to_numeric(column.map(float, na_action="ignore")) if is_number else column

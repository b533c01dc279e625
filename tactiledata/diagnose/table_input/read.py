"""A table from a file of strangers: every column as it stands there, or a refusal."""

from __future__ import annotations

import csv
from collections import Counter
from numbers import Number
from pathlib import Path

import pandas as pd

from tactiledata.contract.lfs_pointer import refuse_lfs_pointer
from tactiledata.errors import MissingFile, TactileDataError, UsageError

SUFFIXES = (".csv", ".tsv", ".parquet")
SEPARATORS = {".csv": ",", ".tsv": "\t"}
GZIP = b"\x1f\x8b"
"""How a compressed file begins."""
OTHER_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}


def read_table(path: Path) -> pd.DataFrame:
    """The rows of a CSV, TSV or Parquet file; moments are seconds since the first one, durations seconds.

    Raises
    ------
    MissingFile, UsageError
        Not there, or no table by its name.
    TactileDataError
        It cannot be read as such, holds no rows, or its columns are not clear.
    """
    if not path.exists():
        raise MissingFile(f"{path} does not exist", f"a table: {', '.join(SUFFIXES)}", path=str(path))
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(f"{path} is no table by its name", f"a file that ends in {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise UsageError(f"{path} is a folder or a device", "a file", "Name the table in it.")
    refuse_lfs_pointer(path)
    try:
        frame = _parquet(path) if suffix == ".parquet" else _text(path, SEPARATORS[suffix])
    except UnicodeDecodeError as error:
        raise TactileDataError(
            f"{path} holds bytes that are no UTF-8: {error.reason} at {error.start}",
            "text in UTF-8",
            "It is compressed: unpack it." if error.object.startswith(GZIP) else "Save it as that.",
        ) from error
    except (ValueError, OSError, csv.Error) as error:
        raise TactileDataError(
            f"{path} cannot be read: {' '.join(str(error).split())}", f"a table in {suffix[1:]}", "Write it anew."
        ) from error
    if frame.empty:
        raise TactileDataError(f"{path} holds no rows", "one row for each frame", "Was it written to its end?")
    for name in frame.columns:
        if not str(name).isprintable():
            raise TactileDataError(
                f"the name of column {str(name)!r} holds characters that cannot be printed", "plain names", "Rename it."
            )
    return frame.apply(_as_numbers)


def _text(path: Path, separator: str) -> pd.DataFrame:
    with path.open(encoding="utf-8-sig", newline="") as file:
        names = next(csv.reader(file, delimiter=separator), [])
    _once(names, path)
    if len(names) == 1:
        for other, words in OTHER_SEPARATORS.items():
            if other in names[0] and other != separator:
                raise TactileDataError(
                    f"{path} has one column, {names[0]!r}: it seems to be separated by {words}",
                    f"{'commas' if separator == ',' else 'tabs'}, as its name says", "Write it so.",
                )  # fmt: skip
    frame = pd.read_csv(path, sep=separator, encoding="utf-8-sig")
    if not isinstance(frame.index, pd.RangeIndex):
        raise TactileDataError(
            f"rows of {path} have more fields than its header, which names {len(names)}", "a name for every field",
            "Is there a separator at the end of each row, or a column without a name?",
        )  # fmt: skip
    return frame


def _parquet(path: Path) -> pd.DataFrame:
    from pyarrow import parquet

    _once(parquet.read_schema(path).names, path)
    frame = pd.read_parquet(path)
    return frame.reset_index(drop=all(name is None for name in frame.index.names))


def _once(names: list[str], path: Path) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise TactileDataError(f"{path} names column {twice[0]!r} twice", "names that differ", "Rename one of them.")


def _as_numbers(column: pd.Series) -> pd.Series:
    """Moments, durations and numbers of other kinds as floats; anything else as it is."""
    if pd.api.types.is_datetime64_any_dtype(column):
        column = column - column.min()
    if pd.api.types.is_timedelta64_dtype(column):
        return column.dt.total_seconds()
    known = column.dropna()
    is_number = column.dtype == object and len(known) > 0 and all(
        isinstance(one, Number) and not isinstance(one, bool | complex) for one in known
    )  # fmt: skip
    return pd.to_numeric(column.map(float, na_action="ignore")) if is_number else column

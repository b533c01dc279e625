"""Tables in CSV files from strangers: read fast, integers exact, every faulty row accounted for.

Shared by all formats, as `base` is: members of the family may import it. A fault of the whole file (a missing column,
another separator, seconds where nanoseconds belong) is a `BrokenLog`; a fault of single rows becomes a `Finding`, and
the rest of the file is read.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv as pacsv

from tactiledata.contract.lfs_pointer import refuse_pointer_bytes
from tactiledata.contract.records import Finding, Severity
from tactiledata.errors import BrokenLog
from tactiledata.formats.reading.csv_cells import CsvTable, listed, shortened, some_lines

BLOCK = 16 * 2**20
"""Bytes that are parsed at once; no line may be longer."""


@dataclass
class _Text:
    """The bytes of a file on their way to a table, and what was noticed."""

    name: str
    stream: str
    body: bytes
    findings: list[Finding] = field(default_factory=list)

    def notice(self, code: str, severity: Severity, message: str, count: int = 1) -> None:
        self.findings.append(Finding(code, severity, f"{self.name}: {message}", self.stream, count=count))


def read_csv_table(path: Path, stream: str = "", separators: str = ",") -> CsvTable:
    """The table in a CSV file.

    A byte order mark, CRLF line ends, quoted cells and blank lines are accepted.

    Parameters
    ----------
    path : Path
    stream : str
        The stream that the findings name.
    separators : str
        Characters that may part the cells, the likeliest first; a blank stands for any run of blanks and tabs.

    Raises
    ------
    BrokenLog
        The file is empty, no text, parted by another character, has no header or names a column twice, or cannot be
        read.
    """
    text = _Text(path.name, stream, _content(path))
    _check_is_text(text)
    text.body = text.body.lstrip(b"\r\n")
    end = re.search(rb"\r\n|\n|\r", text.body)
    header, rest = (text.body, b"") if end is None else (text.body[: end.start()], text.body[end.end() :])
    separator = _separator(text.name, header, separators)
    if separator == " ":
        header, rest = (re.sub(rb"(?m)^ +| +(?=\r?$)", b"", re.sub(rb"[ \t]+", b" ", part)) for part in (header, rest))
    columns = _columns(text.name, header, separator)
    text.body = rest
    cells, total, faulty = _parse(text, columns, separator)
    lines = np.delete(np.arange(2, total + 2, dtype=np.int64), [line - 2 for line in faulty])
    _report_row_lengths(text, faulty, total, len(columns))
    if not len(lines):
        text.notice("csv-no-rows", "warning", "no row can be read" if total else "the table has a header and no rows")
    return CsvTable(text.name, columns, cells, lines, tuple(text.findings))


def _content(path: Path) -> bytes:
    if path.is_symlink() and not path.exists():
        raise BrokenLog(f"{path} is a link to nothing", "a CSV file", "Copy the file that it meant.", file=str(path))
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BrokenLog(
            f"{path} cannot be read ({error.strerror})", "a readable CSV file", "Check its permissions.", file=str(path)
        ) from error
    refuse_pointer_bytes(content, str(path))
    if not content or content.isspace():
        raise BrokenLog(
            f"{path} is empty ({len(content)} bytes)",
            "a CSV file whose first line names its columns",
            "Copy the file again, or delete it if the stream was not recorded.",
            file=str(path),
            is_empty=True,
        )
    return content


def _check_is_text(text: _Text) -> None:
    """Leave UTF-8 without byte order mark in ``text``; other encodings are refused, single bad bytes reported."""
    if text.body.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise BrokenLog(f"{text.name} is UTF-16 text", "UTF-8 text", "Save it as CSV UTF-8.", file=text.name)
    text.body = text.body.removeprefix(b"\xef\xbb\xbf")
    zeros = text.body.count(b"\0")
    if zeros:
        text.notice("csv-zero-bytes", "damage", f"{zeros} zero bytes, as a crash leaves them; left out", zeros)
        text.body = text.body.replace(b"\0", b"")
    if text.body.isascii():
        return
    try:
        text.body.decode()
    except UnicodeDecodeError as error:
        text.notice("csv-encoding", "damage", f"not UTF-8 at byte {error.start}; what cannot be read is shown as �")
        text.body = text.body.decode(errors="replace").encode()


def _separator(name: str, header: bytes, separators: str) -> str:
    first = header.decode()
    for separator in separators:
        if separator in first.strip() or (separator == " " and "\t" in first.strip()):
            return separator
    for other, words in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars"), (",", "commas")):
        if other in first:
            raise BrokenLog(
                f"{name} parts its columns by {words}: {shortened(first)!r}",
                f"columns parted by {' or '.join(repr(separator) for separator in separators)}, and decimal points",
                "Export it again as comma-separated values (in a locale with decimal points).",
                file=name,
            )
    return separators[0]


def _columns(name: str, header: bytes, separator: str) -> tuple[str, ...]:
    columns = tuple(cell.strip() for cell in next(csv.reader([header.decode()], delimiter=separator), []))
    twice = sorted({column for column in columns if columns.count(column) > 1})
    if twice:
        raise BrokenLog(f"{name} names the columns {listed(twice)} twice", "each column once", "Rename one.", file=name)
    return columns


def _parse(text: _Text, columns: tuple[str, ...], separator: str) -> tuple[pa.Table, int, list[int]]:
    """Cells, number of rows in the file, and the lines of the rows of another length."""
    schema = dict.fromkeys(columns, pa.string())
    if not text.body or text.body.isspace():
        return pa.table({column: pa.array([], pa.string()) for column in columns}), 0, []
    if b'"' in text.body:
        return _parse_quoted(text, columns, separator)
    faulty: list[int] = []

    def skip(row: pacsv.InvalidRow) -> str:
        faulty.append(int(row.number) + 1)
        return "skip"

    try:
        cells = pacsv.read_csv(
            pa.py_buffer(text.body),
            # one thread: only then are rows numbered
            read_options=pacsv.ReadOptions(column_names=list(columns), use_threads=False, block_size=BLOCK),
            parse_options=pacsv.ParseOptions(delimiter=separator, quote_char=False, invalid_row_handler=skip),
            convert_options=pacsv.ConvertOptions(column_types=schema, strings_can_be_null=False),
        )
    except pa.ArrowInvalid as error:
        raise BrokenLog(
            f"{text.name} cannot be parsed: {shortened(str(error))}",
            f"lines of at most {BLOCK} bytes",
            "Look at the file in a text editor; it may be another file under this name.",
            file=text.name,
        ) from error
    return cells, len(cells) + len(faulty), faulty


def _parse_quoted(text: _Text, columns: tuple[str, ...], separator: str) -> tuple[pa.Table, int, list[int]]:
    """Parse a table line by line, so that an unbalanced quote costs one row and not the rest of the file."""
    rows: list[list[str]] = []
    faulty: list[int] = []
    lines = [line for line in re.split(r"\r\n|\n|\r", text.body.decode()) if line]
    for number, line in enumerate(lines, start=2):
        try:
            row = next(csv.reader([line], delimiter=separator, strict=True))
        except csv.Error:
            row = []
        if len(row) == len(columns):
            rows.append(row)
        else:
            faulty.append(number)
    by_column = zip(*rows, strict=True) if rows else ([] for _ in columns)
    cells = pa.table({name: pa.array(column, pa.string()) for name, column in zip(columns, by_column, strict=True)})
    return cells, len(lines), faulty


def _report_row_lengths(text: _Text, faulty: list[int], total: int, width: int) -> None:
    is_open = total > 0 and not text.body.endswith((b"\n", b"\r"))
    if is_open and faulty and faulty[-1] == total + 1:
        text.notice("csv-last-line-cut", "damage", f"the last line ({total + 1}) is cut off; the rows before are read")
        faulty = faulty[:-1]
    elif is_open:
        words = "the last line has no line end: it may have been cut within a number; its row is kept where it reads"
        text.notice("csv-last-line-open", "warning", words)
    if faulty:
        message = f"{len(faulty)} of {total} rows do not have {width} cells (lines {some_lines(faulty)}); left out"
        text.notice("csv-row-length", "damage", message, len(faulty))

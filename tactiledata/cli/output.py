"""What commands print: tables and sentences for people, one JSON document for machines."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as ProgressBar
from rich.table import Table

from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.records import Finding

JSON_OPTION = typer.Option(False, "--json", help="One JSON document on standard output, for machines; errors too.")

QUIET_SECONDS = 60.0
"""Longest silence, where progress is printed as lines: the next report after it is printed."""

COLOURS = {"damage": "red", "warning": "yellow", "info": "dim"}


def out() -> Console:
    """The console for results; plain text where it is no terminal."""
    return Console(file=sys.stdout, soft_wrap=not sys.stdout.isatty(), highlight=False)


def err() -> Console:
    """The console for progress and errors."""
    return Console(file=sys.stderr, soft_wrap=not sys.stderr.isatty(), highlight=False)


def say(text: str) -> None:
    """Print a sentence for people."""
    out().print(escape(text))


def emit(document: Any) -> None:
    """Print a result for machines."""
    sys.stdout.write(json.dumps(document, indent=2, ensure_ascii=False, default=str) + "\n")


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Print a table; numbers to the right."""
    listed = [list(row) for row in rows]
    drawn = Table(title=escape(title) if title else None, title_justify="left", box=None, pad_edge=False)
    for position, column in enumerate(columns):
        numeric = bool(listed) and all(isinstance(row[position], int | float) for row in listed)
        drawn.add_column(column, justify="right" if numeric else "left", overflow="fold")
    for row in listed:
        drawn.add_row(*(escape(f"{cell:,}" if isinstance(cell, int) else str(cell)) for cell in row))
    console = out()
    if not console.is_terminal:
        console = Console(file=sys.stdout, width=200, highlight=False)
    console.print(drawn)


def findings(found: Iterable[tuple[str, Finding]], most: int = 40) -> None:
    """Print findings, the worst first, each with where it was met."""
    rank = {"damage": 0, "warning": 1, "info": 2}
    listed = sorted(found, key=lambda item: (rank[item[1].severity], item[1].code, item[0]))
    console = out()
    for where, finding in listed[:most]:
        colour = COLOURS[finding.severity]
        place = f"{where}: " if where else ""
        text = f"{escape(place)}{escape(finding.message)} \\[{finding.code}]"
        console.print(f"  [{colour}]{finding.severity:<7}[/{colour}] {text}")
    if len(listed) > most:
        console.print(f"  … and {len(listed) - most} more (all of them: --json)")


@contextmanager
def progress(title: str, quiet: bool = False) -> Iterator[Progress]:
    """A function to report progress to: a bar on a terminal, a line now and then elsewhere.

    Called with how much is done, how much there is, and what it is at.
    """
    console = err()
    if quiet:
        yield no_progress
        return
    if not console.is_terminal:
        tenths, moment = [-1], [time.monotonic()]

        def line(done: int, total: int, what: str = "") -> None:
            tenth, now = done * 10 // max(total, 1), time.monotonic()
            if tenth != tenths[0] or now - moment[0] > QUIET_SECONDS:
                tenths[0], moment[0] = tenth, now
                console.print(escape(f"{title}: {done}/{total} {what}"))

        yield line
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with ProgressBar(*columns, TextColumn("{task.fields[what]}"), console=console, transient=True) as bar:
        task = bar.add_task(title, total=None, what="")
        yield lambda done, total, what="": bar.update(task, completed=done, total=total, what=escape(what[-40:]))

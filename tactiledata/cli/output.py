"""Printing for commands: tables and sentences for people, one JSON document for machines."""

from __future__ import annotations

import json
import re
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.progress import Progress as ProgressBar
from rich.table import Table

from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.wording import bare_wording, listed

if TYPE_CHECKING:
    from tactiledata.contract.records import Finding

JSON_OPTION = typer.Option(False, "--json", help="Print one JSON document, for machines; errors too.")

TRUTH = "truth"
"""Folder of `tactiledata record` for what its worlds hide."""
QUIET_SECONDS = 60.0
"""Longest silence, in seconds, where progress is printed as lines: the next report after it is printed."""

LEAST_DONE = 0.05
"""Share of the steps that must be done before the time of the others is told from them."""

UNSEEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""Characters that steer a terminal or turn the direction of writing, such as a name in a recording may hold."""

MOST_ALIKE = 2
"""Findings that say the same of several things and are printed one by one; of more, only the first is."""

MOST_PLACES = 3
"""Places that are named of the others."""

COLOURS = {"damage": "red", "warning": "yellow", "info": "dim"}


def out() -> Console:
    """Return the console for results on standard output; plain text where it is no terminal."""
    return Console(file=sys.stdout, soft_wrap=not sys.stdout.isatty(), highlight=False)


def err() -> Console:
    """Return the console for progress and errors on standard error."""
    return Console(file=sys.stderr, soft_wrap=not sys.stderr.isatty(), highlight=False)


def plain(text: str) -> str:
    """Return a text of any origin for a console: no markup is read in it, and no character steers the terminal."""
    return escape(UNSEEN.sub(lambda found: found[0].encode("unicode_escape").decode(), text))


def say(text: str) -> None:
    """Print a sentence for people on standard output."""
    out().print(plain(text))


def say_left_alone(paths: Iterable[str]) -> None:
    """Print the names of files that no format claims, folder by folder."""
    folders: dict[str, list[str]] = {}
    for path in map(Path, paths):
        folders.setdefault(str(path.parent), []).append(path.name)
    for folder, names in folders.items():
        some = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if names[3:] else "")
        is_truth = _is_truth(Path(folder), names)
        why = "the truth of simulated recordings, which no dataset holds" if is_truth else "no format claims them"
        say(f"  left alone in {folder}: {some}; {why}")


def _is_truth(folder: Path, names: Sequence[str]) -> bool:
    """Return whether files are what `tactiledata record` keeps of its worlds: a document and a table of each log."""
    logs = {Path(name).stem for name in names}
    return folder.name == TRUTH and set(names) == {f"{log}{end}" for log in logs for end in (".json", ".parquet")}


def emit(document: Any) -> None:
    """Print a result for machines: a JSON document on standard output."""
    sys.stdout.write(json.dumps(document, indent=2, ensure_ascii=False, default=str) + "\n")


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Print a table with numbers aligned to the right.

    Parameters
    ----------
    title : str
        Line above the table; empty for none.
    columns : sequence of str
        Names of the columns.
    rows : iterable of sequences
        Cells; integers get thousands separators.
    """
    cells = [list(row) for row in rows]
    drawn = Table(box=None, pad_edge=False)
    for position, column in enumerate(columns):
        numeric = bool(cells) and all(isinstance(row[position], int | float) for row in cells)
        drawn.add_column(column, justify="right" if numeric else "left", overflow="fold")
    for row in cells:
        drawn.add_row(*(plain(f"{cell:,}" if isinstance(cell, int) else str(cell)) for cell in row))
    console = out()
    if not console.is_terminal:
        console = Console(file=sys.stdout, width=200, highlight=False)
    if title:  # of a table's own title a narrow table makes several lines
        console.print(plain(title), style="italic", soft_wrap=True)
    console.print(drawn)


def findings(found: Iterable[tuple[str, Finding]], most: int = 40, all_of_them: str = "--json") -> None:
    """Print findings, the worst first; of many that say the same, one is printed and the places of some are named.

    Parameters
    ----------
    found : iterable of pairs
        A place, such as the name of a recording, and a finding.
    most : int
        How many lines are printed.
    all_of_them : str
        The option or command that prints all of them.
    """
    console = out()
    every = list(found)
    lines = list(_finding_lines(every))
    for _, text in lines[:most]:
        console.print(text)
    if len(lines) > most:
        console.print(f"  … and {sum(number for number, _ in lines[most:])} more")
    if len(lines) > most or len(lines) < len(every):
        console.print(f"  all of them: {plain(all_of_them)}")


def _finding_lines(found: list[tuple[str, Finding]]) -> Iterator[tuple[int, str]]:
    """Yield lines that tell findings, each with the number of findings that it stands for."""
    rank = {"damage": 0, "warning": 1, "info": 2}
    places = {where for where, _ in found if where}
    alike: dict[tuple[str, str], list[tuple[str, Finding]]] = {}
    for where, finding in sorted(found, key=lambda pair: (rank[pair[1].severity], pair[1].code, pair[0])):
        names = (*places, finding.stream, finding.trajectory)
        message = finding.message.removeprefix(f"{where}: ")
        alike.setdefault((finding.code, bare_wording(message, names)), []).append((where, finding))
    for group in alike.values():
        whole = len(group) if len(group) <= MOST_ALIKE else 1
        for where, finding in group[:whole]:
            colour = COLOURS[finding.severity]
            # some messages begin with the name of the recording; others begin with a stream that may have the same name
            is_named = finding.message.startswith(f"{where}: ") and finding.stream != where
            place = f"{where}: " if where and not is_named else ""
            text = f"{plain(place)}{plain(finding.message)} \\[{finding.code}]"
            yield 1, f"  [{colour}]{finding.severity:<7}[/{colour}] {text}"
        if others := group[whole:]:
            named = list(dict.fromkeys(where or finding.trajectory or finding.stream for where, finding in others))
            where = f", in {plain(listed(named, MOST_PLACES))}" if all(named) else ""
            yield len(others), f"          and {len(others)} more like it{where}"


def time_left(done: int, total: int, seconds: float) -> str:
    """Return how long the steps that are left take, as ", about 3 min left"; nothing where it is below a minute.

    Nothing either before ``LEAST_DONE`` of the steps: the first may be of another kind than the others, as a
    recording's tables are beside thousands of images.

    Parameters
    ----------
    done, total : int
        Number of finished steps, and of all steps.
    seconds : float
        Time that the finished steps took.
    """
    left = seconds * (total - done) / done if done and done >= LEAST_DONE * total else 0.0
    return f", about {left / 60:.0f} min left" if left >= 60.0 else ""


class _PrintedSteps:
    """Remembers which steps were done when, for progress that is printed as lines.

    Work may have several parts, each with a number of steps of its own: the time that is left is told from the steps of
    the present part.

    Parameters
    ----------
    now : float
        Seconds on a clock that never goes back.
    """

    def __init__(self, now: float) -> None:
        self._printed, self._tenth = now, -1
        self._began, self._first = now, 0
        self._done, self._total = 0, 0

    def left(self, done: int, total: int, now: float) -> str | None:
        """Return how long the steps that are left take, as `time_left` says it; ``None`` if no line is to be printed.

        Parameters
        ----------
        done, total : int
            Number of finished steps, and of all steps.
        now : float
            As above.
        """
        if self._total and (total != self._total or done < self._done):  # another part of the work
            self._began, self._first, self._tenth = now, done, -1
        self._done, self._total = done, total
        tenth = done * 10 // max(total, 1)
        if tenth == self._tenth and now - self._printed <= QUIET_SECONDS:
            return None
        self._printed, self._tenth = now, tenth
        return time_left(done - self._first, total - self._first, now - self._began)


@contextmanager
def progress(title: str, quiet: bool = False) -> Iterator[Progress]:
    """Give the block a function to report progress to: it draws a bar on a terminal, and prints lines elsewhere.

    The function takes the number of finished steps, the number of all steps, and a word for the present one.
    """
    console = err()
    if quiet:
        yield no_progress
        return
    if not console.is_terminal:
        printed = _PrintedSteps(time.monotonic())

        def line(done: int, total: int, what: str = "") -> None:
            """Print a line at every tenth of the steps, and after a long silence."""
            left = printed.left(done, total, time.monotonic())
            if left is not None:
                console.print(plain(f"{title}: {done}/{total}{' ' * bool(what)}{what}{left}"))

        yield line
        return
    times = (TimeElapsedColumn(), TimeRemainingColumn())
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), *times)
    with ProgressBar(*columns, TextColumn("{task.fields[what]}"), console=console, transient=True) as bar:
        task = bar.add_task(title, total=None, what="")
        yield lambda done, total, what="": bar.update(task, completed=done, total=total, what=plain(what[-40:]))

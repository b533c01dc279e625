"""Printing of failures: a sentence for people, one JSON object for machines."""

from __future__ import annotations

import errno
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import typer

from tactiledata import __version__
from tactiledata.cli.output import emit, err, plain
from tactiledata.contract.atomic import FULL, REFUSED, refusal
from tactiledata.contract.extras import package_behind
from tactiledata.errors import TactileDataError

DEBUG_VARIABLE = "TACTILEDATA_DEBUG"
"""Environment variable that, set to 1, shows the traceback of a fault of ours."""

INTERRUPTED = 130
"""Exit code after Ctrl-C."""
AGAIN_S = 2.0
"""Time, s, after which Ctrl-C is repeated while a command runs on."""


@contextmanager
def repeated_interruption() -> Iterator[Callable[[], bool]]:
    """Repeat Ctrl-C until the command ends, and yield what tells whether it came.

    A `KeyboardInterrupt` that is raised while code of others calls back is swallowed there, or turned into another
    error. Where Ctrl-C is handled or ignored already, nothing is changed.
    """
    came, ended, main = threading.Event(), threading.Event(), threading.get_ident()

    def repeat() -> None:
        while not ended.wait(AGAIN_S):
            # a signal of its own also wakes a main thread that waits in the system
            signal.pthread_kill(main, signal.SIGINT)

    def handle(number: int, frame: Any) -> None:
        if not came.is_set():
            came.set()
            threading.Thread(target=repeat, daemon=True).start()
        signal.default_int_handler(number, frame)

    def drop(dropped: Any) -> None:
        if not (came.is_set() and issubclass(dropped.exc_type, KeyboardInterrupt)):
            before(dropped)

    before = sys.unraisablehook
    is_ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if is_ours:
        signal.signal(signal.SIGINT, handle)
        sys.unraisablehook = drop
    try:
        yield came.is_set
    finally:
        ended.set()
        if is_ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            sys.unraisablehook = before


def report_failure(error: Exception, as_json: bool) -> int:
    """Print a failure, on standard error for people or on standard output for machines, and return its exit code.

    The JSON object has ``error``, ``expected`` and ``hint`` (empty where there is none) and the exit ``code``.
    """
    if isinstance(error, typer.TyperException):
        if not as_json and error.format_message().startswith("Usage:"):
            # a command without arguments asks for its help
            typer.echo(error.format_message(), err=True)
            return error.exit_code
        failure, code = _of_command_line(error), error.exit_code
    else:
        failure, code = _as_ours(error)
    if as_json:
        emit(_document(failure.found, failure.expected, failure.remedy, code))
    else:
        err().print(f"[red]error:[/red] {plain(str(failure))}")
    return code


def report_interruption(as_json: bool) -> None:
    """Print one line after Ctrl-C."""
    message, remedy = "interrupted", "Nothing is half written; the same command goes on from what is finished."
    if as_json:
        emit(_document(message, "", remedy, INTERRUPTED))
    else:
        err().print(f"{message}: {remedy[0].lower()}{remedy[1:]}")


def _document(found: str, expected: str, remedy: str, code: int) -> dict[str, Any]:
    """Return the JSON object of a failure."""
    return {"error": found, "expected": expected, "hint": remedy, "code": code}


def _of_command_line(error: Any) -> TactileDataError:
    """Return an error of the parser of the command line, such as an unknown option, as one of our tree."""
    found, meant, names = error.format_message().partition(" Did you mean")
    command = getattr(getattr(error, "ctx", None), "command_path", "")
    about = f"Run `{command} --help` for what it takes." if command else "See --help of the command."
    return TactileDataError(f"{found[:1].lower()}{found[1:]}", "", f"{meant}{names} {about}".strip())


def _as_ours(error: Exception) -> tuple[TactileDataError, int]:
    """Return an error of our tree, and its exit code: 3 for a fault of the program, else what the error says."""
    if isinstance(error, TactileDataError):
        return error, error.exit_code
    if (missing := package_behind(error)) is not None:
        return missing, missing.exit_code
    if isinstance(error, OSError):
        if _is_of_writing(error):
            unwritten = TactileDataError(*refusal(error, error.filename or "a file"))
            return unwritten, unwritten.exit_code
        if error.errno in REFUSED and error.filename:
            unread = TactileDataError(
                f"{os.fsdecode(error.filename)} cannot be read: {error.strerror or error}",
                "a place that you may read",
                "Check your rights there, or name another place.",
            )
            return unread, unread.exit_code
        name = f" ({error.filename})" if error.filename else ""
        refused = TactileDataError(
            f"the system refused: {error.strerror or error}{name}",
            "",
            "Check the path, and your rights there.",
        )
        return refused, refused.exit_code
    fault = TactileDataError(
        f"a fault of tactiledata {__version__}: {type(error).__name__}: {error}",
        "",
        f"Please report it with the traceback that {DEBUG_VARIABLE}=1 shows.",
    )
    return fault, 3


def _is_of_writing(error: OSError) -> bool:
    """Return whether the system refused to write: there is no room, a read-only disk, or a file that may be read."""
    if error.errno not in REFUSED or error.errno == errno.EROFS:
        return error.errno in (*FULL, errno.EROFS)
    if not error.filename:
        return False
    path = Path(os.fsdecode(error.filename))
    return os.access(path, os.R_OK) or (os.access(path.parent, os.R_OK | os.X_OK) and not os.path.lexists(path))

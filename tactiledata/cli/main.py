"""The command `tactiledata`: its commands, its exit codes and the printing of errors."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Callable
from importlib.metadata import entry_points

import typer

from tactiledata import __version__
from tactiledata.cli import (
    calibrate,
    demo,
    diagnose,
    export_data,
    families,
    flag,
    ingest,
    plant,
    prove,
    record,
    replay,
    scene,
    sensors,
    split,
    store,
    view,
)
from tactiledata.cli.failure import (
    DEBUG_VARIABLE,
    INTERRUPTED,
    repeated_interruption,
    report_failure,
    report_interruption,
)
from tactiledata.cli.given_values import CheckedApp
from tactiledata.errors import TactileDataError

app = CheckedApp(
    name="tactiledata",
    help="Recordings of a robot pressing a vision-based tactile sensor, turned into a checked, leak-free dataset.",
    no_args_is_help=True,
    add_completion=True,
    rich_markup_mode=None,
    context_settings={"max_content_width": 120},
    pretty_exceptions_enable=False,
)

GROUP = "tactiledata.commands"
"""Group of entry points of packages that add commands: functions of the application."""

for module in (
    demo, record, families, ingest, store, sensors, flag, split, export_data, calibrate, diagnose, replay, scene, view,
    prove, plant,
):  # fmt: skip
    module.register(app)
for point in entry_points(group=GROUP):
    point.load()(app)


@app.callback(invoke_without_command=True)
def _version(
    version: bool = typer.Option(False, "--version", help="Print the version and stop.", is_eager=True),
) -> None:
    if version:
        typer.echo(f"tactiledata {__version__}")
        raise typer.Exit


def run() -> None:
    """Run the command and exit: 0 success, 1 insufficient data, 2 wrong usage, 3 a fault of ours, 130 interrupted."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # names of files and sensors may hold what the terminal's encoding cannot show
            stream.reconfigure(errors="backslashreplace")
    as_json = "--json" in sys.argv[1:]
    with repeated_interruption() as was_interrupted:
        code = _run(as_json, was_interrupted)
    if code == INTERRUPTED:  # typer turns Ctrl-C into this code
        report_interruption(as_json)
    sys.exit(code)


def _run(as_json: bool, was_interrupted: Callable[[], bool]) -> int:
    """Run the command; return its exit code, with failures printed.

    Parameters
    ----------
    as_json : bool
        Whether failures are printed for machines.
    was_interrupted : callable
        Tells whether Ctrl-C came: an error that follows it is no fault.
    """
    try:
        return app(standalone_mode=False, prog_name="tactiledata") or 0
    except BrokenPipeError:
        # the reader of our output went away, as `| head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:  # the last resort: no traceback for users
        if was_interrupted():
            return INTERRUPTED
        is_expected = isinstance(error, TactileDataError | OSError | typer.TyperException)
        if os.environ.get(DEBUG_VARIABLE) and not is_expected:
            raise
        return report_failure(error, as_json)

"""The command `tactiledata` and how its errors reach a person."""

from __future__ import annotations

import io
import os
import sys

import typer
from rich.markup import escape

from tactiledata import __version__
from tactiledata.cli import demo, families, ingest, record, split, store
from tactiledata.cli.output import err
from tactiledata.errors import TactileDataError

DEBUG_VARIABLE = "TACTILEDATA_DEBUG"
"""Set to 1 to see the traceback of a fault of ours."""

app = typer.Typer(
    name="tactiledata",
    help="Recordings of a robot pressing a vision-based tactile sensor, turned into a checked, leak-free dataset.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    context_settings={"max_content_width": 120},
    pretty_exceptions_enable=False,
)
for module in (demo, record, families, ingest, store, split):
    module.register(app)


@app.callback(invoke_without_command=True)
def _version(
    version: bool = typer.Option(False, "--version", help="Print the version and stop.", is_eager=True),
) -> None:
    if version:
        typer.echo(f"tactiledata {__version__}")
        raise typer.Exit


def run() -> None:
    """Run the command; exit 0 fine, 1 the data fell short, 2 wrong usage, 3 a fault of ours, 130 interrupted."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # names of files and sensors may hold what the terminal's encoding cannot show
            stream.reconfigure(errors="backslashreplace")
    try:
        app()
    except TactileDataError as error:
        err().print(f"[red]error:[/red] {escape(str(error))}")
        sys.exit(error.exit_code)
    except KeyboardInterrupt:
        err().print("interrupted; what is finished is kept, run the same command again to go on")
        sys.exit(130)
    except BrokenPipeError:
        # the reader of our output went away, as `| head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(0)
    except OSError as error:
        err().print(f"[red]error:[/red] {escape(_os_text(error))}")
        sys.exit(1)
    except Exception as error:  # the last resort: no traceback for users
        if os.environ.get(DEBUG_VARIABLE):
            raise
        err().print(
            f"[red]error:[/red] a fault of tactiledata {__version__}: {type(error).__name__}: {escape(str(error))}. "
            f"Please report it with the traceback that {DEBUG_VARIABLE}=1 shows."
        )
        sys.exit(3)


def _os_text(error: OSError) -> str:
    name = f" ({error.filename})" if error.filename else ""
    return f"the system refused: {error.strerror or error}{name}. Check the path, its permissions and the free space."

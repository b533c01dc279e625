"""`view`: trajectories of a store on one time line, in rerun's viewer."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path
from shlex import quote

import typer

from tactiledata.cli.explain import damage_explains
from tactiledata.cli.given_values import need_writable_folder, refuse_given
from tactiledata.cli.output import JSON_OPTION, emit, progress, say
from tactiledata.cli.working_store import store_and_names
from tactiledata.errors import UsageError


def register(app: typer.Typer) -> None:
    """Add the command `view` to the application."""
    app.command("view")(view)


def view(
    context: typer.Context,
    words: list[str] = typer.Argument(
        None,
        metavar="[STORE] [TRAJECTORY]...",
        help="A store (default: the only store in the working folder), and trajectories: uid, name, or recording/name.",
    ),
    out: Path = typer.Option(Path("view.rrd"), "--out", help="File to write, for rerun's viewer (.rrd)."),
    sensor: str = typer.Option(None, "--sensor", help="Only trajectories of this sensor."),
    indenter: str = typer.Option(None, "--indenter", help="Only trajectories of this indenter."),
    flagged: bool = typer.Option(False, "--flagged", help="Only flagged trajectories."),
    most: int = typer.Option(20, "--most", help="Most trajectories, where none is named; 0 for all."),
    stride: int = typer.Option(1, "--stride", help="Show every Nth frame."),
    pictures: int = typer.Option(300, "--pictures", help="Most frames of one trajectory, evenly taken; 0 for all."),
    mesh: str = typer.Option(None, "--mesh", help="Name of the mesh to show [default: the most faithful one]."),
    window: bool = typer.Option(
        None, "--open/--no-open", help="Open the viewer [default: where a terminal and a display are there]."
    ),
    web: bool = typer.Option(False, "--web", help="Serve the viewer to a browser of this machine, until Ctrl-C."),
    port: int = typer.Option(9090, "--port", help="With --web: port of the page; 0 for any that is free."),
    narrow: bool = typer.Option(False, "--narrow", help="Stack the panes in tabs, for a phone or a narrow window."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Look at trajectories on one time line.

    Pictures, contact, gel, forces, residual, pose and all other signals are shown together.
    Writes a file that rerun's viewer opens, here or elsewhere (`pip install rerun-sdk`, then `rerun view.rrd`).
    Measured values are dots, simulated ones are lines.

    Example: tactiledata view ds.zarr D20001.mcap/t00000 --out touch.rrd
    """
    from tactiledata.store.read.reader import Store
    from tactiledata.view.options import ViewOptions
    from tactiledata.view.recording import SUFFIX, write_view
    from tactiledata.view.serve import has_display, need_display, need_port, open_viewer

    if out.suffix != SUFFIX or out.is_dir():
        raise UsageError(
            f"--out {out}{' is a folder' if out.is_dir() else ''}",
            f"a file name that ends in {SUFFIX}",
            f"For example --out view{SUFFIX}.",
        )
    need_writable_folder(out.parent, out.name)
    location, names = store_and_names(words)
    if names:
        refuse_given(context, ["most"], "with named trajectories", "where no trajectory is named")
    if web:
        need_port(port)
    else:
        refuse_given(context, ["port"], "without --web", "with --web")
    if web and window:
        raise UsageError("--web with --open", "one of them", "Leave one out.")
    if web and as_json:
        raise UsageError("--web with --json", "one of them", "--json writes the file alone.")
    if window:
        need_display(out)
    options = ViewOptions(
        tuple(names), sensor, indenter, flagged, most, stride=stride, pictures=pictures, mesh=mesh, narrow=narrow
    )
    with damage_explains(location), progress("writing", quiet=as_json) as report_progress:
        report = write_view(Store.open(location), out, options, report_progress)
    if as_json:
        emit(report.document())
    else:
        for line in report.lines():
            say(line)
    if web:
        _serve(out, port, in_browser=window is not False)
    elif window or (window is None and not as_json and sys.stdout.isatty() and has_display()):
        open_viewer(out)
    elif not as_json:
        say(f"look: rerun {quote(str(out))}, or the same command with --web")


def _serve(path: Path, port: int, in_browser: bool = True) -> None:
    """Serve the viewer until Ctrl-C; open the browser where it is wanted and there is one."""
    from threading import Event
    from urllib.parse import urlsplit

    from tactiledata.view.serve import has_display, served

    # Ctrl-C may come as soon as the address is said, and again while the server ends
    try:
        with served(path, port) as address:
            say(f"look: {address}")
            used = urlsplit(address).port
            say(
                f"Only this machine can open it. On another one: `ssh -L {used}:127.0.0.1:{used} THIS-MACHINE`, then "
                "open the same address there. Ctrl-C ends it."
            )
            if in_browser and has_display() and sys.stdout.isatty():
                webbrowser.open(address)
            sys.stdout.flush()
            Event().wait()
    except KeyboardInterrupt:
        say("ended")

"""`info`, `check`, `merge`, `sensors`: what a store holds, and whether it is whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from tactiledata.cli.output import JSON_OPTION, emit, findings, progress, say, table
from tactiledata.cli.working_store import STORE_ARGUMENT, working_store


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command("info")(info)
    app.command("check")(check)
    app.command("merge")(merge)
    sensors_app = typer.Typer(invoke_without_command=True, rich_markup_mode=None, add_completion=False)
    sensors_app.callback()(sensors)
    sensors_app.command("add")(sensors_add)
    app.add_typer(sensors_app, name="sensors")

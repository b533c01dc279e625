"""The command `export`: SPLIT's networks for programs that have no PyTorch."""

from __future__ import annotations

from pathlib import Path

import typer

from tactiledata.cli.output import JSON_OPTION, emit, say

OUT = typer.Option(Path("runs"), "--out", help="Folder with the trained models, which also takes the files.")


def register(app: typer.Typer) -> None:
    """Add the command `export` to the application."""
    app.command("export")(export)


def export(
    recipe: str = typer.Argument(..., help="A recipe file, or the name of a bundled one."),
    to: str = typer.Option("onnx", "--to", help="Format of the files: onnx."),
    scale: str = typer.Option("small", "--scale", help="small or paper, as the models were trained."),
    out: Path = OUT,
    as_json: bool = JSON_OPTION,
) -> None:
    """Export the VAEs and projections of a recipe as ONNX files.

    Missing models are trained first. Each file is compared with PyTorch. `tactiledata export-data` exports recordings.

    Example: tactiledata export split_backbone --to onnx
    """
    from split_models.commands.verbs import opened_run
    from tactiledata.errors import UnknownName
    from tactiledata.export import EXPORTERS

    if to != "onnx":
        remedy = f"`tactiledata export-data STORE --to {to}` exports recordings." if to in EXPORTERS else ""
        raise UnknownName("format of exported models", to, ("onnx",), remedy)
    with opened_run(recipe, scale, "cpu", out, 1, as_json) as recipe_run:
        from split_models.onnx.export import onnx_models

        models = onnx_models(recipe_run)
    if as_json:
        emit({"folder": str(models.folder), **models.document})
        return
    for name, difference in models.document["difference"].items():
        say(f"{name}.onnx: within {difference:.1g} of PyTorch")
    say(f"{models.folder}")

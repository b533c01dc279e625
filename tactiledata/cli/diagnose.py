"""`diagnose`: where prediction and observation differ, and which formula explains it."""

from __future__ import annotations

from pathlib import Path

import typer

from tactiledata.cli.documents import wrong_document_is_wrong_usage
from tactiledata.cli.output import JSON_OPTION, emit, progress, say


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    app.command("diagnose")(diagnose)


def diagnose(
    table: Path = typer.Argument(
        ..., help="A table: .csv, .tsv or .parquet; docs/diagnose-table.md names its columns."
    ),
    columns: Path = typer.Option(None, "--columns", help="A YAML file that says what the columns mean."),
    group: str = typer.Option(None, "--group", help="Column that says which rows were recorded in one go."),
    out: Path = typer.Option(None, "--out", help="Folder for report.html and diagnosis.json."),
    gate: bool = typer.Option(False, "--gate", help="Exit 1 where structure is found."),
    seed: int = typer.Option(0, "--seed", help="Another seed throws other chances."),
    as_json: bool = JSON_OPTION,
) -> None:
    """Where predictions and observations differ. On what it depends, and in which formula; chance is ruled out.

    Example: tactiledata diagnose table.csv --out diagnosis
    """
    from tactiledata.contract.schema import read_document
    from tactiledata.diagnose.diagnose_table import diagnose_table, write_diagnosis

    meant = None
    if columns is not None:
        with wrong_document_is_wrong_usage():
            meant = read_document(columns, "columns")
    with progress("diagnosing", quiet=as_json) as tell:
        read, explanation, document = diagnose_table(table, meant, group, seed, tell)
    written = [] if out is None else write_diagnosis(out, table.name, read, explanation, document)
    if as_json:
        emit(document)
    else:
        for sentence in document["sentences"]:
            say(sentence)
        for note in document["notes"]:
            say(f"note: {note}")
        if written:
            say(f"written: {', '.join(str(path) for path in written)}")
    if gate and explanation.located.is_structured:
        raise typer.Exit(1)

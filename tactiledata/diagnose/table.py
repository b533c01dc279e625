"""`diagnose TABLE`: read, locate, explain, show, without a gel."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import write_atomic, write_json_atomic
from tactiledata.contract.progress import Progress, no_progress
from tactiledata.contract.provenance import file_digest
from tactiledata.diagnose.answer.documents import errors, table_document
from tactiledata.diagnose.answer.formula_page import explanation_page
from tactiledata.diagnose.formula.explain import Explanation, explain
from tactiledata.diagnose.locate.gate import NoiseModel
from tactiledata.diagnose.locate.locate import LocateOptions
from tactiledata.diagnose.table_input.read import doubts_of, read_table
from tactiledata.diagnose.table_input.residuals_of import Table, residuals_of

NOISE_DOUBT = 0.1
"""Relative uncertainty of the noise that a table states."""


def diagnose_table(
    path: Path,
    columns: dict[str, Any] | None = None,
    group: str | None = None,
    seed: int = 0,
    progress: Progress = no_progress,
) -> tuple[Table, Explanation, dict[str, Any]]:
    """Return a table as it was read, its diagnosis, and the diagnosis as a document (schemas/diagnosis.json).

    Parameters
    ----------
    path : Path
        A file of predictions and observations: .csv, .tsv or .parquet.
    columns : dict, optional
        What the columns mean (schemas/columns.json); without it their names and units are read off the headings.
    group : str, optional
        Column that says which rows were recorded in one go.
    seed : int
        Draws folds, halves and sign flips; the same table and seed give the same document.
    progress : Progress
        Called with the number of finished steps, the number of all steps and the name of the step that begins.

    Raises
    ------
    MissingFile, UsageError
        A file or column is not there.
    TactileDataError
        The table holds too little, or scikit-learn is not installed.
    """
    table = residuals_of(read_table(path), columns, group)
    table = replace(table, notes=(*doubts_of(path), *table.notes))
    meanings = table.columns
    noise = NoiseModel(meanings.noise_correlation, NOISE_DOUBT) if table.is_noise_known else None
    options = LocateOptions(meanings.order, meanings.plane, noise, seed)
    explanation = explain(table.residuals, options, meanings.time, meanings.scales, progress=progress)
    return table, explanation, table_document(table, explanation, file_digest(path), seed)


def write_diagnosis(
    folder: Path, name: str, table: Table, explanation: Explanation, document: dict[str, Any]
) -> tuple[Path, Path]:
    """Write ``report.html`` and ``diagnosis.json`` into a folder, and return their paths.

    Parameters
    ----------
    folder : Path
        Is made where it does not exist.
    name : str
        Name of the table, for the title of the page.
    table, explanation, document
        As `diagnose_table` returns them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    page = explanation_page(
        f"Diagnosis of {name}", explanation, errors(table, explanation), table.notes,
        f"{len(table.residuals.values)} rows, {table.residuals.unit_count} groups",
    )  # fmt: skip
    write_atomic(folder / "report.html", page.encode())
    write_json_atomic(folder / "diagnosis.json", document)
    return folder / "report.html", folder / "diagnosis.json"

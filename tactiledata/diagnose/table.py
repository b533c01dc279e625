"""`diagnose TABLE`: read, locate, explain, show, without a gel."""

from __future__ import annotations

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
from tactiledata.diagnose.table_input.read import read_table
from tactiledata.diagnose.table_input.residuals_of import Table, residuals_of

DOUBT = 0.1
"""How well the noise that a table states is taken to be known."""


def diagnose_table(
    path: Path,
    columns: dict[str, Any] | None = None,
    group: str | None = None,
    seed: int = 0,
    tell: Progress = no_progress,
) -> tuple[Table, Explanation, dict[str, Any]]:
    """What was read, the diagnosis, and its document (schemas/diagnosis.json).

    Parameters
    ----------
    columns : document of schemas/columns.json, optional
    group : str, optional
        The column of groups.

    Raises
    ------
    MissingFile, UsageError
        A file or column that is not there.
    TactileDataError
        A table that holds too little.
    """
    table = residuals_of(read_table(path), columns, group)
    meant = table.columns
    noise = NoiseModel(meant.noise_correlation, DOUBT) if table.is_noise_known else None
    options = LocateOptions(meant.order, meant.plane, noise, seed)
    explanation = explain(table.residuals, options, meant.time, meant.scales, tell=tell)
    return table, explanation, table_document(table, explanation, file_digest(path), seed)


def write_diagnosis(
    folder: Path, name: str, table: Table, explanation: Explanation, document: dict[str, Any]
) -> tuple[Path, Path]:
    """``report.html`` and ``diagnosis.json`` in a folder, which is made where it is not there."""
    folder.mkdir(parents=True, exist_ok=True)
    page = explanation_page(
        f"Diagnosis of {name}", explanation, errors(table, explanation), table.notes,
        f"{len(table.residuals.values)} rows, {table.residuals.unit_count} groups",
    )  # fmt: skip
    write_atomic(folder / "report.html", page.encode())
    write_json_atomic(folder / "diagnosis.json", document)
    return folder / "report.html", folder / "diagnosis.json"

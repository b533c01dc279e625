"""Training curves as files, with one row for each epoch."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import write_atomic, write_json_atomic

CURVE = "curve"
"""Stem of the files' names."""


def write_curves(folder: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write the rows of a training curve to ``curve.csv`` and ``curve.json`` in a folder."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_atomic(folder / f"{CURVE}.csv", text.getvalue().encode())
    write_json_atomic(folder / f"{CURVE}.json", [dict(row) for row in rows])

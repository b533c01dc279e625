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
FIRST, LAST = ("epoch", "learning_rate"), ("seconds",)
"""Columns before the losses and after them."""


def write_curves(folder: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write the rows of a training curve to ``curve.csv`` and ``curve.json`` in a folder.

    Columns have one order, whether the rows come from a training or from its checkpoint.
    """
    names = {name for row in rows for name in row}
    losses = sorted(names.difference(FIRST, LAST))
    columns = [*(name for name in FIRST if name in names), *losses, *(name for name in LAST if name in names)]
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_atomic(folder / f"{CURVE}.csv", text.getvalue().encode())
    write_json_atomic(folder / f"{CURVE}.json", [dict(row) for row in rows])

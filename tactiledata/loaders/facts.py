"""Facts of a dataset's items as a table: who touched what, and the free columns of the recordings as covariates."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from tactiledata.loaders.index import FrameIndex

if TYPE_CHECKING:
    from tactiledata.store.read.reader import Store

EXTRA = "extra."
"""Before the name of a free column."""


def item_table(store: Store, index: FrameIndex) -> pa.Table:
    """A row for each item: ``frame`` (of a trajectory the first), ``t_ns``, ``trajectory`` (uid), ``sensor``,
    ``indenter``, ``peak_force`` (N, of the trajectory) and a column ``extra.NAME`` for each free column.
    """
    first = index.starts[:-1]
    trajectory = index.trajectory[first]
    table = store.trajectories(["peak_force", "extra"])
    rows = pa.array(trajectory, mask=trajectory < 0)
    free = free_columns([text.as_py() for text in table["extra"]])
    columns: dict[str, Any] = {
        "frame": index.rows[first],
        "t_ns": index.t_ns[first],
        "trajectory": index.uids[trajectory].tolist(),
        "sensor": index.sensors(first),
        "indenter": index.indenters[trajectory].tolist(),
        "peak_force": table["peak_force"].combine_chunks().take(rows),
        **{f"{EXTRA}{name}": column.take(rows) for name, column in free.items()},
    }
    return pa.table(columns)


def free_columns(texts: Sequence[str]) -> dict[str, pa.Array]:
    """The free columns of trajectories (n,), given as JSON objects: numbers where all are numbers, else texts.

    Examples
    --------
    >>> found = free_columns(['{"speed": 2, "glue": "A"}', '{"glue": 3}'])
    >>> {name: column.to_pylist() for name, column in found.items()}
    {'glue': ['A', '3'], 'speed': [2.0, None]}
    """
    rows = [json.loads(text or "{}") for text in texts]
    names = sorted({name for row in rows for name in row})
    return {name: _column([row.get(name) for row in rows]) for name in names}


def _column(values: list[Any]) -> pa.Array:
    known = [value for value in values if value is not None]
    if all(isinstance(value, int | float) for value in known):
        return pa.array([None if value is None else float(value) for value in values], pa.float64())
    texts = [value if value is None or isinstance(value, str) else json.dumps(value) for value in values]
    return pa.array(texts, pa.string())

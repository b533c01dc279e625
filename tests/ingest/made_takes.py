"""Small takes whose columns are given one by one, for tests of what is said of them."""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from tactiledata.contract.records import Source, Stamps
from tactiledata.contract.take import FRAME_SCHEMA, TRAJECTORY_SCHEMA, StoredSignal, Take, findings_table
from tactiledata.units import SIGNAL_COLUMNS, signal_units

NAMED = ("camera", "sensor", "encoding")


def signal(name, t_ns, values, columns=None, **attributes):
    """A stored signal, with the columns and units that its name has."""
    columns = columns or SIGNAL_COLUMNS[name]
    t_ns = np.asarray(t_ns, dtype=np.int64)
    return StoredSignal(
        t_ns, np.asarray(values, float), columns, signal_units(columns), "base", Stamps(t_ns), attributes
    )


def frames(count, **columns):
    """A table of frames 10 ns apart in trajectory 0 of sensor D1, but for the columns that are given."""
    values = {
        "trajectory": 0, "source": 0, "camera": "digit", "sensor": "D1", "t_ns": 10 * np.arange(count), "log_ns": 0,
        "publish_ns": -1, "header_ns": -1, "encoding": "png", "height": 8, "width": 6, "offset": 0, "length": 1,
        "crc32c": np.arange(count), "contact_force": np.nan, "flags": 0, "parent_frame": -1, **columns,
    }  # fmt: skip
    arrays = [
        pa.array(values[field.name] if np.ndim(values[field.name]) else [values[field.name]] * count).cast(field.type)
        for field in FRAME_SCHEMA
    ]
    return pa.Table.from_arrays(arrays, schema=FRAME_SCHEMA)


def touch(name="t0", start_ns=0, end_ns=1000, frame_start=0, frame_stop=1, **columns):
    """A row of a table of trajectories."""
    row = {"uid": name, "trajectory": name, "source": 0, "sensor": "D1", "indenter": "", "start_ns": start_ns}
    row |= {"end_ns": end_ns, "frame_start": frame_start, "frame_stop": frame_stop, "signal_rows": "{}"}
    return row | {"peak_force": None, "segmented": "log", "parent": "", "extra": "{}"} | columns


def take(table=None, touches=(), signals=(), **parts):
    """A take of a table of frames, rows of trajectories and signals by name."""
    return Take(
        source=Source("run", "run", "mcap", ()), sha256="ab", status="ok",
        **{"description": {}, "provenance": {}, **parts},
        frames=FRAME_SCHEMA.empty_table() if table is None else table,
        trajectories=pa.Table.from_pylist(list(touches), TRAJECTORY_SCHEMA),
        findings=findings_table([]), signals=dict(signals),
    )  # fmt: skip


def told(findings):
    """Code, severity, stream and count of each finding."""
    return [(one.code, one.severity, one.stream, one.count) for one in findings]

"""Facts of trajectories and recordings that travel along as tables, whatever the format."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from tactiledata.contract.atomic import write_atomic
from tactiledata.export.episodes import Episodes
from tactiledata.export.pictures import png_bytes
from tactiledata.store.layout.places import folder_name
from tactiledata.store.read.reader import Store
from tactiledata.store.read.simulated import kinds_of

FOLDER = "tactiledata"
"""Folder of an export that holds what no format has a place for."""


def write_tables(episodes: Episodes, folder: Path) -> None:
    """Write `trajectories.parquet`, `recordings.parquet` and the pictures without contact into an export.

    A trajectory has the columns of the store's table, its part, its recording, the number of its episode, and the
    reason of its flag where a person flagged it as bad.
    """
    store, rows = episodes.store, episodes.trajectories
    table = store.trajectories().take(rows).drop_columns(["source", "frame_start", "frame_stop", "signal_rows"])
    sources = store.sources(["key", "sha256"]).take(store.trajectories(["source"]).take(rows)["source"])
    flags = episodes.flags
    reasons = [flags[uid].reason if uid in flags else None for uid in episodes.facts.uids]
    columns = {
        "flag": pa.array(reasons, pa.string()),
        "episode": pa.array(range(len(episodes)), pa.int64()),
        "part": pa.array(episodes.parts, pa.string()),
        "frames": pa.array(episodes.lengths, pa.int64()),
        "recording": sources["key"],
        "recording_sha256": sources["sha256"],
        "recorded": pa.array(episodes.facts.kinds, pa.string()),
    }
    for name, column in columns.items():
        table = table.append_column(name, column)
    _write_table(table, folder / FOLDER / "trajectories.parquet")
    _write_table(_recordings(store), folder / FOLDER / "recordings.parquet")
    for sensor in sorted(store.manifest["references"]):
        write_atomic(background_path(folder, sensor), png_bytes(store.reference(sensor).image))


def background_path(folder: Path, sensor: str) -> Path:
    """Return the file of a sensor's picture without contact."""
    return folder / FOLDER / "backgrounds" / f"{folder_name(sensor)}.png"


def _recordings(store: Store) -> pa.Table:
    """Return the store's recordings with all that they say of themselves, and what made their rows."""
    table = store.sources(["key", "sha256", "format", "status", "description", "provenance"])
    kinds = kinds_of(table["description"].to_pylist())
    return table.append_column("recorded", pa.array(kinds, pa.string()))


def _write_table(table: pa.Table, path: Path) -> None:
    buffer = pa.BufferOutputStream()
    pq.write_table(table, buffer, compression="zstd")
    write_atomic(path, buffer.getvalue().to_pybytes())

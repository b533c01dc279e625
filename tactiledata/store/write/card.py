"""The dataset card: what a store holds, for a person who opens its folder."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from tactiledata.contract.atomic import write_atomic
from tactiledata.contract.simulated import SimulatedCount
from tactiledata.store.layout.places import CARD, MANIFEST, heap_path, rgb_path, table_folder
from tactiledata.store.layout.statistics import standard_deviation
from tactiledata.store.read.simulated import kinds_of

LINES_SHOWN = 40
"""Sensors, indenters and cameras listed one by one; the rest is counted."""


def write_card(store_path: Path, manifest: Mapping[str, Any]) -> None:
    """README.md of a store, written where it differs."""
    content = card_bytes(store_path, manifest)
    place = store_path / CARD
    if not place.is_file() or place.read_bytes() != content:
        write_atomic(place, content)


def card_bytes(store_path: Path, manifest: Mapping[str, Any]) -> bytes:
    """The content of README.md."""
    return card(store_path, manifest).encode(errors="replace")


def card(store_path: Path, manifest: Mapping[str, Any]) -> str:
    """The card's text: counts, streams with units, statistics, how to load it."""
    rows = manifest["rows"]
    statuses, sensors, indenters, severities = _counts(store_path, manifest)
    parts = [
        "# Tactile dataset",
        "",
        f"{rows['frames']:,} frames in {rows['trajectories']:,} trajectories from {rows['sources']:,} recordings; "
        f"format `{manifest['format']}`, digest `{manifest['digest'][:16]}`.",
        "",
        *_simulated(store_path, manifest),
        *_table("Recordings", ("status", "recordings"), statuses),
        *_table("Trajectories by sensor", ("sensor", "trajectories"), sensors),
        *_table("Trajectories by indenter", ("indenter", "trajectories"), indenters),
        *_table("Findings", ("severity", "findings"), severities),
        *_cameras(manifest),
        *_values("Signals at native rate", "signals", manifest),
        *_values("Values at the moments of the frames", "aligned", manifest),
        *_values("Values annotated frame by frame", "frame_values", manifest),
        *_loading(manifest),
    ]
    return "\n".join(parts)


def _simulated(store_path: Path, manifest: Mapping[str, Any]) -> list[str]:
    folder = store_path / table_folder("sources")
    columns = [_column(folder / part["file"], "description") for part in manifest["index"]["sources"]]
    kinds = [kind for column in columns for kind in kinds_of(column.to_pylist())]
    sentence = SimulatedCount.of(kinds).sentence
    return [sentence, ""] if sentence else []


def _column(part: Path, name: str) -> pa.ChunkedArray:
    with pq.ParquetFile(part) as part_file:
        return part_file.read(columns=[name])[name]


def _counts(store_path: Path, manifest: Mapping[str, Any]) -> list[Counter[str]]:
    wanted = (("sources", "status"), ("trajectories", "sensor"), ("trajectories", "indenter"), ("findings", "severity"))
    counters = []
    for table, column in wanted:
        counter: Counter[str] = Counter()
        for part in manifest["index"][table]:
            values = _column(store_path / table_folder(table) / part["file"], column)
            counter.update({entry["values"].as_py(): entry["counts"].as_py() for entry in pc.value_counts(values)})
        counters.append(counter)
    return counters


def _cell(value: object) -> str:
    text = " ".join(str(value).split()).replace("|", "\\|")
    return text if len(text) <= 80 else text[:79] + "…"


def _table(title: str, heads: tuple[str, str], counter: Counter[str]) -> list[str]:
    if not counter:
        return []
    entries = sorted(counter.items(), key=lambda entry: (-entry[1], entry[0] or ""))
    lines = [f"| {_cell(name) or '(none named)'} | {count:,} |" for name, count in entries[:LINES_SHOWN]]
    if len(entries) > LINES_SHOWN:
        rest = entries[LINES_SHOWN:]
        lines.append(f"| … {len(rest):,} more | {sum(count for _, count in rest):,} |")
    return [f"## {title}", "", f"| {heads[0]} | {heads[1]} |", "|---|---|", *lines, ""]


def _cameras(manifest: Mapping[str, Any]) -> list[str]:
    lines = []
    for camera, facts in sorted(manifest["cameras"].items()):
        if facts["heap_bytes"]:
            lines.append(f"| {_cell(camera)} | `{heap_path(camera)}` | {facts['heap_bytes']:,} bytes of JPEG and PNG |")
        for size, count in sorted(facts["rgb"].items()):
            height, _, width = size.partition("x")
            lines.append(f"| {_cell(camera)} | `{rgb_path(camera, int(height), int(width))}` | {count:,} raw frames |")
    return ["## Images", "", "| camera | array | holds |", "|---|---|---|", *lines[:LINES_SHOWN], ""] if lines else []


def _values(title: str, kind: str, manifest: Mapping[str, Any]) -> list[str]:
    lines = []
    for name, facts in sorted(manifest[kind].items()):
        statistics = facts["statistics"]
        spread = standard_deviation(statistics)
        for index, (column, unit) in enumerate(zip(facts["columns"], facts["units"], strict=True)):
            numbers = " | ".join(f"{statistics[key][index]:.6g}" for key in ("mean", "min", "max"))
            lines.append(
                f"| {_cell(name)} | {_cell(column)} | {_cell(unit)} | {_cell(facts['frame'])} "
                f"| {statistics['count'][index]:,} | {numbers} | {spread[index]:.6g} |"
            )
    if not lines:
        return []
    head = "| name | column | unit | frame | values | mean | min | max | deviation |"
    return [f"## {title}", "", head, "|---|---|---|---|---|---|---|---|---|", *lines, ""]


def _loading(manifest: Mapping[str, Any]) -> list[str]:
    first = next((name for name, facts in sorted(manifest["signals"].items()) if facts["rows"]), None)
    reads = [
        f"some = range({min(3, manifest['rows']['frames'])})",
        'pictures = store.images(some, missing="zeros")  # RGB uint8',
    ]
    reads = reads if manifest["rows"]["frames"] else []
    if first is not None:
        rows = min(100, manifest["signals"][first]["rows"])
        reads.append(f"values = store.signal({json.dumps(first, ensure_ascii=False)}).values(0, {rows})")
    return [
        "## Loading",
        "",
        "```python",
        "from tactiledata.store import Store",
        "",
        'store = Store.open("ds.zarr")',
        "frames = store.frames()  # a pyarrow table, a row a frame",
        *reads,
        "```",
        "",
        f"The arrays are plain Zarr v3. What counts is what `{MANIFEST}` names: rows beyond its lengths are not data.",
        "",
    ]

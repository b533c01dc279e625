"""A check says all that it can find, and what it could not look at, however broken the store is."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from copied_trees import copy_tree
from random_takes import SMALL, random_images, staged_take

from tactiledata.store.check.check import check
from tactiledata.store.check.repair import repair
from tactiledata.store.layout.manifest import write_manifest
from tactiledata.store.layout.places import TABLE_SCHEMAS, TABLES
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with every kind of content."""
    folder = tmp_path_factory.mktemp("goes-on") / "healthy"
    create(folder, SMALL)
    rng = np.random.default_rng(0)
    commit(folder, [staged_take(folder, seed, images=random_images(rng, 8))[0] for seed in (1, 2)])
    return folder


@pytest.fixture
def folder(healthy: Path, tmp_path: Path) -> Path:
    """A copy to damage."""
    return copy_tree(healthy, tmp_path / "ds.zarr")


def flip(place: Path) -> None:
    content = bytearray(place.read_bytes())
    content[len(content) // 2] ^= 0x55
    place.write_bytes(content)


def found(place: Path) -> dict[str, str]:
    return {one.code: one.message for one in check(place)}


@pytest.mark.parametrize(
    ("table", "still", "left"),
    [
        ("frames", "store-values", "images are those that were recorded"),
        ("sources", "store-payload", "numbers are those of their recordings"),
        ("trajectories", "store-values", "trajectories have the frames"),
        ("findings", "store-values", ""),
    ],
)
def test_a_broken_table_hides_nothing_else(folder: Path, table: str, still: str, left: str) -> None:
    """Damage elsewhere is found beside a broken table, and what the table was needed for is named."""
    flip(folder / f"index/{table}.parquet/part-00000.parquet")
    flip(folder / "signals/wrench/value/c.0.0")
    (folder / "streams/digit/heap/c.0").write_bytes(b"")
    said = found(folder)
    assert {"store-part", still} <= set(said)
    assert left in said.get("store-not-checked", "")
    assert ("store-not-checked" in said) == bool(left)


def rewritten(folder: Path, table: str, change) -> None:
    """A part of a table written anew, and named by the manifest as if it had been so from the start."""
    manifest = json.loads((folder / "manifest.json").read_text())
    part = manifest["index"][table][0]
    place = folder / f"index/{table}.parquet" / part["file"]
    pq.write_table(change(pq.read_table(place, schema=TABLE_SCHEMAS[table])), place)
    part["sha256"] = hashlib.sha256(place.read_bytes()).hexdigest()
    write_manifest(folder, manifest)


COLUMNS = [(table, name) for table in TABLES for name in TABLE_SCHEMAS[table].names if table != "findings"]


@pytest.mark.parametrize(("table", "name"), COLUMNS)
def test_columns_without_values_are_found(folder: Path, table: str, name: str) -> None:
    """Any column of the index whose values are gone is a finding, for check and for repair, never an error."""

    def emptied(rows: pa.Table) -> pa.Table:
        field = rows.schema.field(name)
        return rows.set_column(rows.schema.get_field_index(name), field, pa.nulls(len(rows), field.type))

    rewritten(folder, table, emptied)
    messages = [one.message for one in check(folder, images=False) if one.code == "store-index"]
    assert any(repr(name) in message for message in messages)
    assert "store-index" in {one.code for one in repair(folder)}


@pytest.mark.parametrize(
    "change",
    [
        lambda statistics: statistics.update(m2=[-1.0, -1.0]),
        lambda statistics: statistics.update(mean=[]),
        lambda statistics: statistics.update(min=[float("nan"), 0.0]),
        lambda statistics: statistics.update(min=[9e9, 9e9]),
    ],
)
def test_broken_statistics_are_found(folder: Path, change) -> None:
    """Statistics that cannot be right are a finding of the manifest, for check and for repair."""
    manifest = json.loads((folder / "manifest.json").read_text())
    change(manifest["signals"]["wrench"]["statistics"])
    # NaN is no JSON of ours: such a manifest was not written by a store that seals it
    manifest.pop("file_sha256")
    (folder / "manifest.json").write_text(json.dumps(manifest))
    for said in (check(folder), repair(folder)):
        assert {one.code for one in said} == {"store-manifest", "store-no-digest"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "spoil"),
    [
        ("default.parquet", Path.unlink),
        ("default.json", Path.unlink),
        ("default.parquet", flip),
        ("default.json", lambda place: place.write_text("{")),
    ],
)
def test_splits_are_checked(tiny_store: Path, tmp_path: Path, file: str, spoil) -> None:
    """A split's table or document that is gone or changed is damage; whole ones are not (the negative control)."""
    assert "store-split" not in found(tiny_store)
    store = copy_tree(tiny_store, tmp_path / "ds.zarr")
    spoil(store / "splits" / file)
    said = [one for one in check(store, images=False) if one.code == "store-split"]
    assert {one.severity for one in said} == {"damage"}


def test_progress_ends_at_its_total(folder: Path) -> None:
    """Who watches a check is told of every recording and every image, in order, up to the whole."""
    told: list[tuple[int, int]] = []
    check(folder, progress=lambda done, total, _: told.append((done, total)))
    store = Store.open(folder)
    assert told[-1] == (2 + store.n_frames, 2 + store.n_frames)
    assert told == sorted(told)

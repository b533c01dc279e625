"""Pipes, devices and endless documents in the place of a store's files are refused in words, and not read."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from copied_trees import copy_tree

from tactiledata.errors import StoreError
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store

WORDS = "is a pipe or a device, or a link to one; expected a file"


def one_of(folder: Path, pattern: str) -> Path:
    """The first file of a store that has such a name."""
    return min(folder.glob(pattern))


@pytest.fixture
def folder(tiny_store: Path, tmp_path: Path) -> Path:
    """A copy of the tiny store."""
    return copy_tree(tiny_store, tmp_path / "ds.zarr")


def in_its_place(place: Path, kind: str) -> None:
    """A pipe, or a link to a device that never ends, instead of a file."""
    place.unlink()
    if kind == "pipe":
        os.mkfifo(place)
    else:
        place.symlink_to("/dev/zero")


@pytest.mark.parametrize("kind", ["pipe", "device"])
@pytest.mark.parametrize(
    "pattern",
    [
        "index/sources.parquet/*.parquet",
        "index/frames.parquet/*.parquet",
        "streams/digit/heap/c.0",
        "signals/wrench/value/c.0.0",
        "sensors.json",
        "splits/default.json",
        "splits/default.parquet",
    ],
)
def test_a_pipe_or_a_device_is_found_and_not_read(folder: Path, kind: str, pattern: str) -> None:
    """The check reports damage and ends, where it read a device without end and waited for a pipe."""
    in_its_place(one_of(folder, pattern), kind)
    assert "damage" in {finding.severity for finding in check(folder)}


@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_a_manifest_that_is_no_file_is_refused(folder: Path, kind: str) -> None:
    """A store whose manifest is a pipe or a device is not opened."""
    in_its_place(folder / "manifest.json", kind)
    with pytest.raises(StoreError, match=WORDS):
        Store.open(folder)


def test_a_table_that_is_a_device_is_named(folder: Path) -> None:
    """Whoever reads the table is told which file it is."""
    place = one_of(folder, "index/sources.parquet/*.parquet")
    in_its_place(place, "device")
    with pytest.raises(StoreError, match=f"{place.name} {WORDS}"):
        Store.open(folder).sources()


def test_brackets_without_end_are_no_facts_of_sensors(folder: Path) -> None:
    """`sensors.json` of brackets alone is refused in words, as other documents are."""
    (folder / "sensors.json").write_bytes(b"[" * 100_000)
    with pytest.raises(StoreError, match=r"sensors\.json does not hold the sensors"):
        Store.open(folder).sensors()


@pytest.mark.parametrize("value", ["NaN", "1e999", '"\\ud800"'])
def test_facts_without_a_digest_are_refused(folder: Path, value: str) -> None:
    """Numbers that are not finite and halves of letters in `sensors.json` are refused, and found by the check."""
    place = folder / "sensors.json"
    facts = json.loads(place.read_text())
    sensor = next(iter(facts))
    facts[sensor] = {"odd": "HERE"}
    place.write_text(json.dumps(facts).replace('"HERE"', value))
    assert "damage" in {finding.severity for finding in check(folder)}
    with pytest.raises(StoreError, match=r"sensors\.json does not hold the sensors"):
        Store.open(folder).sensors()


def test_a_table_of_a_split_that_is_a_pipe_is_named(folder: Path) -> None:
    """The finding names the table, not the document that is whole."""
    in_its_place(folder / "splits/default.parquet", "pipe")
    [finding] = [one for one in check(folder, images=False) if one.code == "store-split"]
    assert "default.parquet is a pipe or a device" in finding.message


def test_a_changed_chunk_is_told_in_words(folder: Path) -> None:
    """A chunk whose bytes were changed is refused, and no raw bytes stand in the sentence."""
    place = one_of(folder, "signals/wrench/value/c.*")
    content = bytearray(place.read_bytes())
    content[len(content) // 2] ^= 1
    place.write_bytes(content)
    with pytest.raises(StoreError, match="do not fit their checksum; expected a chunk") as error:
        Store.open(folder).signal("wrench").values(0, 5)
    assert "b'" not in str(error.value)


def test_a_fill_value_beyond_its_type_is_damage(folder: Path) -> None:
    """A number that the array's type cannot hold is found by the check and refused by a reader."""
    place = folder / "signals" / "wrench" / "t_ns" / "zarr.json"
    document = json.loads(place.read_text())
    document["fill_value"] = 10**30
    place.write_text(json.dumps(document))
    assert "damage" in {finding.severity for finding in check(folder)}
    with pytest.raises(StoreError, match="metadata that cannot be read"):
        Store.open(folder).signal("wrench").t_ns(0, 5)


def test_chunks_without_rows_are_damage(folder: Path) -> None:
    """Chunks of no rows, which zarr opens, are found by the check and refused by a reader."""
    place = folder / "signals" / "wrench" / "value" / "zarr.json"
    document = json.loads(place.read_text())
    document["chunk_grid"]["configuration"]["chunk_shape"][0] = 0
    place.write_text(json.dumps(document))
    assert "damage" in {finding.severity for finding in check(folder)}
    with pytest.raises(StoreError, match="metadata that cannot be read"):
        Store.open(folder).signal("wrench").values(0, 5)

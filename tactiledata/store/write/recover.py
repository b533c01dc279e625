"""What a killed writer left behind is removed, so that the store is what its manifest says and nothing else."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from tactiledata.contract.atomic import write_atomic
from tactiledata.errors import StoreError
from tactiledata.store.layout.arrays import clear_rows, drop_chunks, set_length
from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.images import ShardAppender, cut_chunk
from tactiledata.store.layout.manifest import Manifest, settings_of
from tactiledata.store.layout.places import (
    ALIGNED_ARRAYS,
    COMMITTING,
    HOMES,
    NUMBERS,
    SENSORS,
    SIGNAL_ARRAYS,
    STAGING,
    TABLES,
    aligned_path,
    frame_values_path,
    heap_path,
    home_of,
    reference_path,
    rgb_path,
    sensors_path,
    signal_path,
    table_folder,
)
from tactiledata.store.layout.sensors_table import Facts, changed_facts, parse_sensors, read_sensors, write_sensors
from tactiledata.store.read.meshes import mesh_arrays
from tactiledata.store.write.writer import find_staged


def row_arrays(manifest: Mapping[str, Any]) -> Iterator[tuple[str, int]]:
    """Paths of all arrays of numbers that a manifest names, with their lengths."""
    home = home_of(manifest)
    for name, facts in manifest["signals"].items():
        yield from ((signal_path(home, name, array), facts["rows"]) for array in SIGNAL_ARRAYS)
    for name, facts in manifest["aligned"].items():
        yield from ((aligned_path(home, name, array), facts["rows"]) for array in ALIGNED_ARRAYS)
    for name, facts in manifest["frame_values"].items():
        yield frame_values_path(home, name), facts["rows"]
    for name, facts in manifest.get("meshes", {}).items():
        yield from mesh_arrays(home, name, facts)


def heaps(manifest: Mapping[str, Any]) -> Iterator[tuple[str, int]]:
    """Paths of all heaps that a manifest names, with their bytes in use."""
    for camera, facts in manifest["cameras"].items():
        if facts["heap_bytes"]:
            yield heap_path(camera), facts["heap_bytes"]


def raw_arrays(manifest: Mapping[str, Any]) -> Iterator[tuple[str, tuple[int, int], int]]:
    """Paths of all arrays of raw frames that a manifest names, with frame size and number of frames."""
    for camera, facts in manifest["cameras"].items():
        for size, count in facts["rgb"].items():
            height, width = (int(side) for side in size.split("x"))
            yield rgb_path(camera, height, width), (height, width), count


def array_lengths(manifest: Mapping[str, Any]) -> dict[str, int]:
    """Rows of each array that grows, as a manifest names them, by the array's path."""
    raw = ((path, count) for path, _, count in raw_arrays(manifest))
    return dict([*row_arrays(manifest), *heaps(manifest), *raw])


def array_paths(manifest: Mapping[str, Any]) -> set[str]:
    """Paths of all arrays that a manifest names."""
    return set(array_lengths(manifest)) | {
        reference_path(home_of(manifest), sensor) for sensor in manifest["references"]
    }


def foreign_arrays(store_path: Path, manifest: Mapping[str, Any]) -> list[Path]:
    """Folders of arrays and groups that the manifest does not name; first those of numbers that were replaced."""
    named = array_paths(manifest)
    groups = {str(Path(path).parent) for path in named}
    home = home_of(manifest)
    strangers = [place for place in sorted(store_path.glob(f"{HOMES}*/")) if f"{place.name}/" != home]
    if home:
        strangers += [store_path / kind for kind in NUMBERS if (store_path / kind).is_dir()]
    for kind in ("streams", *(f"{home}{kind}" for kind in NUMBERS)):
        for group in sorted((store_path / kind).glob("*/")):
            if f"{kind}/{group.name}" not in groups:
                strangers.append(group)
                continue
            strangers += [
                array for array in sorted(group.glob("*/")) if f"{kind}/{group.name}/{array.name}" not in named
            ]
    return strangers


def foreign_parts(store_path: Path, manifest: Mapping[str, Any]) -> list[Path]:
    """Parts of tables that the manifest does not name."""
    strangers = []
    for table in TABLES:
        named = {part["file"] for part in manifest["index"][table]}
        folder = store_path / table_folder(table)
        strangers += [place for place in sorted(folder.glob("*.parquet")) if place.name not in named]
    return strangers


def temporary_files(store_path: Path) -> Iterator[Path]:
    """Files that a killed process was writing, outside the staging folder."""
    for folder, folders, names in os.walk(store_path):
        if STAGING in folders:
            folders.remove(STAGING)
        yield from (Path(folder) / name for name in names if name.startswith(".") and name.endswith(".part"))


def stale_staging(store_path: Path, manifest: Mapping[str, Any]) -> list[Path]:
    """Folders of takes that are half staged, or committed already."""
    whole = set(find_staged(store_path)) - set(manifest["sources"])
    return [place for place in sorted((store_path / STAGING).glob("*")) if place.is_dir() and place.name not in whole]


def clean_staging(store_path: Path, manifest: Manifest) -> None:
    """Takes removed that are half staged, or committed already; nobody else may be staging."""
    for folder in stale_staging(store_path, manifest):
        shutil.rmtree(folder)
    for place in (store_path / STAGING).glob(".*.part"):
        place.unlink()


def clean_commit(store_path: Path, manifest: Manifest) -> None:
    """What an interrupted commit left in arrays and tables removed; staged takes stay as they are."""
    for place in list(temporary_files(store_path)):
        place.unlink()
    if not is_interrupted(store_path):
        return
    drop_unnamed(store_path, manifest)
    with Batch(store_path) as batch:
        _shorten(batch, manifest)
        facts = sensors_before(store_path, manifest)
        if facts or (store_path / sensors_path(home_of(manifest))).exists():
            write_sensors(batch, manifest, facts)
        batch.publish()
    (store_path / STAGING / COMMITTING).unlink()


def begin_commit(store_path: Path, manifest: Manifest) -> None:
    """The marker that a commit has begun; it keeps the sensors' file as it was, which the commit may overwrite."""
    place = store_path / sensors_path(home_of(manifest))
    write_atomic(store_path / STAGING / COMMITTING, place.read_bytes() if place.is_file() else b"")


def sensors_before(store_path: Path, manifest: Mapping[str, Any]) -> Facts:
    """Facts of the sensors as the manifest has their digests, though an interrupted commit may have added to them."""
    facts = read_sensors(store_path, manifest)
    marker = store_path / STAGING / COMMITTING
    if not changed_facts(facts, manifest) or not marker.exists():
        return facts
    try:
        kept = parse_sensors(marker.read_bytes(), manifest, str(marker))
    except StoreError:  # the commit did not change them
        return facts
    return facts if changed_facts(kept, manifest) else kept


def drop_unnamed(store_path: Path, manifest: Mapping[str, Any]) -> None:
    """Arrays and parts of tables that the manifest does not name, removed.

    A folder goes in one moment: a reader that has it open would take chunks that are gone one by one for fill.
    """
    for folder in foreign_arrays(store_path, manifest):
        going = store_path / STAGING / f".{secrets.token_hex(8)}.part"
        going.parent.mkdir(exist_ok=True)
        folder.rename(going)
        shutil.rmtree(going)
    for place in foreign_parts(store_path, manifest):
        place.unlink()
    if home_of(manifest):
        (store_path / SENSORS).unlink(missing_ok=True)


def _shorten(batch: Batch, manifest: Manifest) -> None:
    store_path, settings = batch.root, settings_of(manifest)
    for path, length in row_arrays(manifest):
        clear_rows(batch, path, length)
    for path, used in heaps(manifest):
        chunk = settings.heap_chunk_bytes
        set_length(batch, path, used)
        drop_chunks(store_path / path, -(-used // chunk))
        if used % chunk:
            descriptor = os.open(store_path / path / f"c.{used // chunk}", os.O_WRONLY)
            try:
                cut_chunk(descriptor, used % chunk, chunk)
                batch.note(store_path / path / f"c.{used // chunk}")
            finally:
                os.close(descriptor)
    for path, size, count in raw_arrays(manifest):
        capacity = settings.frames_per_shard(*size)
        set_length(batch, path, count)
        drop_chunks(store_path / path, -(-count // capacity))
        if count % capacity:
            ShardAppender(batch, path, capacity, count).rewrite_tail()


def is_interrupted(store_path: Path) -> bool:
    """Whether a commit began and did not end."""
    return (store_path / STAGING / COMMITTING).exists()

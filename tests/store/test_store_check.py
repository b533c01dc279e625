"""Damage to any file of a store is found and named; what can be mended without inventing data is mended."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
import simplejpeg
from copied_trees import copy_tree
from random_takes import SMALL, random_images, staged_take

from tactiledata.contract.records import Image
from tactiledata.contract.take import FrameFlag
from tactiledata.errors import StoreError
from tactiledata.store.check.check import check
from tactiledata.store.check.repair import repair
from tactiledata.store.layout.manifest import write_manifest
from tactiledata.store.read.reader import Store
from tactiledata.store.write.commit import commit, create


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with every kind of content, committed twice."""
    folder = tmp_path_factory.mktemp("check") / "healthy"
    create(folder, SMALL)
    rng = np.random.default_rng(0)
    for group in ([1, 2], [3]):
        commit(folder, [staged_take(folder, seed, images=random_images(rng, 12))[0] for seed in group])
    return folder


@pytest.fixture
def folder(healthy: Path, tmp_path: Path) -> Path:
    """A copy to damage."""
    return copy_tree(healthy, tmp_path / "ds.zarr")


def codes(place: Path, **options) -> dict[str, str]:
    return {found.code: found.severity for found in check(place, **options)}


def flip(place: Path, position: int | None = None) -> None:
    """Turns one byte of a file."""
    content = bytearray(place.read_bytes())
    content[len(content) // 2 if position is None else position] ^= 0x55
    place.write_bytes(content)


def test_healthy_store_has_no_findings(healthy: Path) -> None:
    """A store that was written and left alone passes, decoding included (the negative control)."""
    assert check(healthy, decode=True) == []
    assert check(Store.open(healthy)) == []


FILES = {
    "index/frames.parquet/part-00000.parquet": "store-part",
    "index/sources.parquet/part-00001.parquet": "store-part",
    "signals/wrench/value/c.0.0": "store-values",
    "signals/wrench/value/zarr.json": "store-array",
    "aligned/wrench/gap_ns/c.0": "store-values",
    "reference/D1/image/c.0.0.0": "store-reference",
    "streams/digit/heap/c.0": "store-payload",
    "streams/digit/rgb_6x8/c.0.0.0.0": "store-payload",
    "sensors.json": "store-sensors",
}
"""Files of every kind, and the finding when they are damaged."""


def test_a_jpeg_that_decodes_to_a_damaged_picture_is_found(tmp_path: Path) -> None:
    """Bytes that were damaged before they were recorded fit their checksum, and decoders show what they can of them."""
    picture = np.random.default_rng(3).integers(0, 256, (32, 24, 3), np.uint8)
    whole = simplejpeg.encode_jpeg(picture, 95)
    damaged = bytearray(whole)
    damaged[len(whole) // 2 : len(whole) // 2 + 200] = bytes(200)
    assert simplejpeg.decode_jpeg(bytes(damaged), strict=False).shape == picture.shape
    create(tmp_path, SMALL)
    images = [Image("a", whole, "jpeg", 32, 24, 0), Image("a", bytes(damaged), "jpeg", 32, 24, 1)]
    commit(tmp_path, [staged_take(tmp_path, 2, images=images)[0]])
    [finding] = check(tmp_path, decode=True)
    assert finding.code == "store-payload"
    assert "frame 1: its JPEG decodes to a damaged picture" in finding.message
    repair(tmp_path, decode=True)
    assert Store.open(tmp_path).frames(["flags"])["flags"].to_pylist() == [0, FrameFlag.BROKEN]


@pytest.mark.parametrize("file", FILES)
@pytest.mark.parametrize("damage", ["flip", "cut", "remove"])
def test_damage_of_any_file_is_found(folder: Path, file: str, damage: str) -> None:
    """A byte turned, a file cut or removed gives a finding of the kind with severity damage, never an error."""
    place = folder / file
    if damage == "flip":
        flip(place, 10 if file.endswith(("heap/c.0", "zarr.json")) else None)
    elif damage == "cut":
        os.truncate(place, place.stat().st_size // 3)
    else:
        place.unlink()
    found = codes(folder, images=FILES[file] == "store-payload")
    assert found.get(FILES[file]) == "damage", found


def test_truncated_heap_loses_no_more_than_its_tail(folder: Path) -> None:
    """Cutting a heap's last chunk is reported for the frames behind the cut only."""
    store = Store.open(folder)
    frames = store.frames().to_pylist()
    last = max(int(place.name[2:]) for place in (folder / "streams/digit/heap").glob("c.*"))
    cut = last * SMALL.heap_chunk_bytes + 1
    os.truncate(folder / f"streams/digit/heap/c.{last}", 1)
    lost = [row for row, frame in enumerate(frames) if frame["length"] and frame["offset"] + frame["length"] > cut]
    found = [one for one in check(folder) if one.code == "store-payload"]
    assert lost
    assert found[0].count == len(lost)


@pytest.mark.slow
def test_repair_marks_broken_images(folder: Path) -> None:
    """Images that do not fit their CRC are marked, others stay readable, the manifest follows; twice is once."""
    before = Store.open(folder)
    kept = before.encoded(range(before.n_frames))
    flip(folder / "streams/digit/heap/c.0", 10)
    flip(folder / "streams/digit/rgb_6x8/c.0.0.0.0", 5)
    findings = repair(folder)
    assert {"store-mended", "store-payload-marked"} <= {found.code for found in findings}
    assert not [found for found in findings if found.severity == "damage"]
    store = Store.open(folder)
    flags = np.asarray(store.frames(["flags"])["flags"])
    broken = np.flatnonzero(flags & FrameFlag.BROKEN)
    assert len(broken) == 2
    assert store.digest != before.digest
    rest = np.setdiff1d(np.arange(store.n_frames), broken)
    assert store.encoded(rest) == [kept[row] for row in rest]
    for row in broken.tolist():
        with pytest.raises(StoreError, match=f"frame {row} "):
            store.images([row])
    manifest = (folder / "manifest.json").read_bytes()
    assert "store-mended" not in {found.code for found in repair(folder)}
    assert (folder / "manifest.json").read_bytes() == manifest


def test_repair_stretches_and_says_what_it_cannot(folder: Path) -> None:
    """A cut chunk is stretched so that Zarr can read it; a part that is lost stays a damage finding."""
    last = max(int(place.name[2:]) for place in (folder / "streams/digit/heap").glob("c.*"))
    place = folder / f"streams/digit/heap/c.{last}"
    used = Store.open(folder).manifest["cameras"]["digit"]["heap_bytes"] % SMALL.heap_chunk_bytes
    os.truncate(place, used)
    assert {found.code for found in repair(folder)} == {"store-mended"}
    assert place.stat().st_size == SMALL.heap_chunk_bytes
    flip(folder / "index/trajectories.parquet/part-00000.parquet")
    assert "store-part" in {found.code for found in repair(folder) if found.severity == "damage"}


def test_leftovers_are_said_and_removed(folder: Path) -> None:
    """Files that no manifest names are reported as harmless, and repair removes them."""
    (folder / "index/frames.parquet/part-00009.parquet").write_bytes(b"x")
    (folder / "signals/ghost").mkdir()
    (folder / ".staging" / ("0" * 64)).mkdir(parents=True)
    (folder / ".staging/committing").touch()
    assert codes(folder) == {"store-leftover": "info"}
    assert repair(folder) == []
    assert not (folder / "signals/ghost").exists()


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (lambda manifest: manifest["rows"].update(frames=10_000), "store-manifest"),
        (lambda manifest: manifest["signals"]["wrench"].update(rows=10_000), "store-array"),
        (lambda manifest: manifest["cameras"]["digit"].update(heap_bytes=1), "store-index"),
        (lambda manifest: manifest["cameras"].clear(), "store-index"),
        (lambda manifest: manifest["sources"].append("0" * 64), "store-manifest"),
    ],
)
def test_a_manifest_that_lies_is_found(folder: Path, change, code: str) -> None:
    """A manifest whose numbers do not fit the files is found out."""
    manifest = json.loads((folder / "manifest.json").read_bytes())
    change(manifest)
    write_manifest(folder, manifest)
    assert codes(folder, images=False).get(code) == "damage"


@pytest.mark.slow
def test_undecodable_image_is_found_when_asked(tmp_path: Path) -> None:
    """An image whose bytes are as recorded but are no picture is found by decoding only."""
    create(tmp_path, SMALL)
    commit(tmp_path, [staged_take(tmp_path, 2, images=[Image("a", b"no picture", "jpeg", 2, 3, 0)])[0]])
    assert check(tmp_path) == []
    [finding] = check(tmp_path, decode=True)
    assert (finding.code, finding.severity) == ("store-payload", "damage")
    # the command that is named marks it; without decoding it is not found
    assert "`check --decode --repair`" in finding.message
    repair(tmp_path)
    assert codes(tmp_path, decode=True) == {"store-payload": "damage"}
    repair(tmp_path, decode=True)
    assert codes(tmp_path, decode=True) == {}
    assert Store.open(tmp_path).frames(["flags"])["flags"].to_pylist() == [FrameFlag.BROKEN]

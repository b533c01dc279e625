"""Any bit of the manifest and of the other documents of a store that flips is reported, and nothing else is."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from copied_trees import copy_tree
from random_takes import SMALL, random_images, staged_take
from test_store_kill import in_child

from tactiledata.errors import StoreError, TactileDataError
from tactiledata.splits.make import make_split
from tactiledata.store.change.keep_sensors import keep_sensors, remove_picture
from tactiledata.store.check.check import check
from tactiledata.store.check.documents import document_findings
from tactiledata.store.check.repair import repair
from tactiledata.store.check.splits import split_findings
from tactiledata.store.layout.manifest import read_manifest
from tactiledata.store.read.reader import Store
from tactiledata.store.write import commit as committing
from tactiledata.store.write.commit import commit, create, recover

FLIPS = 200 if os.environ.get("TACTILE_REQUIRE_ALL") else 67
"""Bits turned in each document: of these, too, `make quick` tries a third."""
DOCUMENTS = (
    "manifest.json",
    "sensors.json",
    "README.md",
    "zarr.json",
    "signals/wrench/zarr.json",
    "signals/wrench/value/zarr.json",
    "streams/digit/heap/zarr.json",
    "reference/D1/image/zarr.json",
    "splits/default.json",
)


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with every kind of content and a split."""
    folder = tmp_path_factory.mktemp("digests") / "healthy"
    create(folder, SMALL)
    rng = np.random.default_rng(0)
    commit(folder, [staged_take(folder, seed, images=random_images(rng, 8))[0] for seed in range(2)])
    make_split(Store.open(folder), hold_out="none", force=None)
    return folder


@pytest.fixture
def folder(healthy: Path, tmp_path: Path) -> Path:
    """A copy to damage."""
    return copy_tree(healthy, tmp_path / "ds.zarr")


def documents_said(folder: Path) -> set[str]:
    """Codes of what is wrong with the documents, or the error where the store cannot even be opened."""
    try:
        store = Store.open(folder, damaged=True)
    except TactileDataError:
        return {"refused"}
    return {finding.code for finding in (*document_findings(store), *split_findings(store))} - {"store-no-digest"}


@pytest.mark.slow
@pytest.mark.parametrize("document", DOCUMENTS)
def test_every_bit_counts(folder: Path, document: str) -> None:
    """Each of 200 bits (67 in `make quick`) drawn from a document that flips is reported by its checks."""
    place = folder / document
    whole = place.read_bytes()
    assert documents_said(folder) == set()
    bits = np.random.default_rng(len(document)).choice(8 * len(whole), min(FLIPS, 8 * len(whole)), replace=False)
    missed = []
    for bit in bits.tolist():
        content = bytearray(whole)
        content[bit // 8] ^= 1 << bit % 8
        place.write_bytes(content)
        if not documents_said(folder):
            missed.append(bit)
    assert missed == []


def without_digests(folder: Path) -> None:
    """The store as it was written before there were digests of documents."""
    for path in ("manifest.json", "splits/default.json"):
        document = json.loads((folder / path).read_text())
        document.pop("file_sha256")
        document.pop("documents", None)
        (folder / path).write_text(json.dumps(document, sort_keys=True, indent=2, ensure_ascii=False) + "\n")


def test_a_store_without_digests_opens_and_says_so(folder: Path) -> None:
    """A store of the time before digests opens, grows and is not called damaged; repair records what is there."""
    without_digests(folder)
    said = check(folder)
    assert {(finding.code, finding.severity) for finding in said} == {("store-no-digest", "info")}
    assert any("written before" in finding.message for finding in said)
    mended = repair(folder)
    assert [finding.code for finding in mended] == ["store-mended", "store-no-digest"]
    assert "splits/default.json" in mended[1].message
    make_split(Store.open(folder), hold_out="none", force=None)
    assert check(folder) == []


def test_repair_blesses_no_damage(folder: Path) -> None:
    """A document that was changed stays damage through repairs, in stores with digests and with damage without them."""
    place = folder / "signals/wrench/value/zarr.json"
    place.write_bytes(place.read_bytes().replace(b'"units"', b'"unitz"'))
    for _ in range(2):
        assert {found.code for found in repair(folder) if found.severity == "damage"} == {"store-document"}
    with pytest.raises(StoreError, match=r"zarr\.json is not the file"):
        commit(folder, [staged_take(folder, 8)[0]])
    without_digests(folder)
    (folder / "index/frames.parquet/part-00000.parquet").unlink()
    repair(folder)
    assert "documents" not in read_manifest(folder)


def test_a_card_that_was_edited_is_written_anew(folder: Path) -> None:
    """Words added to the card are a warning, not damage, and repair takes them out."""
    before = (folder / "README.md").read_bytes()
    (folder / "README.md").write_bytes(before + b"mine")
    assert [(found.code, found.severity) for found in check(folder)] == [("store-card", "warning")]
    assert repair(folder) == []
    assert (folder / "README.md").read_bytes() == before


def test_a_damaged_manifest_is_not_read(folder: Path) -> None:
    """A column's name that changed in the manifest is no name to learn from: opening refuses, check goes on."""
    place = folder / "manifest.json"
    place.write_bytes(place.read_bytes().replace(b'"fx"', b'"fz"', 1))
    with pytest.raises(StoreError, match="own SHA-256"):
        Store.open(folder)
    assert [found.code for found in check(folder)] == ["store-manifest"]


def test_a_lost_document_is_found(folder: Path) -> None:
    """A group's zarr.json that is gone is damage."""
    (folder / "signals/wrench/zarr.json").unlink()
    assert "store-document" in {found.code for found in check(folder)}


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["write_manifest", "drop_unnamed"])
def test_killed_while_facts_of_a_sensor_are_added(folder: Path, moment: str) -> None:
    """A commit that adds a fact to a known sensor and is killed leaves no damage, and the same commit ends well."""
    take = staged_take(folder, 8, sensors={"D1": {"shore_00": 75}})[0]

    def work() -> None:
        setattr(committing, moment, lambda *_: os._exit(9))
        commit(folder, [take])

    in_child(work)
    assert {found.severity for found in check(folder)} <= {"info"}
    recover(folder)
    assert [found for found in check(folder) if found.code != "store-leftover"] == []
    commit(folder, [take])
    assert Store.open(folder).sensors()["D1"]["shore_00"] == 75
    assert check(folder) == []


def test_a_commit_while_a_store_is_checked_is_no_damage(folder: Path) -> None:
    """A store that grew after it was opened has documents ahead of what was opened: no damage."""
    opened = Store.open(folder)
    commit(folder, [staged_take(folder, 8, sensors={"D9": {"model": "digit"}})[0]])
    assert {found.code for found in document_findings(opened)} <= {"store-no-digest"}


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["write_manifest", "drop_unnamed", "write_card"])
@pytest.mark.parametrize("change", ["commit", "picture", "no picture"])
def test_killed_around_the_manifest(folder: Path, moment: str, change: str) -> None:
    """Killed just before any step of a change's end, a store has no damage, and after recovery no finding at all."""
    picture = Store.open(folder).reference("D1")
    take = staged_take(folder, 8)[0]

    def work() -> None:
        setattr(committing, moment, lambda *_: os._exit(9))
        if change == "commit":
            commit(folder, [take])
        elif change == "picture":
            keep_sensors(folder, {}, {"D9": picture})
        else:
            remove_picture(folder, "D1")

    in_child(work)
    assert {found.severity for found in check(folder)} <= {"info"}
    recover(folder)
    assert [found for found in check(folder) if found.code != "store-leftover"] == []
    keep_sensors(folder, {}, {"D8": picture})
    assert [found for found in check(folder) if found.code != "store-leftover"] == []

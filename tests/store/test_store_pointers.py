"""A store that was cloned without Git LFS says so, whichever of its files are pointers."""

import pytest
from copied_trees import copy_tree

from tactiledata.errors import NotFetched
from tactiledata.splits.manifest import read_split
from tactiledata.store.change.merge import merge
from tactiledata.store.check.check import check
from tactiledata.store.check.repair import repair
from tactiledata.store.read.reader import Store

POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"0" * 64 + b"\nsize 12345\n"
READS = {
    "manifest.json": lambda store: Store.open(store),
    "index/frames.parquet/part-00000.parquet": lambda store: Store.open(store).frames(),
    "sensors.json": lambda store: Store.open(store).sensors(),
    "signals/wrench/value/zarr.json": lambda store: Store.open(store).signal("wrench").values(0, 1),
    "signals/wrench/value/c.0.0": lambda store: Store.open(store).signal("wrench").values(0, 1),
    "reference/D20001/image/c.0.0.0": lambda store: Store.open(store).reference("D20001"),
    "reference/D20001/image/zarr.json": lambda store: Store.open(store).reference("D20001"),
    "streams/digit/heap/c.0": lambda store: Store.open(store).images([0]),
    "splits/default.json": lambda store: read_split(Store.open(store), "default"),
    "splits/default.parquet": lambda store: read_split(Store.open(store), "default"),
}


@pytest.fixture
def store(tiny_store, tmp_path):
    """A copy to put pointers into."""
    return copy_tree(tiny_store, tmp_path / "ds.zarr")


def contents(store):
    return {
        place: place.read_bytes() for place in store.rglob("*") if place.is_file() and not place.name.startswith(".")
    }


@pytest.mark.slow
@pytest.mark.parametrize("file", READS)
def test_a_pointer_is_named_where_it_is_read_and_by_check(store, file):
    """The error and the check name the file and what fetches it, and nothing is mended away."""
    assert (store / file).is_file()
    (store / file).write_bytes(POINTER)
    with pytest.raises(NotFetched, match=file) as caught:
        READS[file](store)
    assert "git lfs pull" in caught.value.remedy
    before = contents(store)
    if file == "manifest.json":
        with pytest.raises(NotFetched):
            check(store)
    else:
        (finding,) = (one for one in check(store) if one.code == "store-not-fetched")
        assert finding.severity == "damage"
        assert file in finding.message
        assert "git lfs pull" in finding.message
    with pytest.raises(NotFetched):
        repair(store)
    assert contents(store) == before


def test_all_of_them_are_one_finding(store):
    """However many files were not fetched, one sentence counts them; a store without any has no such finding."""
    assert [one.code for one in check(store) if one.code == "store-not-fetched"] == []
    parts = list((store / "index").rglob("*.parquet"))
    for place in parts:
        if place.is_file():
            place.write_bytes(POINTER)
    (finding,) = (one for one in check(store) if one.code == "store-not-fetched")
    assert finding.count == sum(place.is_file() for place in parts)


def test_a_merge_takes_no_pointer_for_content(store, tmp_path):
    """Nothing is merged from documents that were not fetched."""
    (store / "sensors.json").write_bytes(POINTER)
    with pytest.raises(ValueError, match="Git LFS pointer"):
        merge([store], tmp_path / "new.zarr")


@pytest.mark.slow
@pytest.mark.parametrize("file", [file for file in READS if file != "manifest.json"])
def test_the_remedy_is_said_once(store, file):
    """Whatever else follows from a pointer, one finding alone says what fetches it, and none says to restore a copy."""
    (store / file).write_bytes(POINTER)
    messages = [one.message for one in check(store)]
    assert sum("git lfs pull" in message for message in messages) == 1
    assert not [message for message in messages if "from a copy" in message and "Git LFS pointer" in message]


def test_a_writer_says_what_fetches_a_document(store, tmp_path):
    """What refuses a store whose document is a pointer says what fetches it, and not to restore it."""
    (store / "sensors.json").write_bytes(POINTER)
    with pytest.raises(NotFetched) as caught:
        merge([store], tmp_path / "new.zarr")
    assert "git lfs pull" in caught.value.remedy

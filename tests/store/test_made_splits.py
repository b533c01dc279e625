"""A split that is gone with all its files is noticed, and a store in which none was made says nothing."""

import shutil

import pytest
from copied_trees import copy_tree

from tactiledata.splits.make import make_split
from tactiledata.store.check.check import check
from tactiledata.store.check.repair import repair
from tactiledata.store.layout.made_splits import made_names, names_on_disk, remember_split
from tactiledata.store.read.reader import Store


@pytest.fixture
def store(tiny_store, tmp_path):
    """A copy with two splits."""
    folder = copy_tree(tiny_store, tmp_path / "ds.zarr")
    for name in ("default", "other"):
        make_split(Store.open(folder), name=name, hold_out="none", force=None, replace=True)
    return folder


def take_out(store, name):
    for suffix in (".json", ".parquet"):
        (store / "splits" / f"{name}{suffix}").unlink()


def gone(store):
    return [one for one in check(store) if one.code == "store-split-gone"]


def test_a_split_without_any_file_is_named(store):
    """Table and document gone: the check names the split, and only that one."""
    assert gone(store) == []
    take_out(store, "other")
    (finding,) = gone(store)
    assert finding.severity == "warning"
    assert "other" in finding.message
    assert "default" not in finding.message


def test_the_whole_folder_of_splits_is_missed(store):
    """Without the folder every split is named."""
    shutil.rmtree(store / "splits")
    assert gone(store)[0].count == 2


@pytest.mark.slow
def test_drawn_anew_or_taken_off_the_list_is_well_again(store):
    """The same command brings a split back; `check --repair` takes one off that was taken out on purpose."""
    take_out(store, "other")
    make_split(Store.open(store), name="other", hold_out="none", force=None)
    assert gone(store) == []
    take_out(store, "other")
    mended = repair(store)
    assert [one.code for one in mended if one.severity != "info"] == []
    assert any("other" in one.message for one in mended)
    assert gone(store) == []


def test_a_kill_before_the_list_leaves_a_whole_split(store, monkeypatch):
    """The name comes last: a split that was written and is not in the list is whole, and the next one lists it."""

    def killed(folder, name):
        raise KeyboardInterrupt

    monkeypatch.setattr("tactiledata.splits.manifest.remember_split", killed)
    with pytest.raises(KeyboardInterrupt):
        make_split(Store.open(store), name="third", hold_out="none", force=None)
    assert [one for one in check(store) if "split" in one.code] == []
    remember_split(store, "default")
    assert made_names((store / "splits.json").read_bytes()) == ["default", "other", "third"] == names_on_disk(store)


@pytest.mark.slow
def test_a_damaged_list_is_said_and_written_anew(store):
    """A flipped bit of the list is damage; the repair writes it of the splits that are there."""
    place = store / "splits.json"
    content = bytearray(place.read_bytes())
    content[len(content) // 2] ^= 1
    place.write_bytes(bytes(content))
    assert [one.stream for one in check(store) if one.code == "store-split"] == ["splits.json"]
    repair(store)
    assert made_names(place.read_bytes()) == ["default", "other"]


def test_a_store_without_a_list_is_as_before(store):
    """A store whose splits were made before there was a list is whole."""
    (store / "splits.json").unlink()
    assert check(store) == []

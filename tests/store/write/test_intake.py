"""A store that takes recordings in and gets none leaves no trace; whatever was there before stays."""

from pathlib import Path

import pytest

from tactiledata.errors import UsageError
from tactiledata.store.write import intake as module
from tactiledata.store.write.commit import create
from tactiledata.store.write.intake import intake


def stopped(store, beside=None):
    """Take recordings in, and stop before there are any, once somebody else put a file beside the store."""
    with intake(store):
        assert (store / "manifest.json").exists()
        if beside is not None:
            beside.touch()
        raise KeyError


def failing(store):
    with pytest.raises(KeyError):
        stopped(store)


def test_a_store_that_got_nothing_is_taken_away_again(tmp_path):
    """It is removed with the folders that were made for it; a user's empty folder and an older store stay."""
    failing(tmp_path / "new.zarr")
    failing(tmp_path / "made" / "for" / "new.zarr")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "mine").mkdir()
    failing(tmp_path / "mine")
    assert list((tmp_path / "mine").iterdir()) == []
    with intake(tmp_path / "kept.zarr"):
        ...
    assert not (tmp_path / "kept.zarr").exists()
    store = tmp_path / "ds.zarr"
    create(store)
    failing(store)
    assert (store / "manifest.json").exists()


def test_a_folder_in_which_others_put_something_stays(tmp_path):
    """What somebody else put meanwhile beside the store keeps the folder above it."""
    with pytest.raises(KeyError):
        stopped(tmp_path / "made" / "new.zarr", tmp_path / "made" / "notes.txt")
    assert [place.name for place in (tmp_path / "made").iterdir()] == ["notes.txt"]


def test_a_store_with_a_waiting_take_stays(tmp_path, monkeypatch):
    """What waits for its commit keeps the store, so that the next call goes on with it."""
    monkeypatch.setattr(module, "find_staged", lambda folder: {"a": 1})
    with intake(tmp_path / "ds.zarr"):
        ...
    assert (tmp_path / "ds.zarr" / "manifest.json").exists()


@pytest.mark.parametrize("place", ["s3://bucket/x.zarr", "gs://a/b", "file:///tmp/x.zarr"])
def test_an_address_does_not_become_a_folder(place, tmp_path, monkeypatch):
    """A store at an address is refused before anything is made; a folder with a colon in its name is a folder."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match="address"), intake(Path(place)):
        pass
    assert list(tmp_path.iterdir()) == []
    with intake(tmp_path / "day:1.zarr"):
        pass

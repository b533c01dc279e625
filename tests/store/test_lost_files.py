"""A file of a store that is gone is named, with the recordings in it and the command that brings them back."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.errors import LostFile, StoreError
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.check.check import check
from tactiledata.store.check.lost_files import ingest_again
from tactiledata.store.write.commit import store_errors


@pytest.fixture
def store(tiny_store, tmp_path):
    """A copy of a store of two recordings."""
    copy_tree(tiny_store, tmp_path / "ds.zarr")
    return tmp_path / "ds.zarr"


def put_back(capsys, store, logs, message):
    """Run the command that a message gives, with the true place of the recordings."""
    command = re.search(r"`(tactiledata ingest .*?)`", message)[1]
    words = [word.replace("PATH/TO/", f"{logs}/") for word in shlex.split(command)[1:]]
    assert run_command(capsys, *words)[0] == 0


@pytest.fixture
def logs(tiny_mcaps, tmp_path):
    """The recordings of the store, in one folder."""
    folder = tmp_path / "logs"
    folder.mkdir()
    for path in tiny_mcaps:
        shutil.copy(path, folder)
    return folder


def test_a_lost_chunk_of_numbers_is_a_missing_file(store, logs, capsys):
    """Not numbers that do not fit a CRC; the commands of the findings make the store whole again."""
    file = "signals/wrench/value/c.0.0"
    (store / file).unlink()
    found = check(store)
    assert {one.code for one in found} == {"store-values"}
    for one, log in zip(found, ("D20001.mcap", "D20002.mcap"), strict=True):
        assert f"of {log}: the file {file} is missing; " in one.message
    put_back(capsys, store, logs, found[0].message)
    assert check(store) == []


def test_numbers_that_changed_are_no_missing_file(store):
    """A chunk that is there and damaged is told as such, with the same remedy."""
    place = store / "signals/wrench/value/c.0.0"
    content = bytearray(place.read_bytes())
    content[len(content) // 2] ^= 0xFF
    place.write_bytes(content)
    found = check(store)
    assert found
    assert not [one for one in found if "is missing" in one.message]
    assert all("--replace`" in one.message for one in found)


def test_a_lost_file_of_images_is_told_once(store, logs, capsys):
    """One finding for the file, with how many images of which recordings lay in it."""
    [file] = (store / "streams/digit/heap").glob("c.*")
    file.unlink()
    [finding] = check(store)
    assert f"the file {file.relative_to(store)} is missing: " in finding.message
    assert "images of D20001.mcap, D20002.mcap lay in it" in finding.message
    put_back(capsys, store, logs, finding.message)
    assert check(store) == []


@pytest.mark.parametrize("table", ["sources", "frames", "trajectories"])
def test_ingest_refuses_a_store_that_lacks_an_index_file(store, logs, tmp_path, table):
    """One message, that does not call the store unharmed; nothing is added, and a whole store takes the recording."""
    [part] = (store / f"index/{table}.parquet").glob("*.parquet")
    aside = shutil.move(part, tmp_path / "aside")
    manifest = (store / "manifest.json").read_bytes()
    shutil.copy(logs / "D20001.mcap", logs / "more.mcap")
    with (logs / "more.mcap").open("ab") as stream:
        stream.write(b"behind")
    with pytest.raises(LostFile) as caught:
        ingest([logs], store)
    assert str(caught.value).count("expected") == 1
    assert "unharmed" not in str(caught.value)
    assert str(part.relative_to(store)) in caught.value.found
    assert (store / "manifest.json").read_bytes() == manifest
    shutil.move(aside, part)
    assert "added" in [source.state for source in ingest([logs], store).sources]


def test_a_lost_file_is_no_store_that_cannot_be_written(tmp_path):
    """What is missing is told as it is; what the system refuses becomes a store that cannot be written."""
    lost = LostFile("a file is missing", "it", "Restore it.")
    with pytest.raises(LostFile) as caught, store_errors(tmp_path):
        raise lost
    assert caught.value is lost
    with pytest.raises(StoreError, match="cannot be written"), store_errors(tmp_path):
        raise OSError(28, "No space left on device")


def test_many_recordings_are_not_all_named():
    """The command names a few recordings, else the folder that they lie in; an address is never written to."""
    assert "PATH/TO/a.mcap PATH/TO/b.mcap" in ingest_again("ds.zarr", ["a.mcap", "b.mcap"])
    assert "FOLDER_OF_THE_RECORDINGS" in ingest_again("ds.zarr", [f"{number}.mcap" for number in range(9)])
    assert "`" not in ingest_again("s3://bucket/ds.zarr", ["a.mcap"])
    assert Path("ds.zarr").name in ingest_again("ds.zarr", [])

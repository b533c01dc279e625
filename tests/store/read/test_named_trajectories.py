"""A name that several trajectories have is answered with the exact name to type for each, and what tells them apart."""

import hashlib
import re
import shutil

import pytest

from tactiledata.errors import UnknownName, UsageError
from tactiledata.ingest.pipeline import ingest
from tactiledata.store.change.merge import merge
from tactiledata.store.read.named_trajectories import full_names, named_trajectories
from tactiledata.store.read.reader import Store


@pytest.fixture
def twice(tiny_mcaps, tmp_path):
    """A merged store of two files of one name whose touches have the same names, and the digests of these files."""
    digests = []
    for number in range(2):
        place = tmp_path / str(number) / "run.mcap"
        place.parent.mkdir()
        shutil.copy(tiny_mcaps[0], place)
        with place.open("ab") as stream:
            stream.write(b"x" * number)
        digests.append(hashlib.sha256(place.read_bytes()).hexdigest())
        ingest([place], tmp_path / f"{number}.zarr")
    merge([tmp_path / "0.zarr", tmp_path / "1.zarr"], tmp_path / "ds.zarr")
    return Store.open(tmp_path / "ds.zarr"), digests


@pytest.mark.parametrize("form", ["own", "full"])
def test_each_candidate_has_a_name_that_works(twice, form):
    """Typing what stands before the brackets means the trajectory of the recording whose digest stands in them."""
    store, digests = twice
    own = store.trajectories(["trajectory"])["trajectory"].to_pylist()[0]
    with pytest.raises(UsageError, match="2 trajectories are called") as caught:
        named_trajectories(store, [own if form == "own" else f"run.mcap/{own}"])
    listed = re.findall(
        r"(\S+) \(of run\.mcap, SHA-256 (\w+)…, sensor D20001, \d+ images?, begins", caught.value.expected
    )
    assert [start for _, start in listed] == [digest[:12] for digest in digests]
    sources = store.trajectories(["source"])["source"].to_pylist()
    for number, (name, _) in enumerate(listed):
        [row] = named_trajectories(store, [name])
        assert sources[row] == number


def test_a_recording_and_its_touch_is_the_name_where_it_suffices(tiny_mcaps, tmp_path):
    """Files of different names need no uid."""
    for number, name in enumerate(("a.mcap", "b.mcap")):
        shutil.copy(tiny_mcaps[0], tmp_path / name)
        with (tmp_path / name).open("ab") as stream:
            stream.write(b"x" * number)
        ingest([tmp_path / name], tmp_path / "ds.zarr")
    store = Store.open(tmp_path / "ds.zarr")
    own = store.trajectories(["trajectory"])["trajectory"].to_pylist()[0]
    with pytest.raises(UsageError) as caught:
        named_trajectories(store, [own])
    assert f"a.mcap/{own} (of a.mcap" in caught.value.expected
    assert f"b.mcap/{own} (of b.mcap" in caught.value.expected
    assert named_trajectories(store, [f"b.mcap/{own}"]) == [full_names(store).index(f"b.mcap/{own}")]


def test_full_names_tell_recordings_of_one_name_apart(twice):
    """Each full name means its own trajectory, though two recordings have one name."""
    store, _ = twice
    names = full_names(store)
    assert {name.partition("/")[0] for name in names} == {"run.mcap~1", "run.mcap~2"}
    assert [named_trajectories(store, [name]) for name in names] == [[row] for row in range(len(names))]


def test_a_recording_means_all_its_trajectories(twice, tiny_store):
    """The name of a recording means all its trajectories; one that two have is refused with theirs."""
    store, digests = twice
    sources = store.trajectories(["source"])["source"].to_pylist()
    for number in range(2):
        rows = named_trajectories(store, [f"run.mcap~{number + 1}"], whole_recordings=True)
        assert rows == [row for row, source in enumerate(sources) if source == number]
    with pytest.raises(UsageError, match="2 recordings are called") as caught:
        named_trajectories(store, ["run.mcap"], whole_recordings=True)
    assert f"run.mcap~2 (SHA-256 {digests[1][:12]}…, 2 trajectories)" in caught.value.expected
    one = Store.open(tiny_store)
    assert named_trajectories(one, ["D20001.mcap"], whole_recordings=True) == [0, 1]
    with pytest.raises(UnknownName):
        named_trajectories(one, ["D20001.mcap"])
    with pytest.raises(UnknownName, match="trajectory or recording"):
        named_trajectories(one, ["D29999.mcap"], whole_recordings=True)


def test_a_name_that_is_clear_or_unknown(tiny_store):
    """One trajectory is found by each of its names, and an unknown name lists near ones."""
    store = Store.open(tiny_store)
    rows = store.trajectories(["uid", "trajectory"]).to_pylist()
    for row, full in enumerate(full_names(store)):
        names = [rows[row]["uid"], rows[row]["trajectory"], full]
        assert named_trajectories(store, names) == [row]
    with pytest.raises(UnknownName):
        named_trajectories(store, ["t99999"])

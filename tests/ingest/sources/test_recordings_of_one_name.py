"""Recordings of one name in several folders are told apart wherever they are listed; so are they named."""

import json
import shutil

import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.contract.records import Source
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.discover import named_apart
from tactiledata.store.read.reader import Store


@pytest.fixture
def days(tiny_mcaps, tmp_path):
    """Two folders, each with another recording called ``run.mcap``."""
    for number, day in enumerate(("monday", "tuesday")):
        (tmp_path / day).mkdir()
        shutil.copy(tiny_mcaps[number], tmp_path / day / "run.mcap")
    return tmp_path


@pytest.mark.parametrize(
    ("paths", "taken", "expected"),
    [
        (["/a/run", "/b/run"], [], ["a/run", "b/run"]),
        (["/a/x/run", "/b/x/run", "/run"], [], ["a/x/run", "b/x/run", "run"]),
        (["/a/run", "/b/other"], [], ["run", "other"]),
        (["/a/run", "/b/other"], ["run"], ["a/run", "other"]),
        (["/a/run"], ["run", "a/run"], ["a/run~2"]),
        (["/a/run", "/b/run"], ["a/run"], ["a/run~2", "b/run"]),
        (["/a/run", "/a/run"], [], ["a/run", "a/run~2"]),
    ],
    ids=["folders", "folders of one name", "other names", "taken", "taken whole", "one taken", "one file"],
)
def test_the_shortest_ends_of_paths_that_differ(paths, taken, expected):
    """A recording gets as many folders before its name as tell it apart, and a number where no folder does."""
    sources = [Source(path, path.rpartition("/")[2], "mcap", (path,)) for path in paths]
    assert [source.key for source in named_apart(sources, taken)] == expected


def test_ingest_and_inspect_name_recordings_of_one_name_by_their_folders(days, capsys):
    """Both print the folder with the name, and so the store calls them."""
    logs = [days / day / "run.mcap" for day in ("monday", "tuesday")]
    _, out, _ = run_command(capsys, "inspect", *logs)
    assert "monday/run.mcap: mcap" in out
    assert "tuesday/run.mcap: mcap" in out
    code, out, _ = run_command(capsys, "ingest", *logs, "--store", days / "ds.zarr")
    assert code == 0
    assert "tuesday/run.mcap" in out
    assert Store.open(days / "ds.zarr").sources(["key"])["key"].to_pylist() == ["monday/run.mcap", "tuesday/run.mcap"]


def test_a_later_recording_of_a_name_that_is_there_is_named_with_its_folder(days, capsys):
    """Two calls bring two recordings of one name; the first keeps its name, and a file that is there already, too."""
    ingest([days / "monday" / "run.mcap"], days / "ds.zarr")
    _, out, _ = run_command(capsys, "ingest", days / "tuesday" / "run.mcap", "--store", days / "ds.zarr", "--json")
    [source] = json.loads(out)["sources"]
    assert (source["state"], source["key"], source["name"]) == ("added", "tuesday/run.mcap", "tuesday/run.mcap")
    _, out, _ = run_command(capsys, "info", days / "ds.zarr", "--json")
    assert json.loads(out)["by_camera"]["digit"]["recordings"] == ["run.mcap", "tuesday/run.mcap"]
    for day, name in (("monday", "run.mcap"), ("tuesday", "tuesday/run.mcap")):
        [again] = ingest([days / day / "run.mcap"], days / "ds.zarr").sources
        assert (again.state, again.words) == ("present", name)


@pytest.mark.parametrize("moved", [False, True])
def test_an_edited_recording_finds_its_own_among_those_of_one_name(tiny_folders, tmp_path, moved):
    """An edited recording replaces, of two whose names end alike, the one that holds the same images."""
    logs = [copy_tree(log, tmp_path / day / "log") for log, day in zip(tiny_folders, ("mon", "tue"), strict=False)]
    store = tmp_path / "ds.zarr"
    ingest(logs, store)
    before = Store.open(store).sources(["sha256"])["sha256"].to_pylist()
    edited = copy_tree(logs[1], tmp_path / "elsewhere" / "log") if moved else logs[1]
    (edited / "log.yaml").write_text((edited / "log.yaml").read_text() + "\n# edited\n")
    [source] = ingest([edited], store, replace=True).sources
    assert (source.state, source.words) == ("replaced", "tue/log")
    after = Store.open(store).sources(["sha256"])["sha256"].to_pylist()
    assert len(after) == 2
    assert set(before) - set(after) == {before[1]}
    assert Store.open(store).sources(["key"])["key"].to_pylist() == ["mon/log", "tue/log"]


def test_inspect_takes_several_paths(tiny_mcaps, capsys):
    """Recordings that are named one by one are looked at as those of one folder are."""
    code, out, _ = run_command(capsys, "inspect", *tiny_mcaps, "--json")
    assert code == 0
    assert [source["key"] for source in json.loads(out)["sources"]] == [path.name for path in tiny_mcaps]
    code, out, _ = run_command(capsys, "inspect", *tiny_mcaps, "--suggest-mapping")
    assert code == 0
    assert "images:" in out

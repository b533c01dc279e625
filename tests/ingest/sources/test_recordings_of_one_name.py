"""Recordings of one name in several folders are told apart wherever they are listed; their keys stay."""

import json
import shutil

import pytest
from command import run_command

from tactiledata.contract.records import Source
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.discover import places_apart
from tactiledata.store.read.reader import Store


@pytest.fixture
def days(tiny_mcaps, tmp_path):
    """Two folders, each with another recording called ``run.mcap``."""
    for number, day in enumerate(("monday", "tuesday")):
        (tmp_path / day).mkdir()
        shutil.copy(tiny_mcaps[number], tmp_path / day / "run.mcap")
    return tmp_path


@pytest.mark.parametrize(
    ("paths", "expected"),
    [
        ({"run": "/a/run", "run~2": "/b/run"}, {"run": "a/run", "run~2": "b/run"}),
        ({"run": "/a/x/run", "run~2": "/b/x/run"}, {"run": "a/x/run", "run~2": "b/x/run"}),
        ({"run": "/a/run", "other": "/b/other"}, {}),
        ({"run~7": "/a/run~7"}, {}),
    ],
    ids=["folders", "folders of one name", "other names", "a name that ends like a number"],
)
def test_the_shortest_ends_of_paths_that_differ(paths, expected):
    """As many folders as needed stand before the name, and nothing where the name is enough."""
    assert places_apart([Source(path, key, "mcap", (path,)) for key, path in paths.items()]) == expected


def test_ingest_and_inspect_print_where_recordings_of_one_name_lie(days, capsys):
    """Both print the folder beside the name; the keys are those of before."""
    logs = [days / day / "run.mcap" for day in ("monday", "tuesday")]
    _, out, _ = run_command(capsys, "inspect", *logs)
    assert "run.mcap (monday/run.mcap): mcap" in out
    assert "run.mcap~2 (tuesday/run.mcap): mcap" in out
    code, out, _ = run_command(capsys, "ingest", *logs, "--store", days / "ds.zarr")
    assert code == 0
    assert "run.mcap~2 (tuesday/run.mcap)" in out
    assert Store.open(days / "ds.zarr").sources(["key"])["key"].to_pylist() == ["run.mcap", "run.mcap~2"]


def test_a_later_recording_of_a_name_that_is_there_gets_a_number(days, capsys):
    """Two calls bring two recordings of one key: the report calls the second one as the store does."""
    ingest([days / "monday" / "run.mcap"], days / "ds.zarr")
    _, out, _ = run_command(capsys, "ingest", days / "tuesday" / "run.mcap", "--store", days / "ds.zarr", "--json")
    [source] = json.loads(out)["sources"]
    assert (source["key"], source["name"], source["place"]) == ("run.mcap", "run.mcap~2", "")
    _, out, _ = run_command(capsys, "info", days / "ds.zarr", "--json")
    assert json.loads(out)["by_camera"]["digit"]["recordings"] == ["run.mcap~1", "run.mcap~2"]


def test_inspect_takes_several_paths(tiny_mcaps, capsys):
    """Recordings that are named one by one are looked at as those of one folder are."""
    code, out, _ = run_command(capsys, "inspect", *tiny_mcaps, "--json")
    assert code == 0
    assert [source["key"] for source in json.loads(out)["sources"]] == [path.name for path in tiny_mcaps]
    code, out, _ = run_command(capsys, "inspect", *tiny_mcaps, "--suggest-mapping")
    assert code == 0
    assert "images:" in out

"""What `info` and the page of a store say of recordings beside each other: cameras, copies."""

import json
import math
import re
import shlex

import pytest
from command import run_command
from copied_trees import copy_tree

from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.overview import page
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.store.read.flags import flagged_trajectories
from tactiledata.store.read.named_trajectories import full_names
from tactiledata.store.read.reader import Store


@pytest.fixture(scope="module")
def three(tiny_mcaps, tiny_folders, tmp_path_factory):
    """A store of a recording, a copy of it in another format, and one whose camera has another name; read only."""
    place = tmp_path_factory.mktemp("beside") / "three.zarr"
    ingest([tiny_mcaps[0], tiny_folders[0]], place)
    topic = "/digit/D20002/image_raw/compressed"
    mapping = {"format": "tactiledata-mapping/1", "images": {"tactile": {"topic": topic, "sensor": "D20002"}}}
    ingest([tiny_mcaps[1]], place, IngestOptions(mapping=mapping))
    return place


def test_info_lists_the_recordings_of_each_camera(three, capsys):
    """A row for each camera, with its images and recordings; as JSON all recordings are listed."""
    code, out, _ = run_command(capsys, "info", three)
    assert code == 0
    assert "recordings" in out
    _, out, _ = run_command(capsys, "info", three, "--json")
    cameras = json.loads(out)["by_camera"]
    assert {name: row["recordings"] for name, row in cameras.items()} == {
        "digit": ["D20001.mcap", "D20001"],
        "tactile": ["D20002.mcap"],
    }
    assert sum(row["frames"] for row in cameras.values()) == Store.open(three).n_frames


def test_info_lists_trajectories_when_asked(three, tmp_path, capsys):
    """Each by the name that `flag` takes, with what it holds and its flag; without the option none is listed."""
    place = copy_tree(three, tmp_path / "ds.zarr")
    name = full_names(Store.open(place))[1]
    run_command(capsys, "flag", place, name, "--reason", "slipped")
    code, out, _ = run_command(capsys, "info", place, "--trajectories")
    assert code == 0
    (row,) = [line for line in out.splitlines() if line.startswith(f"{name} ")]
    assert row.split()[-1] == "slipped"
    _, out, _ = run_command(capsys, "info", place, "--trajectories", "--json")
    listed = json.loads(out)["trajectory_list"]
    assert [row["name"] for row in listed] == full_names(Store.open(place))
    assert sum(row["images"] for row in listed) <= Store.open(place).n_frames
    assert [row["flag"] for row in listed[:2]] == ["", "slipped"]
    peaks = Store.open(place).trajectories(["peak_force"])["peak_force"].to_pylist()
    assert [row["peak_force"] for row in listed] == [None if math.isnan(peak) else peak for peak in peaks]
    _, out, _ = run_command(capsys, "info", place, "--json")
    assert "trajectory_list" not in json.loads(out)


def test_info_and_page_say_what_recordings_are_beside_each_other(three, capsys):
    """A camera of another name and a copy are remarked long after ingest: whole for people, and among all findings."""
    _, out, _ = run_command(capsys, "info", three)
    assert "camera 'tactile' has another name" in out
    assert "are in other recordings too: D20001 (2)" in out
    _, out, _ = run_command(capsys, "info", three, "--json")
    document = json.loads(out)
    assert document["findings"]["recording-twin"]["sources"] == 2
    assert [row["source"] for row in document["all_findings"] if row["code"] == "camera-names"] == ["D20002.mcap"]
    text = page(Store.open(three), None, "default")
    assert "has another name than cameras" in text
    assert "are in other recordings too" in text
    assert "<td>tactile</td>" in text


def test_a_store_without_copies_gets_no_remark(tiny_store, capsys):
    """Recordings of their own with one name for all cameras are not remarked."""
    _, out, _ = run_command(capsys, "info", tiny_store, "--json")
    assert not {"camera-names", "recording-twin"} & set(json.loads(out)["findings"])


def test_a_flag_names_the_copies_and_a_recording_is_flagged_whole(three, tmp_path, capsys):
    """The copies of a touch are named with a command that flags them; the finding's command leaves a copy out."""
    store = copy_tree(three, tmp_path / "ds.zarr")
    _, out, _ = run_command(capsys, "flag", store, "D20001.mcap/t00000", "--reason", "it slipped")
    assert "in other recordings, and stay in splits there: D20001/t00000" in out
    [command] = re.findall("to flag these, too: tactiledata (.*)", out)
    code, out, _ = run_command(capsys, *shlex.split(command))
    assert (code, "in other recordings" in out) == (0, False)
    for name in ("D20001.mcap", "D20001"):
        run_command(capsys, "flag", store, name, "--remove")
    assert not flagged_trajectories(Store.open(store))
    _, out, _ = run_command(capsys, "info", store, "--json")
    [sentence] = [
        row["message"]
        for row in json.loads(out)["all_findings"]
        if (row["code"], row["source"]) == ("recording-twin", "D20001")
    ]
    code, out, _ = run_command(capsys, *shlex.split(sentence.partition("after: tactiledata ")[2]))
    assert code == 0, out
    assert "stay in splits there: D20001.mcap/t00000" in out
    assert "to flag these" not in out  # it would leave no copy
    assert [flag.name for flag in flagged_trajectories(Store.open(store)).values()] == [
        "D20001/t00000",
        "D20001/t00002",
    ]
    _, out, _ = run_command(capsys, "info", store, "--json")
    assert "recording-twin" not in json.loads(out)["findings"]


def test_a_flag_without_copies_says_nothing_of_them(tiny_store, tmp_path, capsys):
    """A touch that is in one recording alone is flagged, and no copy is named."""
    store = copy_tree(tiny_store, tmp_path / "ds.zarr")
    code, out, _ = run_command(capsys, "flag", store, "D20001.mcap", "--reason", "the gel was torn")
    assert (code, out.count("flagged: D20001.mcap/"), "other recordings" in out) == (0, 2, False)

"""What `info` and the page of a store say of recordings beside each other: cameras, copies."""

import json

import pytest
from command import run_command

from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.sources.overview import page
from tactiledata.ingest.trajectories.assemble import IngestOptions
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

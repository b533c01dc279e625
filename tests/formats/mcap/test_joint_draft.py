"""One mapping for a folder of recordings: it reads the topics of all of them, and says which only some have."""

import json

import numpy as np
import pytest
import yaml
from command import run_command
from generators.mcap_files import KINDS, START, STEP, Tape, picture, ros_message

from tactiledata.contract.schema import check_document
from tactiledata.formats.mcap.mapping_draft import STATE_ALL, STATE_MORE
from tactiledata.formats.mcap.mcap import McapFormat
from tactiledata.store.read.reader import Store

FORMAT = McapFormat()


def recorded(path, *wrenches, serial="D20001", cameras=("/digit/image",)):
    """A recording of five messages on each topic; those of the first camera say its serial as their frame."""
    with Tape(path) as tape:
        for index in range(5):
            time = START + index * STEP
            for topic in wrenches:
                tape.ros(topic, time, ros_message("wrench", time, np.full(6, index)), KINDS["wrench"])
            for topic in cameras:
                tape.image(time, time, picture(index), topic=topic, frame=serial if topic == "/digit/image" else "")


@pytest.fixture
def folder(tmp_path):
    """Three recordings: the second has a camera more, the third another sensor and another force topic."""
    recorded(tmp_path / "run0.mcap", "/lab/force")
    recorded(tmp_path / "run1.mcap", "/lab/force", cameras=("/digit/image", "/gelsight/image"))
    recorded(tmp_path / "run2.mcap", "/lab/ft", serial="D20002")
    return tmp_path


def test_a_draft_is_made_from_all_recordings(folder, capsys):
    """Topics of every file are in the draft, and its first lines say which of them only some files have."""
    code, text, _ = run_command(capsys, "inspect", folder, "--suggest-mapping")
    assert code == 0
    drafted = yaml.safe_load(text)
    assert set(drafted["images"]) == {"digit", "gelsight"}
    assert "#   topic: /lab/ft" in text
    head = text[: text.index("format:")]
    assert "Drafted from 3 recordings" in head
    assert "/gelsight/image: 1 of 3" in head
    assert "/lab/force: 2 of 3" in head
    assert "/digit/image" not in head


def test_a_serial_of_one_recording_is_not_given_to_another(folder, capsys):
    """A mapping drafted from recordings of different sensors names none, so that each recording keeps its own."""
    text = run_command(capsys, "inspect", folder, "--suggest-mapping")[1]
    drafted = yaml.safe_load(text)
    assert drafted["images"]["digit"] == {"topic": "/digit/image"}
    assert {"D20001", "D20002"} <= set(drafted["description"]["sensors"])
    (folder / "mapping.yaml").write_text(text, encoding="utf-8")
    code, out, _ = run_command(capsys, "ingest", folder, "--mapping", folder / "mapping.yaml", "--store", folder / "s")
    assert code == 0, out
    sensors = json.loads(run_command(capsys, "info", folder / "s", "--json")[1])["by_sensor"]
    assert (sensors["D20001"]["frames"], sensors["D20002"]["frames"]) == (10, 5)


def test_recordings_alike_give_the_draft_of_one(tmp_path, capsys):
    """Recordings with the same topics give the draft of a single one, and a line that says so."""
    for number in range(2):
        recorded(tmp_path / f"run{number}.mcap", "/lab/force")
    one = run_command(capsys, "inspect", tmp_path / "run0.mcap", "--suggest-mapping")[1]
    both = run_command(capsys, "inspect", tmp_path, "--suggest-mapping")[1]
    assert both.endswith(one)
    assert both.removesuffix(one).splitlines()[-1] == "# All of them have the same topics."
    assert not one.startswith("#")
    document = json.loads(run_command(capsys, "inspect", tmp_path, "--json")[1])
    assert document["suggested_mapping"] == yaml.safe_load(both)


@pytest.mark.parametrize("form", ["yaml", "json"])
def test_a_camera_of_several_topics_is_one(tmp_path, capsys, form):
    """Recordings with one camera each, whose topics differ by the sensor's serial, become one stream of the store."""
    for number in (1, 2):
        recorded(tmp_path / f"run{number}.mcap", "/lab/force", cameras=(f"/digit/D2000{number}/image",))
    text = run_command(capsys, "inspect", tmp_path, "--suggest-mapping", *["--json"] * (form == "json"))[1]
    drafted = json.loads(text) if form == "json" else yaml.safe_load(text)
    topics = ["/digit/D20001/image", "/digit/D20002/image"]
    assert drafted["images"] == {"digit": {"topic": topics}}
    (tmp_path / f"mapping.{form}").write_text(text, encoding="utf-8")
    call = ("ingest", tmp_path, "--mapping", tmp_path / f"mapping.{form}", "--store", tmp_path / "s")
    assert run_command(capsys, *call)[0] == 0
    frames = Store.open(tmp_path / "s").frames(["camera", "sensor"])
    assert set(frames["camera"].to_pylist()) == {"digit"}
    assert set(frames["sensor"].to_pylist()) == {"D20001", "D20002"}


def test_a_draft_with_a_camera_of_several_topics_serves_again(tmp_path, capsys):
    """The folder that a draft was made from is inspected by it, and drafted by it once more, with the same topics."""
    for number, topic in enumerate(("/lab/left", "/lab/right")):
        recorded(tmp_path / f"run{number}.mcap", "/lab/force", cameras=(topic,))
    text = run_command(capsys, "inspect", tmp_path, "--suggest-mapping")[1]
    assert "where it is no tactile sensor" in text
    place = tmp_path / "mapping.yaml"
    place.write_text(text, encoding="utf-8")
    code, out, _ = run_command(capsys, "inspect", tmp_path, "--mapping", place, "--json")
    assert code == 0, out
    drafted = json.loads(out)["suggested_mapping"]["images"]
    assert [entry["topic"] for entry in drafted.values()] == [["/lab/left", "/lab/right"]]
    # negative control: a recording that has both is still refused
    recorded(tmp_path / "run2.mcap", "/lab/force", cameras=("/lab/left", "/lab/right"))
    code, out, _ = run_command(capsys, "inspect", tmp_path, "--mapping", place, "--json")
    assert code == 1
    (failed,) = json.loads(out)["failed"]
    assert "one recording has all of them" in failed["error"]


def test_two_cameras_of_a_recording_stay_two(tmp_path, capsys):
    """One recording with both topics has two cameras, whatever the other recordings have."""
    both = ("/digit/D20001/image", "/digit/D20002/image")
    recorded(tmp_path / "run1.mcap", "/lab/force", cameras=both)
    recorded(tmp_path / "run2.mcap", "/lab/force", cameras=both[1:])
    drafted = yaml.safe_load(run_command(capsys, "inspect", tmp_path, "--suggest-mapping")[1])
    assert [entry["topic"] for entry in drafted["images"].values()] == list(both)
    listing = {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": list(both)}}}
    (tmp_path / "mapping.yaml").write_text(yaml.safe_dump(listing), encoding="utf-8")
    code, out, err = run_command(capsys, "inspect", tmp_path / "run1.mcap", "--mapping", tmp_path / "mapping.yaml")
    assert code == 1
    assert "one recording has all of them" in out + err


def test_cameras_of_different_kinds_stay_two(tmp_path, capsys):
    """A DIGIT and a GelSight are no one camera, though each recording has one of them."""
    recorded(tmp_path / "run1.mcap", "/lab/force", cameras=("/digit/D20001/image",))
    recorded(tmp_path / "run2.mcap", "/lab/force", cameras=("/gelsight/image",))
    drafted = yaml.safe_load(run_command(capsys, "inspect", tmp_path, "--suggest-mapping")[1])
    assert set(drafted["images"]) == {"digit", "gelsight"}


def test_a_topic_of_two_types_is_told(tmp_path, capsys):
    """A topic that has another type in another recording is named with its types."""
    recorded(tmp_path / "run0.mcap", "/lab/force")
    with Tape(tmp_path / "run1.mcap") as tape:
        tape.ros("/lab/force", START, ros_message("tcp", START, [0, 0, 0, 0, 0, 0, 1]), KINDS["tcp"])
    text = run_command(capsys, "inspect", tmp_path, "--suggest-mapping")[1]
    [line] = [line for line in text.splitlines() if "/lab/force: geometry_msgs/WrenchStamped in " in line]
    assert "geometry_msgs/PoseStamped in " in line


def test_a_draft_of_nothing_is_none():
    """Without recordings that were looked at there is no draft."""
    assert FORMAT.draft([]) == (None, "")


@pytest.mark.parametrize("example", [STATE_ALL, STATE_MORE], ids=["no description yet", "beside sensors"])
def test_the_example_at_the_end_of_a_draft_is_a_mapping_once_its_marks_are_removed(example):
    """People remove the leading marks and ingest: what is then read has all that a description needs."""
    bare = "\n".join(line.removeprefix("#").removeprefix(" ") for line in example.splitlines()[1:])
    text = bare if bare.startswith("description:") else f"description:\n  sensors: {{D20001: {{model: digit}}}}\n{bare}"
    document = {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": "/digit"}}, **yaml.safe_load(text)}
    check_document(document, "mapping", "mapping.yaml")
    assert set(document["description"]) == {"sensors", "robot", "wrench"}

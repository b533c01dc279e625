"""The mapping that `inspect` suggests: valid as it stands, nothing dropped, and what a person must fill in marked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from generators.collect import codes, read
from generators.mcap_files import KINDS, START, TOPICS, Tape, numbers, picture, ros_message, touch, tree_message

from tactiledata.cli.main import run
from tactiledata.contract.schema import check_document
from tactiledata.formats.mcap.mcap import McapFormat
from tactiledata.formats.mcap.readers import UR_JOINTS

FORMAT = McapFormat()


def draft_of(path):
    """The suggested mapping, after its text was found to say the same and to fit its schema."""
    [source] = FORMAT.sources(Path(path))
    inspection = FORMAT.inspect(source)
    assert yaml.safe_load(inspection.suggested_text) == inspection.suggested_mapping
    check_document(inspection.suggested_mapping, "mapping", "the draft")
    return inspection


def two_wrenches(path):
    with Tape(path) as tape:
        for index in range(3):
            for topic in ("/a/force", "/lab/robotiq/force"):
                tape.ros(topic, START + index, ros_message("wrench", START, [index] * 6), KINDS["wrench"])


def test_of_two_force_sensors_both_are_offered(tmp_path):
    """The likelier one is active, the other one stands below it as a comment that can be taken instead."""
    two_wrenches(tmp_path / "run.mcap")
    inspection = draft_of(tmp_path / "run.mcap")
    assert inspection.suggested_mapping["signals"] == {"wrench": {"topic": "/lab/robotiq/force"}}
    assert "keep one" in inspection.suggested_text
    lines = inspection.suggested_text.splitlines()
    other = [line.replace("  # ", "  ", 1) for line in lines if line.startswith(("  # wrench:", "  #   topic:"))]
    assert yaml.safe_load("\n".join(other)) == {"wrench": {"topic": "/a/force"}}


def test_of_one_force_sensor_nothing_else_is_offered(tmp_path):
    """A recording whose topics are known has no alternatives and no remark in its draft."""
    touch(tmp_path / "run.mcap")
    text = draft_of(tmp_path / "run.mcap").suggested_text
    assert "keep one" not in text
    assert "# wrench:\n" not in text
    assert "REPLACE" not in text


def test_joint_names_come_from_the_first_message(tmp_path):
    """A driver's own joint names are filled in, base to wrist where they are a UR's, else to be ordered."""
    names = [f"left_{name}" for name in UR_JOINTS[::-1]]
    with Tape(tmp_path / "ur.mcap") as tape:
        tape.signal("joints", START, START, range(6), names=names)
    signals = draft_of(tmp_path / "ur.mcap").suggested_mapping["signals"]
    assert signals["joints"]["joint_names"] == names[::-1]
    with Tape(tmp_path / "other.mcap") as tape:
        axes = [f"axis{number}" for number in range(7)]
        tape.ros("/arm/state", START, ros_message("joints", START, range(7), names=axes), KINDS["joints"])
    inspection = draft_of(tmp_path / "other.mcap")
    assert inspection.suggested_mapping["signals"]["joints"]["joint_names"] == axes[:6]
    assert "from base to wrist; named: axis0" in inspection.suggested_text


def test_what_only_a_person_knows_is_marked(tmp_path):
    """Serials that no message says are placeholders that stand out, and the draft reads the recording as it is."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.image(START, START, picture(1), topic="/gelsight/image", frame="")
        tape.image(START, START, picture(2), topic="/digit/D20003/image", frame="")
    mapping = draft_of(tmp_path / "run.mcap").suggested_mapping
    assert mapping["images"]["gelsight"]["sensor"] == "REPLACE-with-serial-of-gelsight"
    assert mapping["images"]["digit"]["sensor"] == "D20003"
    assert mapping["description"]["sensors"] == {
        "D20003": {"model": "digit"},
        "REPLACE-with-serial-of-gelsight": {"model": "gelsight_r15"},
    }
    [(recording, sink)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert len(sink.images) == 2
    assert not codes(recording)


@pytest.mark.parametrize(("model", "name"), [("", "digit"), ("gelsight_r15", "gelsight"), ("biotac", "camera")])
def test_a_camera_without_a_name_is_named_by_its_model(tmp_path, model, name):
    """A draft names the only camera by its sensor's model where the name of its topic says nothing."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.image(START, START, picture(1), topic="/usb_cam/image_raw", frame="D20003")
        if model:
            tape.describe({"format": "tactiledata-log/1", "sensors": {"D20003": {"model": model}}})
    inspection = draft_of(tmp_path / "run.mcap")
    assert list(inspection.suggested_mapping["images"]) == [name]
    assert "remove it where it is no tactile sensor" in inspection.suggested_text


def test_a_tool_pose_is_offered_from_a_tree_that_has_it(tmp_path):
    """Where /tf joins a base and a tool, the draft reads tcp between the frames that are there, else not."""
    for name, child in (("has", "tool0"), ("has_not", "camera")):
        with Tape(tmp_path / f"{name}.mcap") as tape:
            for index in range(3):
                entries = [("base_link", child, numbers(3, 7)[index])]
                tape.ros("/tf", START + index, tree_message(START, entries), KINDS["tf"])
                tape.signal("wrench", START + index, START, [index] * 6)
    signals = draft_of(tmp_path / "has.mcap").suggested_mapping["signals"]
    assert signals["tcp"] == {"topic": "/tf", "frame": "base_link", "child_frame": "tool0"}
    assert "tcp" not in draft_of(tmp_path / "has_not.mcap").suggested_mapping["signals"]


def test_a_mapped_topic_is_not_called_unread(tmp_path):
    """Looked at with a mapping, a topic that it names carries no note of being left out; another one does."""
    with Tape(tmp_path / "run.mcap") as tape:
        for topic in ("/a/force", "/b/force"):
            tape.ros(topic, START, ros_message("wrench", START, [1] * 6), KINDS["wrench"])
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    mapping = {"format": "tactiledata-mapping/1", "signals": {"wrench": {"topic": "/a/force"}}}
    rows = {topic.name: (topic.role, topic.note) for topic in FORMAT.inspect(source, mapping).topics}
    assert rows["/a/force"] == ("wrench", "")
    assert rows["/b/force"][0] == ""
    assert "not read" in rows["/b/force"][1]


def test_a_folder_is_inspected_to_its_end(tmp_path, capsys, monkeypatch):
    """A file that cannot be read does not hide the others; the exit code is 1, and 0 without it."""
    touch(tmp_path / "a.mcap", count=4)
    (tmp_path / "b.mcap").write_bytes(b"no recording at all")
    touch(tmp_path / "c.mcap", count=4)

    def inspected():
        monkeypatch.setattr("sys.argv", ["tactiledata", "inspect", str(tmp_path)])
        with pytest.raises(SystemExit) as stop:
            run()
        return stop.value.code or 0, capsys.readouterr().out

    code, printed = inspected()
    assert code == 1
    assert "a.mcap: mcap" in printed
    assert "c.mcap: mcap" in printed
    assert "b.mcap: cannot be read" in printed
    (tmp_path / "b.mcap").unlink()
    assert inspected()[0] == 0


def test_two_arms_are_said_in_the_draft(tmp_path):
    """Joints of two robots in one topic: the draft takes six and says to choose."""
    names = [f"{arm}_{name}" for arm in ("a", "b") for name in UR_JOINTS]
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("joints", START, START, np.arange(12), names=names)
    signals = draft_of(tmp_path / "run.mcap").suggested_mapping["signals"]
    assert signals["joints"]["joint_names"] == names[:6]
    assert TOPICS["joints"] == signals["joints"]["topic"]

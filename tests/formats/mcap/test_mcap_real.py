"""Real MCAP files by others: each gives its messages, or a clear reason."""

from __future__ import annotations

from pathlib import Path

import pytest
from generators.collect import read

from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap.mcap import McapFormat

FOLDER = Path(__file__).parents[2] / "data" / "mcap"
FORMAT = McapFormat()
MESSAGES = {
    "ros2/cdr_test_0.mcap": {"/test_topic": 3, "/array_topic": 4},
    "ros2/talker.mcap": {"/rosout": 10, "/parameter_events": 0, "/topic": 10},
    "ros2/test_bag_for_seek_0.mcap": {"topic1": 5},
    "ros2/only_services.mcap": {"/add_two_ints/_service_event": 12},
    "ros2/wrong_rmw_test_0.mcap": {"/test_topic": 3, "/array_topic": 4},
    "foxglove/example.mcap": {"mouse": 111},
    "foxglove/example_logs.mcap": {"mouse": 111, "/rosout": 1000},
    "foxglove/custom-camera-model.mcap": {
        "/image/compressed": 10,
        "/camera_calibration": 10,
        "/camera_calibration/custom": 10,
    },
}
REASONS = {
    "ros2/only_services.mcap": "is a service or action",
    "ros2/wrong_rmw_test_0.mcap": "encoded as 'wrong_format/ros2msg'",
}


def inspected(path):
    [source] = FORMAT.sources(path)
    return FORMAT.inspect(source)


def test_every_real_file_is_listed():
    """No file of the fixtures is left out of the table."""
    assert {path.relative_to(FOLDER).as_posix() for path in FOLDER.glob("*/*.mcap")} == set(MESSAGES)


@pytest.mark.parametrize("name", sorted(MESSAGES))
def test_messages_or_a_reason(name):
    """All messages are counted, and each topic shows one decoded or says why not."""
    inspection = inspected(FOLDER / name)
    assert {topic.name: topic.messages for topic in inspection.topics} == MESSAGES[name]
    for topic in inspection.topics:
        if name in REASONS:
            assert REASONS[name] in topic.note
        elif topic.messages:
            assert topic.example.startswith("{")
            assert topic.note == ""
    said = {finding.code for finding in inspection.findings if finding.severity != "info"}
    assert said <= {"would-not-be-read"}


def test_examples_are_the_messages():
    """What is shown is what was said."""
    shown = {topic.name: topic.example for topic in inspected(FOLDER / "ros2/talker.mcap").topics}
    assert shown["/topic"] == "{data: 'Hello, world! 0'}"
    assert "minimal_publisher" in shown["/rosout"]


def test_a_real_split_bag_is_one_recording():
    """Five files, 6,074 messages as the metadata say."""
    inspection = inspected(FOLDER / "ros2/wbag")
    assert len(inspection.facts["files"]) == 5
    assert sum(topic.messages for topic in inspection.topics) == 6074


def test_the_folders_hold_independent_recordings():
    """A folder of recordings is as many sources, the split bag one of them."""
    assert [source.key for source in FORMAT.sources(FOLDER / "ros2")] == [
        "ros2/cdr_test_0.mcap",
        "ros2/only_services.mcap",
        "ros2/talker.mcap",
        "ros2/test_bag_for_seek_0.mcap",
        "ros2/wbag",
        "ros2/wrong_rmw_test_0.mcap",
    ]
    assert len(FORMAT.sources(FOLDER / "foxglove")) == 3


def test_real_json_images_are_read():
    """The only image topic of a recording is a camera; its JPEG bytes come out whole."""
    [(recording, sink)] = read(FORMAT, FOLDER / "foxglove/custom-camera-model.mcap")
    assert len(sink.images) == 10
    assert {(image.camera, image.encoding, image.height, image.width) for image in sink.images} == {
        ("camera", "jpeg", 360, 520)
    }
    assert all(image.payload.startswith(b"\xff\xd8") for image in sink.images)
    [left] = recording.findings
    assert (left.code, left.severity, left.count) == ("topics-not-read", "info", 2)


@pytest.mark.parametrize("name", sorted(set(MESSAGES) - {"foxglove/custom-camera-model.mcap"}))
def test_recordings_without_touch_are_refused_with_their_topics(name):
    """What holds no force, pose, joint or picture cannot be ingested, and the error lists what it holds."""
    with pytest.raises(BrokenLog, match="Its topics") as caught:
        read(FORMAT, FOLDER / name)
    assert all(topic in str(caught.value) for topic in MESSAGES[name])

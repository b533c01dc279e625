"""Messages that cannot be decoded say why in words about the message, and name the items that are there."""

import json

import numpy as np
import pytest
from generators.collect import read
from generators.mcap_files import START, STEP, TOPICS, Tape, numbers, ros_message, store

from tactiledata.errors import BrokenLog, SchemaError
from tactiledata.formats.mcap.mcap import McapFormat

FORMAT = McapFormat()
GOOD = b'{"v": 1, "w": [1, 2, 3]}'
OF_PYTHON = ("float()", "int too", "codec", "Expecting", "index out of range", "recursion", "unpack", "sys.", "list ")


def said_of(tmp_path, payload, field="v"):
    """What is said of one odd JSON message before a good one."""
    with Tape(tmp_path / "run.mcap") as tape:
        for index, content in enumerate((payload, GOOD)):
            tape.raw("/lab", START + index * STEP, content, "J", "jsonschema", "json", b"{}")
    mapping = {
        "format": "tactiledata-mapping/1",
        "clock": "log",
        "signals": {"odd": {"topic": "/lab", "fields": [field], "units": ["1"]}},
    }
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert len(recording.signals["odd"].values) == 1
    [finding] = [each for each in recording.findings if each.code == "undecodable-message"]
    return finding.message


@pytest.mark.parametrize(
    ("payload", "words"),
    [
        (b'{"v": null}', "'v' is null, and no number"),
        (b'{"v": "3 N"}', "'v' is the text '3 N', and no number"),
        (b'{"v": [1]}', "'v' is an array, and no number"),
        (b'{"v": {"x": 1}}', "'v' is a group of fields, and no number"),
        (b'{"v": 1' + b"0" * 400 + b"}", "'v' is beyond the largest number that is kept"),
        (b'{"v": ' + b"9" * 5000 + b"}", "a number in it has too many digits"),
        (b'{"v": ', "it is no JSON from character 7 on"),
        (b'{"v": "\xff"}', "it is no text from byte 8 on"),
        (b"[" * 100_000, "it nests too deeply"),
    ],
)
def test_json_that_is_no_number_is_said_in_words(tmp_path, payload, words):
    """What stands in the field, or where the JSON ends, and nothing of Python."""
    message = said_of(tmp_path, payload)
    assert message == f"1 message of /lab cannot be decoded: {words}"
    assert not [word for word in OF_PYTHON if word in message]


@pytest.mark.parametrize(
    ("payload", "words"),
    [(b'{"w": [1]}', "'w' has no item [2]"), (b'{"w": []}', "'w' is empty"), (b"{}", "no field 'w'")],
)
def test_an_array_that_is_too_short_is_said(tmp_path, payload, words):
    """The array and the item that it does not have; the message that has it is read."""
    assert words in said_of(tmp_path, payload, "w[2]")


def test_an_item_that_no_message_has_is_refused_with_those_that_are_there(tmp_path):
    """The mapping names an item beyond every array: what could be named is listed, as with a misspelt field."""
    mapping = {
        "format": "tactiledata-mapping/1",
        "clock": "log",
        "signals": {"odd": {"topic": "/lab", "fields": ["w[0]", "w[9]"], "units": ["1", "1"]}},
    }
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/lab", START, GOOD, "J", "jsonschema", "json", b"{}")
    with pytest.raises(SchemaError) as caught:
        read(FORMAT, tmp_path / "run.mcap", mapping)
    assert "names 'w[9]'" in caught.value.found
    assert caught.value.expected == "an item of 'w': w[0] to w[2]"
    assert caught.value.facts["path"] == "$.signals.odd.fields[1]"


def test_arrays_that_are_all_empty_do_not_cost_the_other_signals(tmp_path):
    """A driver that fills no efforts is no mistake of the mapping: the others are read, and the empty one is said."""
    mapping = {
        "format": "tactiledata-mapping/1",
        "clock": "log",
        "signals": {
            name: {"topic": "/lab", "fields": [field], "units": ["1"]} for name, field in (("v", "v"), ("w", "w[0]"))
        },
    }
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/lab", START, json.dumps({"v": 1, "w": []}).encode(), "J", "jsonschema", "json", b"{}")
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert recording.signals["v"].values.tolist() == [[1]]
    assert "1 message of /lab cannot be decoded: 'w' is empty" in [each.message for each in recording.findings]


@pytest.mark.parametrize("encoding", ["ros2msg", "ros1"])
@pytest.mark.parametrize("cut", [0, 3, 6, 20, -4])
def test_bytes_that_end_too_early_are_said_not_to_fit(tmp_path, encoding, cut):
    """A message of ROS that is cut anywhere: one sentence for all, without the decoder's."""
    rows, kind = numbers(2, 6, 1), "geometry_msgs/msg/WrenchStamped"
    with Tape(tmp_path / "run.mcap", encoding) as tape:
        whole = ros_message("wrench", START, rows[0], None, tape.is_ros1, None)
        tape.signal("wrench", START + STEP, START + STEP, rows[1])
        if tape.is_ros1:
            payload = bytes(store(True).serialize_ros1(whole, kind))
        else:
            payload = bytes(store().serialize_cdr(whole, kind))
        channel = next(iter(tape.channels.values())) if hasattr(tape, "channels") else 1
        tape.writer.add_message(channel, START + 2 * STEP, payload[: cut or 0], START + 2 * STEP)
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap")
    np.testing.assert_array_equal(recording.signals["wrench"].values, rows[1:])
    [finding] = [each for each in recording.findings if each.code == "undecodable-message"]
    topic = TOPICS["wrench"]
    words = "its bytes do not fit the type that the recording states for it"
    assert finding.message == f"1 message of {topic} cannot be decoded: {words}"


def test_a_recording_without_one_readable_message_says_so_in_words(tmp_path):
    """The error of a recording without any readable message says why one cannot be decoded, as the finding does."""
    mapping = {
        "format": "tactiledata-mapping/1",
        "clock": "log",
        "signals": {"odd": {"topic": "/lab", "fields": ["v"], "units": ["1"]}},
    }
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/lab", START, b'{"v": null}', "J", "jsonschema", "json", b"{}")
    with pytest.raises(BrokenLog, match="1 message of /lab cannot be decoded: 'v' is null, and no number"):
        read(FORMAT, tmp_path / "run.mcap", mapping)

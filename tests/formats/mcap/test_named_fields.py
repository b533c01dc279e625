"""A mapping names fields of messages and nothing else of the objects that hold them, whatever the kind of message."""

import json

import numpy as np
import pytest
from command import run_command
from generators.collect import codes, read
from generators.mcap_files import (
    START,
    STEP,
    TOPICS,
    Tape,
    numbers,
    proto_file,
    proto_payload,
    store,
)

from tactiledata.errors import SchemaError
from tactiledata.formats.mcap.mcap import McapFormat

FORMAT = McapFormat()
COUNT = 4
ROWS = numbers(COUNT, 6, 1)
ARRAY = "std_msgs/msg/Float64MultiArray"


def ros_array(values):
    types = store().types
    layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    return types[ARRAY](layout=layout, data=np.array(values))


def written(path, kind):
    """A recording of one kind of messages, each with six numbers; returns the topic and the path of the first."""
    encoding = {"ros1": "ros1", "idl": "ros2idl"}.get(kind, "ros2msg")
    with Tape(path, encoding) as tape:
        for index, row in enumerate(ROWS):
            at = START + index * STEP
            if kind in ("ros1", "ros2", "idl"):
                tape.signal("wrench", at, at, row)
            elif kind == "array":
                tape.ros("/lab", at, ros_array(row), ARRAY)
            elif kind == "json":
                tape.raw("/lab", at, json.dumps({"data": row.tolist(), "one": {"x": row[0]}}).encode(), "J",
                         "jsonschema", "json", b"{}")  # fmt: skip
            elif kind == "list":
                tape.raw("/lab", at, json.dumps(row.tolist()).encode(), "L", "jsonschema", "json", b"{}")
            else:
                force = dict(zip("xyz", row[:3].tolist(), strict=True))
                payload = proto_payload("foxglove.LabWrench", {"frame_id": "ft", "force": force})
                content = proto_file().SerializeToString()
                tape.raw("/lab", at, payload, "foxglove.LabWrench", "protobuf", "protobuf", content)
    first = {"array": "data[0]", "json": "data[0]", "list": "[0]", "protobuf": "force.x"}
    return ("/lab", first[kind]) if kind in first else (TOPICS["wrench"], "wrench.force.x")


def mapped(topic, *fields):
    signals = {"odd": {"topic": topic, "fields": list(fields), "units": ["1"] * len(fields)}}
    return {"format": "tactiledata-mapping/1", "clock": "log", "signals": signals}


NO_FIELDS = {
    "ros2": ["wrench.__sizeof__", "wrench.force.x.real", "wrench[0]", "__msgtype__", "header.stamp.real"],
    "idl": ["wrench.force.x.real", "wrench.__dataclass_fields__", "__doc__"],
    "ros1": ["wrench.force.x.real", "wrench.__eq__", "header.stamp.sec.denominator"],
    "array": ["data.size", "data.ndim", "data[0].real", "data[0][0]", "data[00].imag", "layout.__sizeof__"],
    "json": ["data.append", "data[0].real", "one.__len__", "one.x.imag", "one[0]", "one.values"],
    "list": ["[0].real", "__len__", "[0].numerator"],
    "protobuf": ["force.ByteSize", "force[0]", "DESCRIPTOR.fields", "force.DESCRIPTOR.index", "force.x.real"],
}  # fmt: skip
CASES = [(kind, path) for kind, paths in NO_FIELDS.items() for path in ("__class__.__name__", "forse.x", *paths)]


@pytest.mark.parametrize(("kind", "path"), CASES)
def test_what_is_no_field_is_refused(tmp_path, kind, path):
    """Attributes of the objects and fields that are not there: what was found, expected and can be done is said."""
    topic, first = written(tmp_path / "run.mcap", kind)
    with pytest.raises(SchemaError) as caught:
        read(FORMAT, tmp_path / "run.mcap", mapped(topic, first, path))
    error = caught.value
    assert f"signals.odd names {path!r}" in error.found
    assert topic in error.found
    assert error.expected
    assert "tactiledata inspect" in error.remedy
    assert error.facts["path"] == "$.signals.odd.fields[1]"


@pytest.mark.parametrize("kind", NO_FIELDS)
def test_what_is_a_field_is_read(tmp_path, kind):
    """Negative control: the first number of each message, exactly, of every kind."""
    topic, first = written(tmp_path / "run.mcap", kind)
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapped(topic, first))
    np.testing.assert_array_equal(recording.signals["odd"].values, ROWS[:, :1])
    assert "undecodable-message" not in codes(recording)


@pytest.mark.parametrize(
    ("kind", "path", "expected"),
    [
        ("ros2", "wrench.forse.x", "a field of 'wrench': force, torque"),
        ("array", "data.size", "an item of 'data': data[0] to data[5]"),
        ("json", "one.x.real", "'one.x' itself, which is a number"),
        ("json", "two", "a field of the message: data, one"),
        ("list", "two", "an item of the message: [0] to [5]"),
        ("protobuf", "force.w", "a field of 'force': x, y, z"),
        ("protobuf", "frame_id.title", "another field: 'frame_id' is a text"),
        ("protobuf", "frame_id[0]", "another field: 'frame_id' is a text"),
    ],
)
def test_what_could_have_been_meant_is_said(tmp_path, kind, path, expected):
    """The fields at the place where the path ends to lead, or what stands there."""
    topic, _ = written(tmp_path / "run.mcap", kind)
    with pytest.raises(SchemaError) as caught:
        read(FORMAT, tmp_path / "run.mcap", mapped(topic, path))
    assert caught.value.expected == expected


def test_a_field_that_some_messages_lack_is_damage(tmp_path):
    """JSON messages differ: those with the field are read, those without are counted, and nothing is refused."""
    with Tape(tmp_path / "run.mcap") as tape:
        for index, text in enumerate((b'{"w": 1}', b'{"v": 2}', b"[]", b'{"v": 4}')):
            tape.raw("/lab", START + index * STEP, text, "J", "jsonschema", "json", b"{}")
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapped("/lab", "v"))
    assert recording.signals["odd"].values.tolist() == [[2], [4]]
    [finding] = [one for one in recording.findings if one.code == "undecodable-message"]
    assert finding.count == 2
    assert "no field 'v'" in finding.message


def test_inspect_refuses_it_too(tmp_path, capsys):
    """The command ends with an error that names the place in the mapping."""
    topic, first = written(tmp_path / "run.mcap", "array")
    (tmp_path / "map.yaml").write_text(json.dumps(mapped(topic, first, "data.size")))
    code, _, said = run_command(capsys, "inspect", tmp_path / "run.mcap", "--mapping", tmp_path / "map.yaml")
    assert code == 1
    assert "names 'data.size'" in said
    assert "expected an item of 'data': data[0] to data[5]" in said


def test_an_integer_field_of_ros_is_read(tmp_path):
    """Negative control: fields deep in a header are fields."""
    topic, _ = written(tmp_path / "run.mcap", "ros2")
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapped(topic, "header.stamp.sec"))
    assert set(recording.signals["odd"].values[:, 0]) == {START // 10**9}


@pytest.mark.parametrize("one", ["1", 1, 1.0])
def test_a_bare_one_is_the_unit_of_a_field_without(tmp_path, one):
    """YAML reads an unquoted 1 as a number."""
    mapping = mapped(*written(tmp_path / "run.mcap", "json"))
    mapping["signals"]["odd"]["units"] = [one]
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert recording.signals["odd"].units == ("1",)


def test_another_number_is_no_unit(tmp_path):
    """Only 1 stands for a field without a unit."""
    mapping = mapped(*written(tmp_path / "run.mcap", "json"))
    mapping["signals"]["odd"]["units"] = [2]
    with pytest.raises(SchemaError, match=r"\$\.signals\.odd\.units\[0\]: 2 is greater than the maximum of 1"):
        read(FORMAT, tmp_path / "run.mcap", mapping)

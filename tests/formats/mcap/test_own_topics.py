"""Topics with names and types of one's own: the draft lists them all, and its lines read them once uncommented."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import yaml
from command import run_command
from generators.collect import read
from generators.mapping_drafts import FORMAT, NAMES, VALUES, draft, paragraphs, uncommented
from generators.mcap_files import (
    START,
    STEP,
    Tape,
    description,
    encoded,
    numbers,
    picture,
    proto_file,
    proto_payload,
    store,
    tree_message,
)
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import get_types_from_msg

from tactiledata.contract.schema import parse_document
from tactiledata.errors import SchemaError
from tactiledata.formats.mcap.contents import contents_of
from tactiledata.formats.mcap.likely_fields import proposal_for
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.trajectories.assemble import IngestOptions
from tactiledata.store.read.reader import Store

COUNT = 40
POSE = "lab_msgs/msg/ToolPose"
ARRAY = "std_msgs/msg/Float64MultiArray"
MAPPING = {"format": "tactiledata-mapping/1", "clock": "log"}


def array_message(values):
    types = store().types
    layout = types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    return types[ARRAY](layout=layout, data=np.array(values, dtype=np.float64))


def lab_pose(stamp_ns, pose):
    """A message of a type that nobody else has, as `Tape.raw` takes it."""
    types = store()
    text = "std_msgs/Header header\nfloat64[3] position\nfloat64[4] orientation\n"
    if POSE not in types.types:
        types.register(get_types_from_msg(text, POSE))
    stamp = types.types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    head = types.types["std_msgs/msg/Header"](stamp=stamp, frame_id="base")
    message = types.types[POSE](header=head, position=np.array(pose[:3]), orientation=np.array(pose[3:]))
    definition, _ = types.generate_msgdef(POSE, ros_version=2)
    return types.serialize_cdr(message, POSE), POSE, "ros2msg", "cdr", definition.encode()


@pytest.fixture(scope="module")
def two_names(tmp_path_factory):
    """The same touches under standard names and under own names and types."""
    folder = tmp_path_factory.mktemp("names")
    rows = {"wrench": numbers(COUNT, 6, 1), "tcp": numbers(COUNT, 7, 2), "joints": numbers(COUNT, 6, 3)}
    document = description(count=2, background="bg.png")
    with Tape(folder / "standard.mcap") as usual, Tape(folder / "own.mcap") as own:
        for index in range(COUNT):
            at = START + index * STEP
            for stream, values in rows.items():
                usual.signal(stream, at, at, values[index])
            usual.image(at, at, picture(index))
            own.ros("/lab/ft_raw", at, array_message(rows["wrench"][index]), ARRAY)
            own.raw("/lab/hand", at, *lab_pose(at, rows["tcp"][index]))
            arm = {"stamp": {"sec": at // 10**9, "nsec": at % 10**9}, "frame_id": "base_link"}
            arm["joint_angles"] = rows["joints"][index].tolist()
            own.raw("/lab/arm", at, json.dumps(arm).encode(), "Arm", "jsonschema", "json", b"{}")
            own.raw("/lab/note", at, b'{"text": "hello"}', "Note", "jsonschema", "json", b"{}")
            own.image(at, at, picture(index), topic="/usb_cam/image_raw")
        for tape in (usual, own):
            tape.describe(document, {"bg.png": encoded(picture(999))})
    return folder


def stored(path, mapping, target):
    report = ingest([path], target, IngestOptions(mapping=mapping))
    assert not [source.error for source in report.sources if source.error]
    return Store.open(target)


@pytest.mark.slow
def test_own_names_give_the_store_of_the_standard_names(two_names, tmp_path):
    """A draft that is uncommented and completed gives the same signals, aligned values and frames, bit by bit."""
    text = draft(two_names / "own.mcap")
    text = uncommented(text).replace("topic: /lab/ft_raw\n", "topic: /lab/ft_raw\n    frame: robotiq_ft_frame_id\n")
    mapping = parse_document(text, "the draft") | {"clock": "log"}
    ours = stored(two_names / "own.mcap", mapping, tmp_path / "own.zarr")
    theirs = stored(two_names / "standard.mcap", MAPPING, tmp_path / "standard.zarr")
    assert set(ours.signal_names) == set(theirs.signal_names) >= {"wrench", "tcp", "joints"}
    for name in theirs.signal_names:
        left, right = ours.signal(name), theirs.signal(name)
        assert (left.columns, left.units, left.frame) == (right.columns, right.units, right.frame)
        np.testing.assert_array_equal(left.t_ns(0, COUNT), right.t_ns(0, COUNT))
        np.testing.assert_array_equal(left.values(0, COUNT), right.values(0, COUNT))
    for name in theirs.aligned_names:
        for left, right in zip(ours.aligned(name), theirs.aligned(name), strict=True):
            np.testing.assert_array_equal(left, right)
    columns = ["t_ns", "trajectory", "sensor", "contact_force"]
    assert ours.frames(columns).equals(theirs.frames(columns))
    assert ours.n_frames == theirs.n_frames > 0


def test_every_topic_is_in_the_draft_with_what_it_holds(two_names):
    """Type, number, rate, fields with lengths and an example; what holds no numbers says so."""
    text = draft(two_names / "own.mcap")
    [source] = FORMAT.sources(two_names / "own.mcap")
    assert {topic.name for topic in FORMAT.inspect(source).topics} == {"/lab/ft_raw", "/lab/hand", "/lab/arm",
                                                                       "/lab/note", "/usb_cam/image_raw"}  # fmt: skip
    about = {name: next(part for part in paragraphs(text) if name in part) for name in ("ft_raw", "note", "usb_cam")}
    first = numbers(COUNT, 6, 1)[0]
    assert "/lab/ft_raw: std_msgs/Float64MultiArray (cdr/ros2msg), 40 messages, 100.0 Hz, no stamp" in about["ft_raw"]
    assert f"data: 6 numbers (float64), for example [{', '.join(f'{value:.6g}' for value in first)}]" in about["ft_raw"]
    assert "frame: NAME" in about["ft_raw"]
    assert "holds no numbers" in about["note"]
    assert "text: text, for example 'hello'" in about["note"]
    assert "tactile: remove it where it is no tactile sensor\n  digit:\n    topic: /usb_cam/image_raw\n" in text


def test_protobuf_of_an_own_type(tmp_path):
    """A wrench in a protobuf message is found by the names of its fields."""
    values = numbers(5, 6)
    with Tape(tmp_path / "run.mcap") as tape:
        for index, row in enumerate(values):
            parts = {
                name: dict(zip("xyz", part, strict=True))
                for name, part in (("force", row[:3].tolist()), ("torque", row[3:].tolist()))
            }
            payload = proto_payload("foxglove.LabWrench", {"frame_id": "ft", **parts})
            content = proto_file().SerializeToString()
            tape.raw("/lab", START + index, payload, "foxglove.LabWrench", "protobuf", "protobuf", content)
    mapping = parse_document(uncommented(draft(tmp_path / "run.mcap")), "the draft")
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    np.testing.assert_array_equal(recording.signals["wrench"].values, values)
    assert recording.signals["wrench"].frame == "ft"


def test_two_that_could_be_the_wrench_get_two_names(tmp_path):
    """The one whose name says force is called wrench, the other by its topic; both can be uncommented at once."""
    with Tape(tmp_path / "run.mcap") as tape:
        for topic in ("/a/numbers", "/b/force", "/wrench"):
            tape.ros(topic, START, array_message(range(6)), ARRAY)
        tape.signal("ur_wrench", START, START, range(6), topic="/odd")
    text = draft(tmp_path / "run.mcap")
    mapping = parse_document(uncommented(text), "the draft")
    topics = {name: entry["topic"] for name, entry in mapping["signals"].items()}
    assert topics["wrench"] == "/odd"
    assert set(topics.values()) == {"/a/numbers", "/b/force", "/wrench", "/odd"}
    assert "if this is the wrench, call it wrench" in text


def test_odd_topics_are_listed_and_cannot_break_the_draft(tmp_path):
    """Odd names, unreadable encodings, empty topics, lists, pictures, trees and huge numbers have their lines."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/a\nsignals:\u2028x", START, b'{"v": 1}', "A", "jsonschema", "json", b"{}")
        tape.raw("/list", START, b"[1, 2, 3]", "L", "jsonschema", "json", b"{}")
        tape.raw("/bare", START, b"5", "N", "jsonschema", "json", b"{}")
        tape.raw("/odd", START, b"12", "a/B", "flatbuffer", "flatbuffer", b"")
        tape.raw("/broken", START, b"{no json", "C", "jsonschema", "json", b"{}")
        tape.channel("/silent", "D", "jsonschema", "json", b"{}")
        tape.ros("/tf", START, tree_message(START, [("world", "thing", numbers(1, 7)[0])]), "tf2_msgs/msg/TFMessage")
        for topic in ("/digit/D20542/image", "/webcam"):
            tape.image(START, START, picture(1), topic=topic)
        tape.raw("/many", START, json.dumps({"v": list(range(5000))}).encode(), "M", "jsonschema", "json", b"{}")
        tape.raw("/huge", START, json.dumps({"v": -(10**400)}).encode(), "H", "jsonschema", "json", b"{}")
    text = draft(tmp_path / "run.mcap")
    for name in ("/a", "/list", "/bare", "/odd", "/broken", "/silent", "/tf", "/webcam", "/many", "/huge"):
        assert f"# # {name}" in text
    assert "world -> thing" in text
    assert "first 16 of 5,000 numbers" in text
    mapping = parse_document(uncommented(text, lambda topic: topic not in ("/tf", "/huge")), "the draft")
    assert "v: number, for example -inf" in text
    topics = [entry["topic"] for entry in mapping["signals"].values()]
    assert topics == ["/list", "/many"]
    [(recording, sink)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert recording.signals["list"].values.tolist() == [[1, 2, 3]]
    assert recording.signals["many"].values.tolist() == [list(range(16))]
    assert len(sink.images) == 2


def test_a_pose_with_a_rotation_vector_becomes_one_with_a_quaternion(tmp_path):
    """Six numbers of a pose, in mm by their size: a quarter turn about z by hand; its own new draft reads the same."""
    with Tape(tmp_path / "run.mcap") as tape:
        payload = json.dumps({"actual": [100, 200, -300, 0, 0, np.pi / 2]}).encode()
        tape.raw("/tool_pose", START, payload, "P", "jsonschema", "json", b"{}")
        tape.raw("/other_pose", START, payload, "P", "jsonschema", "json", b"{}")
    text = uncommented(draft(tmp_path / "run.mcap"))
    assert "positions beyond 10 are taken for millimetres" in text
    mapping = parse_document(text, "the draft")
    assert sorted(mapping["signals"]) == ["tcp", "tool_pose"]
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    for document in (mapping, FORMAT.inspect(source, mapping).suggested_mapping):
        [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", document)
        pose = recording.signals["tcp"]
        np.testing.assert_allclose(pose.values, [[0.1, 0.2, -0.3, 0, 0, 0.5**0.5, 0.5**0.5]], atol=1e-15)
        assert pose.units == ("m", "m", "m", "1", "1", "1", "1")


@pytest.mark.parametrize(
    ("message", "units", "pose"),
    [
        ({"x_mm": 100, "y_mm": 2, "z_mm": 3, "rx": 0, "ry": 0, "rz": np.pi / 2}, ["mm"] * 3 + ["rad"] * 3, 0.1),
        ({"x": 100, "y": 2, "z": 3, "rx_deg": 0, "ry_deg": 0, "rz_deg": 90}, ["m"] * 3 + ["deg"] * 3, 100.0),
        ({"x": 100, "y": 2, "z": 3, "rx": 0, "ry": 0, "rz": np.pi / 2}, ["mm"] * 3 + ["rad"] * 3, 0.1),
        ({"x": 9.9, "y": 2, "z": 3, "rx": 0, "ry": 0, "rz": np.pi / 2}, ["m"] * 3 + ["rad"] * 3, 9.9),
        ({"pos_mm": [100, 2, 3], "quat": [0, 0, 0.5**0.5, 0.5**0.5]}, ["mm"] * 3 + ["1"] * 4, 0.1),
    ],
    ids=["mm in names", "deg in names", "mm by size", "metres", "arrays"],
)
def test_units_are_proposed_by_names_then_by_sizes(tmp_path, message, units, pose):
    """A pose of one's own is proposed with the units that its fields' names or its size speak for, and so read."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/arm", START, json.dumps(message).encode(), "P", "jsonschema", "json", b"{}")
    mapping = parse_document(uncommented(draft(tmp_path / "run.mcap")), "the draft")
    assert mapping["signals"]["tcp"]["units"] == units
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    [read_pose] = recording.signals["tcp"].values
    assert read_pose[0] == pytest.approx(pose)
    np.testing.assert_allclose(read_pose[3:], [0, 0, 0.5**0.5, 0.5**0.5], atol=1e-15)


@pytest.mark.parametrize(
    ("name", "entry", "words"),
    [
        ("wrench", {"fields": ["v[0]"] * 6, "rotation": "rotation_vector"}, "states a rotation"),
        ("tcp", {"fields": ["v[0]"] * 7, "rotation": "rotation_vector"}, "has 7 fields; expected 6: x, y, z, rx"),
        ("tcp", {"fields": ["v[0]"] * 6}, "rotation: rotation_vector"),
        ("tcp", {"fields": ["v[0]"] * 6, "rotation": "rotation_vector", "units": ["m"] * 7}, "has 7 units; expected 6"),
        ("tcp", {"fields": ["v[0]"] * 6, "rotation": "rotation_vector", "units": ["m"] * 6}, "states 'm' for v"),
    ],
)
def test_a_rotation_that_does_not_fit_is_refused(tmp_path, name, entry, words):
    """A rotation belongs to a tcp with six fields; what does not fit is said."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/p", START, b'{"v": [1, 2, 3, 4, 5, 6]}', "P", "jsonschema", "json", b"{}")
    mapping = {"format": "tactiledata-mapping/1", "signals": {name: {"topic": "/p", **entry}}}
    with pytest.raises(SchemaError, match=re.escape(words)):
        read(FORMAT, tmp_path / "run.mcap", mapping)


def test_a_mapping_under_the_name_of_a_description_is_told_so(tmp_path):
    """run.yaml beside run.mcap is its description; a mapping that was saved there is named as one."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, range(6))
    (tmp_path / "run.yaml").write_text(draft(tmp_path / "run.mcap"), encoding="utf-8")
    with pytest.raises(SchemaError, match=r"run.yaml is a mapping.*Give the mapping another name"):
        read(FORMAT, tmp_path / "run.mcap")


def test_a_draft_can_be_written_beside_its_recording(tmp_path, capsys):
    """The shell makes an empty run.yaml before `inspect run.mcap --suggest-mapping > run.yaml` begins: the draft is
    written all the same, and an empty description is said.
    """
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, range(6))
    wanted = draft(tmp_path / "run.mcap")
    (tmp_path / "run.yaml").touch()
    code, out, _ = run_command(capsys, "inspect", tmp_path / "run.mcap", "--suggest-mapping")
    assert code == 0
    assert out == wanted
    recording, _ = read(FORMAT, tmp_path / "run.mcap")[0]
    (found,) = [finding for finding in recording.findings if finding.code == "description-empty"]
    assert (found.severity, found.message) == ("warning", "run.yaml is empty: it describes nothing")


@pytest.mark.slow
@given(messages=st.lists(st.dictionaries(NAMES, VALUES, max_size=5), min_size=1, max_size=4))
def test_whatever_the_draft_proposes_is_read(tmp_path_factory, messages):
    """Law: with all paragraphs uncommented, each proposal reads from its message the numbers at the fields it names."""
    path = tmp_path_factory.mktemp("law") / "run.mcap"
    with Tape(path) as tape:
        for index, message in enumerate(messages):
            tape.raw(f"/t{index}", START, json.dumps(message).encode(), "X", "jsonschema", "json", b"{}")
    text = draft(path)
    mapping = parse_document(uncommented(text), "the draft")
    for index in range(len(messages)):
        assert f"# # /t{index}: X (json/jsonschema), 1 message" in text
    if "signals" not in mapping:
        return
    [(recording, _)] = read(FORMAT, path, mapping)
    for name, entry in mapping["signals"].items():
        message = messages[int(entry["topic"][2:])]
        truth = [float(eval_path(message, field)) for field in entry["fields"]]
        np.testing.assert_array_equal(recording.signals[name].values, [truth])


def eval_path(message, path):
    """The value that a path leads to, by another way than the toolkit's."""
    for step in re.findall(r"\w+", path):
        message = message[int(step)] if isinstance(message, list) else message[step]
    return message


@pytest.mark.parametrize(
    ("topic", "message", "signal", "first"),
    [
        ("/a", {"Mz": 1, "Fx": 1, "Fy": 1, "Fz": 1, "Mx": 1, "My": 1}, "wrench", "Fx"),
        ("/a", {"moment": [1, 2, 3], "force": [1, 2, 3]}, "wrench", "force[0]"),
        ("/a", {"t": [1, 2, 3], "f": [1, 2, 3]}, "wrench", "f[0]"),
        ("/a", {"quat": dict.fromkeys("wxyz", 1), "pos": dict.fromkeys("xyz", 1)}, "tcp", "pos.x"),
        ("/a", {"time": 3.5, "v": [0] * 7}, "tcp", "v[0]"),
        ("/arm/joint_angles", {"v": [0] * 6}, "joints", "v[0]"),
        ("/tool_pose", {"v": [0] * 6}, "tcp", "v[0]"),
        ("/arm/joint_angles", {"v": [0] * 7}, None, None),
        ("/a", {"v": [0] * 5}, None, None),
        ("/a", {"fx": 1, "b": {"fx": 1}, "fy": 1, "fz": 1, "tx": 1, "ty": 1, "tz": 1}, None, None),
    ],
)
def test_proposals_go_by_names_then_by_numbers(topic, message, signal, first):
    """Fields called like a wrench's come in its order; six or seven numbers are proposed, other counts are not."""
    proposal = proposal_for(topic, contents_of(message).places)
    assert (proposal and proposal.signal, proposal and proposal.fields[0]) == (signal, first)


def test_the_draft_of_a_known_recording_is_yaml_without_paragraphs(tmp_path):
    """Negative control: where every topic is read, nothing is commented out."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, range(6))
    text = draft(tmp_path / "run.mcap")
    assert "# #" not in text
    assert yaml.safe_load(text)["signals"] == {"wrench": {"topic": "/robotiq_force_torque_sensor_broadcaster/wrench"}}

"""Pictures in messages of one's own type: the draft names their field, and a mapping reads them."""

from __future__ import annotations

import base64
import json
import re

import numpy as np
import pytest
from generators.collect import read
from generators.mapping_drafts import FORMAT, VALUES, draft, uncommented
from generators.mcap_files import START, STEP, Tape, encoded, picture, store
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import get_types_from_msg

from tactiledata.contract.schema import parse_document
from tactiledata.errors import SchemaError

LAB_CAMERA = "lab_msgs/msg/Shot"


def shot(payload):
    """A picture in a ROS message of an own type."""
    types = store()
    if LAB_CAMERA not in types.types:
        types.register(get_types_from_msg("int32 number\nuint8[] jpg\n", LAB_CAMERA))
    message = types.types[LAB_CAMERA](number=1, jpg=np.frombuffer(payload, np.uint8))
    definition, _ = types.generate_msgdef(LAB_CAMERA)
    return types.serialize_cdr(message, LAB_CAMERA), LAB_CAMERA, "ros2msg", "cdr", definition.encode()


def in_json(payload, before="", encode=base64.b64encode):
    """A picture in a JSON message, as base64 text inside a group of fields."""
    text = before + encode(payload).decode()
    content = json.dumps({"frame": {"number": 1, "jpg": text}}).encode()
    return content, "Shot", "jsonschema", "json", b"{}"


@pytest.mark.parametrize(
    ("made", "path"),
    [
        (in_json, "frame.jpg"),
        (lambda payload: in_json(payload, "data:image/jpeg;base64,"), "frame.jpg"),
        (lambda payload: in_json(payload, encode=base64.encodebytes), "frame.jpg"),
        (shot, "jpg"),
    ],
    ids=["json", "data uri", "lines", "ros"],
)
@pytest.mark.parametrize("suffix", [".jpg", ".png"])
def test_pictures_in_messages_of_an_own_type_are_proposed_and_read(tmp_path, made, path, suffix):
    """The draft names the field with the picture; with a serial it reads the bytes that went in."""
    payloads = [encoded(picture(index, 96, 72), suffix) for index in range(2)]
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, range(6))
        for index, payload in enumerate(payloads):
            tape.raw("/camera/shots", START + index * STEP, *made(payload))
    text = draft(tmp_path / "run.mcap")
    mapping = parse_document(text, "the draft")
    assert mapping["images"]["digit"]["data"] == path
    assert mapping["images"]["digit"]["topic"] == "/camera/shots"
    serial = mapping["images"]["digit"]["sensor"]
    [(_, sink)] = read(FORMAT, tmp_path / "run.mcap", parse_document(text.replace(serial, "D20542"), "the draft"))
    assert [(image.payload, image.sensor) for image in sink.images] == [(payload, "D20542") for payload in payloads]


def test_a_number_is_no_picture_however_large(tmp_path):
    """A ROS message whose field is a number of many digits is counted: no memory is taken for it."""
    types = store()
    text, kind = "int64 jpg\n", "lab_msgs/msg/Bomb"
    types.register({} if kind in types.types else get_types_from_msg(text, kind))
    payload = types.serialize_cdr(types.types[kind](jpg=10**15), kind)
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, range(6))
        tape.raw("/wrist", START, payload, kind, "ros2msg", "cdr", text.encode())
    mapping = {
        "format": "tactiledata-mapping/1",
        "images": {"digit": {"topic": "/wrist", "sensor": "D1", "data": "jpg"}},
    }
    [(recording, sink)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert not sink.images
    (found,) = [found for found in recording.findings if found.code == "undecodable-message"]
    assert "is a number, and no picture" in found.message


def test_two_pictures_in_one_message_are_two_cameras(tmp_path):
    """Left and right in one JSON message: the draft, and the draft of what it reads, have both, each with its field."""
    left, right = (encoded(picture(index, 96, 72), ".jpg") for index in range(2))
    content = {"left": base64.b64encode(left).decode(), "right": base64.b64encode(right).decode()}
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, range(6))
        tape.raw("/pair", START, json.dumps(content).encode(), "Pair", "jsonschema", "json", b"{}")
    mapping = parse_document(draft(tmp_path / "run.mcap"), "the draft")
    assert {name: entry["data"] for name, entry in mapping["images"].items()} == {"digit": "left", "digit_2": "right"}
    for serial, entry in zip(("D1", "D2"), mapping["images"].values(), strict=True):
        entry["sensor"] = serial
    mapping["description"] = {"sensors": {serial: {"model": "digit"} for serial in ("D1", "D2")}}
    [(_, sink)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert {(image.camera, image.payload) for image in sink.images} == {("digit", left), ("digit_2", right)}
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    again = FORMAT.inspect(source, mapping).suggested_mapping["images"]
    assert {name: entry["data"] for name, entry in again.items()} == {"digit": "left", "digit_2": "right"}


def test_beside_a_known_camera_pictures_of_an_own_type_stand_in_a_paragraph(tmp_path):
    """A topic that is read as a camera keeps its name; the other gets one of its own, once it is uncommented."""
    payload = encoded(picture(3, 96, 72), ".jpg")
    with Tape(tmp_path / "run.mcap") as tape:
        tape.image(START, START, picture(1), topic="/digit/D20542/image")
        tape.raw("/wrist", START, *in_json(payload))
    text = draft(tmp_path / "run.mcap")
    assert "frame.jpg: a JPEG as base64 text" in text
    assert parse_document(text, "the draft")["images"].keys() == {"digit"}
    mapping = parse_document(uncommented(text), "the draft")
    assert mapping["images"]["wrist"]["data"] == "frame.jpg"
    [(_, sink)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert payload in [image.payload for image in sink.images]


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({}, "of type Shot; expected one of sensor_msgs/Image"),
        ({"data": "frame..jpg"}, "is no path of fields"),
        ({"data": "frame.jpg", "channel_order": "bgr"}, "states a channel_order beside 'data'"),
    ],
)
def test_a_camera_that_does_not_fit_is_refused(tmp_path, entry, words):
    """A type that is no picture's needs the path of its picture, and only that."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/wrist", START, *in_json(encoded(picture(3))))
    mapping = {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": "/wrist", "sensor": "D1", **entry}}}
    with pytest.raises(SchemaError, match=re.escape(words)):
        read(FORMAT, tmp_path / "run.mcap", mapping)


@pytest.mark.parametrize(
    ("content", "code", "words"),
    [
        ({"frame": {"jpg": "no base64!"}}, "undecodable-message", "cannot be decoded"),
        ({"frame": {"jpg": base64.b64encode(b"no picture" * 20).decode()}}, "image-unreadable", "lost"),
        ({"frame": {"jpg": 7}}, "undecodable-message", "no picture"),
        ({"frame": {}}, "undecodable-message", "jpg"),
        ({"frame": {"jpg": [300, 1]}}, "undecodable-message", "cannot be decoded"),
    ],
)
def test_a_field_without_a_picture_is_counted(tmp_path, content, code, words):
    """What is no picture in the field that should hold one is a finding; the other pictures are read."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/wrist", START, *in_json(encoded(picture(3, 96, 72))))
        tape.raw("/wrist", START + STEP, json.dumps(content).encode(), "Shot", "jsonschema", "json", b"{}")
    entry = {"topic": "/wrist", "sensor": "D1", "data": "frame.jpg"}
    mapping = {"format": "tactiledata-mapping/1", "images": {"digit": entry}}
    [(recording, sink)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert sum(bool(image.payload) for image in sink.images) == 1
    assert [(found.code, words in found.message) for found in recording.findings if found.code == code] == [
        (code, True)
    ]


@pytest.mark.slow
@given(
    values=st.lists(
        VALUES
        | st.none()
        | st.binary(max_size=40).map(lambda value: base64.b64encode(b"\xff\xd8\xff" + value).decode()),
        min_size=1,
        max_size=5,
    )
)
def test_whatever_stands_where_a_picture_should_is_lost_or_read(tmp_path_factory, values):
    """Law: each message of a camera is a picture, a lost picture or a message that is counted; none is an error."""
    path = tmp_path_factory.mktemp("law") / "run.mcap"
    with Tape(path) as tape:
        tape.signal("wrench", START, START, range(6))
        for index, value in enumerate(values):
            content = json.dumps({"jpg": value}).encode()
            tape.raw("/wrist", START + index * STEP, content, "Shot", "jsonschema", "json", b"{}")
    entry = {"topic": "/wrist", "sensor": "D1", "data": "jpg"}
    [(recording, sink)] = read(FORMAT, path, {"format": "tactiledata-mapping/1", "images": {"digit": entry}})
    uncounted = len(values) - len(sink.images)
    assert uncounted == sum(found.count for found in recording.findings if found.code == "undecodable-message")
    assert all(not image.payload for image in sink.images if image.encoding == "missing")
    draft(path)

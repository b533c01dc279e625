"""Decoding: the fast readers agree with the general ones, and strangers' types cannot run."""

from __future__ import annotations

import numpy as np
import pytest
from generators.collect import codes, read
from generators.mcap_files import (
    KINDS,
    START,
    STEP,
    TOPICS,
    Tape,
    compressed_message,
    encoded,
    image_message,
    numbers,
    picture,
    ros_message,
    schema_text,
    store,
)
from hypothesis import given
from hypothesis import strategies as st
from mcap.records import Channel, Schema

from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap.cdr import (
    COMPRESSED_LAYOUT,
    IMAGE_LAYOUT,
    JOINT_LAYOUT,
    VECTOR_LAYOUTS,
    compressed_at,
    image_at,
)
from tactiledata.formats.mcap.collect import SignalBuffer
from tactiledata.formats.mcap.decode import Decoder, decoder_for
from tactiledata.formats.mcap.mcap import McapFormat
from tactiledata.formats.mcap.message_fields import frame_of, stamp_of, steps_of, value_at
from tactiledata.formats.mcap.readers import JointOrder, signal_taker
from tactiledata.formats.mcap.roles import SignalRole

FORMAT = McapFormat()


def decoder(kind, text=None, schema_encoding="ros2msg", message_encoding="cdr"):
    definition = (schema_text(kind, schema_encoding) if text is None else text).encode()
    schema = Schema(id=1, data=definition, encoding=schema_encoding, name=kind)
    return decoder_for(Channel(1, "/topic", message_encoding, {}, 1), schema)


def buffer_for(name):
    return SignalBuffer(
        name, "/topic", {"wrench": tuple("abcdef"), "tcp": tuple("abcdefg"), "joints": tuple("abcdef")}[name]
    )


def taken(name, chosen, payloads):
    """What a reader takes from payloads that lie in the middle of other bytes."""
    sink = buffer_for(name)
    take = signal_taker(SignalRole(name, "/topic", sink.columns), chosen, sink)
    for index, payload in enumerate(payloads):
        take(b"xyz" + payload + b"rest", 3, 3 + len(payload), index, index + 1)
    assert sink.faults.count == 0
    return sink.signal()


@given(
    st.sampled_from(["wrench", "tcp", "joints"]),
    st.lists(st.text(max_size=12).filter(lambda text: "\0" not in text), min_size=1, max_size=1),
    st.lists(st.floats(width=64), min_size=7, max_size=7),
    st.integers(0, 2**31 * 10**9 - 1),
)
def test_fast_and_general_readers_agree(name, frames, values, stamp_ns):
    """Whatever the numbers, the stamp and the length of frame_id: both ways give the same samples."""
    row = values[: 7 if name == "tcp" else 6]
    payload = bytes(store().serialize_cdr(ros_message(name, stamp_ns, row, frames[0]), KINDS[name]))
    fast = decoder(KINDS[name])
    assert fast.layout == JOINT_LAYOUT or fast.layout in VECTOR_LAYOUTS
    slow = Decoder(fast.kind, fast.encoding, fast.decode)
    quick, thorough = taken(name, fast, [payload] * 2), taken(name, slow, [payload] * 2)
    np.testing.assert_array_equal(quick.values, thorough.values)
    np.testing.assert_array_equal(quick.values[0], np.array(row))
    np.testing.assert_array_equal(quick.stamps.header, thorough.stamps.header)
    assert quick.stamps.header[0] == stamp_ns
    assert quick.frame == thorough.frame == frames[0]


@pytest.mark.parametrize("frame", ["", "f", "a longer frame", "ünïcode"])
@pytest.mark.parametrize("size", [(1, 1), (3, 5), (32, 24)])
def test_fast_and_general_images_agree(frame, size):
    """Fields and pixels of both image types are those that the general decoder gives."""
    image = picture(3, *size)
    payload = bytes(store().serialize_cdr(image_message(START, image, "rgb8", frame), KINDS["image"]))
    chosen = decoder(KINDS["image"])
    assert chosen.layout == IMAGE_LAYOUT
    message = chosen.decode(payload)
    fields = image_at(b"12345" + payload, 5, 5 + len(payload))
    names = ("encoding", "height", "width", "step")
    assert fields[:6] == (stamp_of(message), frame_of(message), *(getattr(message, name) for name in names))
    assert fields[6] == message.data.tobytes() == image.tobytes()
    jpeg = encoded(image, ".jpg")
    payload = bytes(store().serialize_cdr(compressed_message(START, jpeg, "jpeg", frame), KINDS["compressed"]))
    chosen = decoder(KINDS["compressed"])
    assert chosen.layout == COMPRESSED_LAYOUT
    assert compressed_at(payload, 0, len(payload)) == (START, frame, "jpeg", jpeg)
    assert chosen.decode(payload).data.tobytes() == jpeg


def test_cut_messages_never_reach_beyond_their_end():
    """A message that ends early is a fault, in every reader and for every length, never a neighbour's bytes."""
    for name in ("wrench", "tcp", "joints"):
        payload = bytes(
            store().serialize_cdr(ros_message(name, START, numbers(1, 7)[0][: 7 if name == "tcp" else 6]), KINDS[name])
        )
        for length in range(len(payload)):
            sink = buffer_for(name)
            signal_taker(SignalRole(name, "/topic", sink.columns), decoder(KINDS[name]), sink)(payload, 0, length, 1, 1)
            assert len(sink.log) == 0, (name, length)
            assert sink.faults.count == 1
    image = bytes(store().serialize_cdr(image_message(START, picture(1)), KINDS["image"]))
    jpeg = bytes(store().serialize_cdr(compressed_message(START, encoded(picture(1))), KINDS["compressed"]))
    for reader, payload in ((image_at, image), (compressed_at, jpeg)):
        for length in range(len(payload)):
            with pytest.raises(ValueError, match=r".+"):
                reader(payload, 0, length)


def test_big_endian_messages_are_read(tmp_path):
    """CDR of a big-endian machine goes the general way."""
    with Tape(tmp_path / "run.mcap") as tape:
        message = ros_message("wrench", START, [1, 2, 3, 4, 5, 6])
        payload = store().serialize_cdr(message, KINDS["wrench"], little_endian=False)
        text = schema_text(KINDS["wrench"]).encode()
        tape.raw(TOPICS["wrench"], START, payload, KINDS["wrench"], "ros2msg", "cdr", text)
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap")
    assert recording.signals["wrench"].values.tolist() == [[1, 2, 3, 4, 5, 6]]


def test_the_files_own_definition_counts(tmp_path):
    """A type that a file defines otherwise than ROS does is read as the file says, not as we remember it."""
    text = "float64 extra\nstd_msgs/Header header\ngeometry_msgs/Wrench wrench\n"
    rest = schema_text(KINDS["wrench"]).partition("=" * 80)[2]
    chosen = decoder(KINDS["wrench"], text + "=" * 80 + rest)
    assert chosen.layout not in VECTOR_LAYOUTS
    plain = bytes(store().serialize_cdr(ros_message("wrench", START, [1, 2, 3, 4, 5, 6], ""), KINDS["wrench"]))
    payload = plain[:4] + np.float64(7.0).tobytes() + plain[4:]
    signal = taken("wrench", chosen, [payload])
    assert signal.values.tolist() == [[1, 2, 3, 4, 5, 6]]


def test_a_definition_without_its_parts_is_completed():
    """Where the text leaves out what ROS itself defines, that is taken; what nobody defines is a clear reason."""
    chosen = decoder(KINDS["wrench"], "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n")
    assert chosen.layout in VECTOR_LAYOUTS
    with pytest.raises(BrokenLog, match="nowhere_msgs/msg/Thing is used and not defined"):
        decoder("a_msgs/msg/B", "nowhere_msgs/Thing thing\n")


def test_short_type_names():
    """Names without /msg/ mean the same type."""
    assert decoder("geometry_msgs/WrenchStamped", schema_text(KINDS["wrench"])).kind == "geometry_msgs/WrenchStamped"


@pytest.mark.parametrize(
    ("text", "schema_encoding"),
    [
        ("float64 x\n'''\nimport os\n", "ros2msg"),
        ("float64[3] __import__('os')\n", "ros2msg"),
        ('module a { const string N = "0), (0, 0))]; import os; x = [((1,"; struct B { long x[N]; }; };', "ros2idl"),
        ("module a { struct B { long x[-5]; }; };", "ros2idl"),
        ("a_msgs/B again\n", "ros2msg"),
        ("", "ros2idl"),
        ("float64[99999999999] x\n", "ros2msg"),
        ("int64 a\n---\nint64 b\n", "ros2msg"),
        ("\xff" * 10, "ros2msg"),
    ],
)
def test_hostile_definitions_are_refused(text, schema_encoding):
    """Text that would become code, endless types and nonsense are a clear reason, never an error of another kind."""
    name = "a_msgs/msg/B" if schema_encoding == "ros2msg" else "a/B"
    with pytest.raises(BrokenLog):
        decoder(name, text, schema_encoding)


@pytest.mark.parametrize("name", ["a_msgs/msg/B'); import os", "../../etc/passwd", "", "class", "a" * 5000])
def test_hostile_type_names_are_refused_or_harmless(name):
    """A type name from a stranger is a name or a reason."""
    try:
        chosen = decoder(name, "float64 x\n")
    except BrokenLog:
        return
    assert value_at(chosen.decode(b"\0\1\0\0" + np.float64(4.0).tobytes()), ("x",)) == 4.0


@pytest.mark.parametrize(
    "payload", [b"", b"{", b"[" * 100_000, b'{"data": 1}', b'{"data": "!!!", "format": "jpeg"}', b"\xff\xfe"]
)
def test_hostile_json_is_counted(tmp_path, payload):
    """JSON that does not parse, nests without end or lacks fields is counted as damage; the good message is read."""
    import base64
    import json

    good = {"timestamp": {"sec": 1, "nsec": 2}, "frame_id": "", "format": "jpeg"}
    good["data"] = base64.b64encode(encoded(picture(1), ".jpg")).decode()
    with Tape(tmp_path / "run.mcap") as tape:
        for index, content in enumerate((payload, json.dumps(good).encode())):
            tape.raw("/digit", START + index * STEP, content, "foxglove.CompressedImage", "jsonschema", "json", b"{}")
    [(recording, sink)] = read(FORMAT, tmp_path / "run.mcap")
    assert [image.header_ns for image in sink.images] == [1_000_000_002]
    [finding] = recording.findings
    assert (finding.code, finding.severity, finding.count) == ("undecodable-message", "damage", 1)
    assert finding.start_ns == START


def test_hostile_protobuf_is_counted(tmp_path):
    """A descriptor that is none is a reason; a message that is none is counted."""
    pytest.importorskip("mcap_protobuf")
    from generators.mcap_files import proto_file, proto_payload

    text = proto_file().SerializeToString()
    document = {"frame_id": "d", "format": "jpeg", "data": encoded(picture(1), ".jpg")}
    good = proto_payload("foxglove.CompressedImage", document)
    with Tape(tmp_path / "run.mcap") as tape:
        for payload in (b"\xff\xff\xff", good):
            tape.raw("/digit", START, payload, "foxglove.CompressedImage", "protobuf", "protobuf", text)
        tape.raw("/tactile", START, good, "foxglove.CompressedImage", "protobuf", "protobuf", b"\x0a\xff")
    [(recording, sink)] = read(FORMAT, tmp_path / "run.mcap")
    assert [image.encoding for image in sink.images] == ["jpeg"]
    assert codes(recording) == {"undecodable-message", "topics-not-read"}
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    assert "damaged" in {topic.name: topic.note for topic in FORMAT.inspect(source).topics}["/tactile"]


def test_paths_of_fields():
    """Paths lead through attributes, keys and indexes."""
    assert steps_of("effort[2]") == ("effort", 2)
    assert steps_of("a.b[0].c") == ("a", "b", 0, "c")
    assert value_at({"a": {"b": [{"c": 5}]}}, steps_of("a.b[0].c")) == 5
    for path in ("", "a..b", "a[", "a[-1]", "a.b()", "__import__('os')"):
        with pytest.raises(ValueError, match="no path"):
            steps_of(path)


def test_joint_order_is_by_name():
    """Names decide, exact ones before those with a prefix; two robots without names are refused."""
    from collections import Counter

    order = JointOrder((), Counter())
    names = (
        "elbow_joint",
        "wrist_1_joint",
        "shoulder_pan_joint",
        "wrist_3_joint",
        "shoulder_lift_joint",
        "wrist_2_joint",
    )
    assert order(names) == (2, 4, 0, 1, 5, 3)
    assert order(("finger_joint",)) is None
    assert order((*names, "left_elbow_joint")) == (2, 4, 0, 1, 5, 3)
    with pytest.raises(ValueError, match="joint_names"):
        order(("a_elbow_joint", "b_elbow_joint"))

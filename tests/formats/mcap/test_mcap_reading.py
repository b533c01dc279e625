"""MCAP recordings: what was written comes back, whatever encoded and however chunked it was."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from generators.collect import codes, read
from generators.mcap_files import (
    KINDS,
    SERIAL,
    START,
    STEP,
    TOPICS,
    Tape,
    description,
    encoded,
    foxglove_touch,
    numbers,
    picture,
    touch,
    tree_message,
)

from tactiledata.errors import BrokenLog, SchemaError
from tactiledata.formats.mcap.mcap import McapFormat
from tactiledata.formats.mcap.readers import UR_JOINTS
from tactiledata.ingest.pipeline import source_digest
from tactiledata.ingest.sources.discover import find_sources

FORMAT = McapFormat()
MAPPING = {"format": "tactiledata-mapping/1"}


def read_one(path, mapping=None):
    [(recording, sink)] = read(FORMAT, Path(path), mapping)
    return recording, sink.images


def rgb(image):
    return np.frombuffer(image.payload, np.uint8).reshape(image.height, image.width, 3)


@pytest.mark.parametrize("encoding", ["ros2msg", "ros2idl", "ros1"])
def test_round_trip_is_exact(tmp_path, encoding):
    """Signals, three clocks, pictures, trajectories and background come back as written, and nothing is found."""
    truth = touch(tmp_path / "run.mcap", encoding)
    recording, images = read_one(tmp_path / "run.mcap")
    assert set(recording.signals) == {"wrench", "ur_wrench", "tcp", "joints"}
    for name, signal in recording.signals.items():
        np.testing.assert_array_equal(signal.values, truth[name])
        for clock in ("log", "publish", "header"):
            np.testing.assert_array_equal(getattr(signal.stamps, clock), truth[clock])
    assert recording.signals["wrench"].frame == "robotiq_ft_frame_id"
    assert recording.signals["wrench"].units == ("N", "N", "N", "N m", "N m", "N m")
    assert len(images) == len(truth["pictures"])
    for index, image in enumerate(images):
        np.testing.assert_array_equal(rgb(image), truth["pictures"][index])
        assert (image.camera, image.sensor, image.encoding) == ("digit", SERIAL, "raw")
        assert image.header_ns == truth["header"][index * 4]
    np.testing.assert_array_equal(recording.references[SERIAL], truth["background"])
    assert [row.name for row in recording.trajectories] == ["t0", "t1"]
    assert recording.trajectories[1].extra == {"spot": 1}
    assert recording.host_clock == "auto"
    assert recording.findings == ()


@pytest.mark.parametrize("compression", ["none", "lz4", "zstd"])
@pytest.mark.parametrize("chunked", [True, False])
def test_chunking_changes_nothing(tmp_path, compression, chunked):
    """A log gives the same numbers chunked or not, compressed or not."""
    truth = touch(tmp_path / "run.mcap", compression=compression, use_chunking=chunked)
    recording, images = read_one(tmp_path / "run.mcap")
    np.testing.assert_array_equal(recording.signals["joints"].values, truth["joints"])
    assert len(images) == len(truth["pictures"])
    assert codes(recording) == (set() if chunked else {"crc-not-recorded"})


@pytest.mark.parametrize("options", [{"enable_crcs": False}, {"use_chunking": False}])
def test_missing_crcs_are_said_to_be_missing(tmp_path, options):
    """Without a CRC a recording is unverified, which is no damage; a CRC of the data section vouches for it again."""
    touch(tmp_path / "run.mcap", **options)
    recording, _ = read_one(tmp_path / "run.mcap")
    [finding] = recording.findings
    assert (finding.code, finding.severity) == ("crc-not-recorded", "info")
    touch(tmp_path / "vouched.mcap", **options | {"enable_crcs": True}, enable_data_crcs=True)
    assert read_one(tmp_path / "vouched.mcap")[0].findings == ()


@pytest.mark.parametrize("options", [{"use_statistics": False}, {"repeat_channels": False}, {"repeat_schemas": False}])
def test_a_poor_summary_is_made_up_for(tmp_path, options):
    """Where the summary does not list the channels, they are found in the data section."""
    truth = touch(tmp_path / "run.mcap", **options)
    recording, _ = read_one(tmp_path / "run.mcap")
    np.testing.assert_array_equal(recording.signals["wrench"].values, truth["wrench"])
    assert recording.trajectories
    assert SERIAL in recording.references


@pytest.mark.parametrize("encoding", ["protobuf", "json"])
def test_foxglove_types(tmp_path, encoding):
    """Protobuf and JSON recordings give images, poses and (by a mapping) wrenches."""
    if encoding == "protobuf":
        pytest.importorskip("mcap_protobuf")
    truth = foxglove_touch(tmp_path / "run.mcap", encoding)
    recording, images = read_one(tmp_path / "run.mcap", truth["mapping"])
    np.testing.assert_array_equal(recording.signals["wrench"].values, truth["wrench"])
    np.testing.assert_array_equal(recording.signals["tcp"].values, truth["tcp"])
    assert recording.signals["wrench"].stamps.header[1] == START + STEP
    assert recording.signals["tcp"].frame == "base"
    assert [image.payload for image in images if image.camera == "digit"] == truth["payloads"]
    raw = [image for image in images if image.camera == "tactile"]
    np.testing.assert_array_equal(rgb(raw[5]), truth["pictures"][5])


def test_the_robots_own_wrench_is_never_taken_for_the_robotiq(tmp_path):
    """UR's wrist sensor is ur_wrench; it becomes wrench only where a mapping says so."""
    with Tape(tmp_path / "run.mcap") as tape:
        for index in range(5):
            tape.signal("ur_wrench", START + index, START, [1, 2, 3, 4, 5, 6])
    recording, _ = read_one(tmp_path / "run.mcap")
    assert set(recording.signals) == {"ur_wrench"}
    mapping = {**MAPPING, "signals": {"wrench": {"topic": TOPICS["ur_wrench"]}}}
    assert set(read_one(tmp_path / "run.mcap", mapping)[0].signals) == {"wrench"}


def test_frames_are_not_mixed(tmp_path):
    """Two frame_ids in one wrench topic are refused, until a mapping says which one is meant; the others are damage."""
    with Tape(tmp_path / "run.mcap") as tape:
        for index in range(6):
            tape.signal("wrench", START + index, START, [index, 0, 0, 0, 0, 0], frame="a" if index % 3 else "b")
    with pytest.raises(BrokenLog, match=r"mixes frames: 'a' \(4 messages\), 'b' \(2 messages\)"):
        read_one(tmp_path / "run.mcap")
    mapping = {**MAPPING, "signals": {"wrench": {"topic": TOPICS["wrench"], "frame": "a"}}}
    recording, _ = read_one(tmp_path / "run.mcap", mapping)
    assert recording.signals["wrench"].values[:, 0].tolist() == [1, 2, 4, 5]
    [finding] = recording.findings
    assert (finding.code, finding.severity, finding.count) == ("foreign-frame", "damage", 2)


@pytest.mark.parametrize("prefix", ["", "ur5e_", "left/"])
def test_joints_go_by_name(tmp_path, prefix):
    """Joints are reordered by name, whatever their order, a prefix, a gripper beside them or between their messages."""
    names = [
        f"{prefix}{name}_joint" for name in ("wrist_3", "elbow", "shoulder_pan", "wrist_1", "shoulder_lift", "wrist_2")
    ]
    with Tape(tmp_path / "run.mcap") as tape:
        for index in range(4):
            tape.signal("joints", START + index, START, [9, 5, 2, 0, 3, 1, 4], names=["gripper", *names])
            tape.signal("joints", START + index, START, [7.0], names=["finger_joint"])
    recording, _ = read_one(tmp_path / "run.mcap")
    assert recording.signals["joints"].values.tolist() == [[0, 1, 2, 3, 4, 5]] * 4
    assert recording.findings == ()


def test_a_missing_joint_is_nan_and_said(tmp_path):
    """A joint that the messages lack is NaN and reported, never taken from a neighbour."""
    names = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint"]
    with Tape(tmp_path / "run.mcap") as tape:
        for index in range(3):
            tape.signal("joints", START + index, START, [0, 1, 2, 3, 4], names=names)
    recording, _ = read_one(tmp_path / "run.mcap")
    np.testing.assert_array_equal(recording.signals["joints"].values[0], [0, 1, 2, 3, 4, np.nan])
    assert {"missing-joint", "non-finite"} == codes(recording)


def test_two_arms_need_names(tmp_path):
    """Two robots in one topic are not guessed apart; joint_names picks one."""
    names = [f"{arm}_{name}" for arm in ("a", "b") for name in UR_JOINTS]
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("joints", START, START, range(12), names=names)
    with pytest.raises(BrokenLog, match="joint_names"):
        read_one(tmp_path / "run.mcap")
    mapping = {**MAPPING, "signals": {"joints": {"topic": "/joint_states", "joint_names": names[6:]}}}
    assert read_one(tmp_path / "run.mcap", mapping)[0].signals["joints"].values.tolist() == [[6, 7, 8, 9, 10, 11]]


def test_tcp_from_a_tree_of_transforms(tmp_path):
    """A mapping reads the pose between two frames out of /tf; other transforms are left alone."""
    poses = numbers(5, 7)
    with Tape(tmp_path / "run.mcap") as tape:
        for index, pose in enumerate(poses):
            entries = [("base", "link_1", pose[::-1]), ("base", "tool0_controller", pose)]
            tape.ros("/tf", START + index, tree_message(START, entries), KINDS["tf"])
    mapping = {**MAPPING, "signals": {"tcp": {"topic": "/tf", "frame": "base", "child_frame": "tool0_controller"}}}
    recording, _ = read_one(tmp_path / "run.mcap", mapping)
    np.testing.assert_array_equal(recording.signals["tcp"].values, poses)
    with pytest.raises(SchemaError, match="child_frame"):
        read_one(tmp_path / "run.mcap", {**MAPPING, "signals": {"tcp": {"topic": "/tf"}}})
    with pytest.raises(BrokenLog, match="a tree of transforms"):
        read_one(tmp_path / "run.mcap")


def test_ros1_sensor_without_header_has_no_header_stamp(tmp_path):
    """The ROS 1 driver's own type is read as wrench; without a header its stamps say so."""
    from generators.mcap_files import store

    make = store(True).types[KINDS["ft_sensor"]]
    with Tape(tmp_path / "run.mcap", "ros1") as tape:
        for index in range(4):
            tape.ros("/robotiq_ft_sensor", START + index, make(1.5, 2, 3, 4, 5, 6), KINDS["ft_sensor"])
    recording, _ = read_one(tmp_path / "run.mcap")
    assert recording.signals["wrench"].values.tolist() == [[1.5, 2, 3, 4, 5, 6]] * 4
    assert recording.signals["wrench"].stamps.header is None


def test_other_numbers_by_a_mapping(tmp_path):
    """Any numeric fields become a signal of the mapping's name; known columns get SI units."""
    touch(tmp_path / "run.mcap", count=4)
    mapping = {
        **MAPPING,
        "signals": {
            "speeds": {"topic": "/joint_states", "fields": ["velocity[0]", "velocity[5]"], "units": ["rad/s", "rad/s"]},
            "wrench": {
                "topic": TOPICS["ur_wrench"],
                "fields": [f"wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"],
                "units": ["mN"] * 3 + ["N mm"] * 3,
            },
        },
    }
    recording, _ = read_one(tmp_path / "run.mcap", mapping)
    assert recording.signals["speeds"].columns == ("velocity[0]", "velocity[5]")
    assert recording.signals["speeds"].units == ("rad/s", "rad/s")
    np.testing.assert_allclose(recording.signals["wrench"].values * 1000, numbers(4, 6, 2))


@pytest.mark.parametrize(
    ("signals", "match"),
    [
        ({"wrench": {"topic": "/joint_states"}}, "type sensor_msgs/JointState"),
        ({"speed": {"topic": "/joint_states"}}, "has no fields"),
        ({"wrench": {"topic": "/joint_states", "fields": ["effort[0]"]}}, "has 1 fields; expected 6"),
        ({"speed": {"topic": "/joint_states", "fields": ["velocity[x]"]}}, "no path of fields"),
        (
            {"tcp": {"topic": TOPICS["tcp"], "fields": [f"pose.position.{a}" for a in "xyzxyzx"], "units": ["K"] * 7}},
            "'K'",
        ),
        *(
            (
                {"speed": {"topic": "/joint_states", "fields": ["velocity[0]", "effort[0]"], "units": ["rad/s", left]}},
                r"\$\.signals\.speed\.units\[1\]: '[? ]*' is no unit.*write the field's unit.*or 1 where it has none",
            )
            for left in ("?", " ?? ")
        ),
    ],
)
def test_a_mapping_that_cannot_be_meant_is_refused(tmp_path, signals, match):
    """A mapping that contradicts the recording's types says where."""
    touch(tmp_path / "run.mcap", count=4)
    with pytest.raises(SchemaError, match=match):
        read_one(tmp_path / "run.mcap", {**MAPPING, "signals": signals})


def test_a_topic_that_is_not_there_is_said(tmp_path):
    """A mapping may name topics that one recording lacks: it is told, with near names."""
    touch(tmp_path / "run.mcap", count=4)
    mapping = {**MAPPING, "signals": {"tcp": {"topic": "/tcp_pose_broadcaster/poses"}}}
    recording, _ = read_one(tmp_path / "run.mcap", mapping)
    missing, left = sorted(recording.findings, key=lambda finding: finding.code)
    assert (missing.code, left.code) == ("missing-topic", "topics-not-read")
    assert "did you mean /tcp_pose_broadcaster/pose" in missing.message
    assert "is not read: /tcp_pose_broadcaster/pose. " in left.message
    assert "tcp" not in recording.signals


def test_a_wrench_in_another_frame_than_described_is_said(tmp_path):
    """The description's transforms belong to one frame; data in another one are kept with a warning."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, [0] * 6, frame="tool0")
        tape.describe({**description(), "wrench": {"frame": "robotiq_ft_frame_id"}})
    assert codes(read_one(tmp_path / "run.mcap")[0]) == {"wrench-frame"}


# bags and folders


def test_a_split_bag_is_one_recording(tmp_path):
    """The files of a rosbag2 folder are read in the order of its metadata, and belong to one source."""
    folder = tmp_path / "bag"
    folder.mkdir()
    values = numbers(30, 6)
    for part in range(3):
        with Tape(folder / f"bag_{part}.mcap") as tape:
            for index in range(part * 10, part * 10 + 10):
                tape.signal("wrench", START + index, START, values[index])
    metadata = {"storage_identifier": "mcap", "relative_file_paths": [f"bag_{part}.mcap" for part in range(3)]}
    (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": metadata}))
    [source] = FORMAT.sources(folder)
    assert [Path(name).name for name in source.files] == [*metadata["relative_file_paths"], "metadata.yaml"]
    recording, _ = read_one(folder)
    np.testing.assert_array_equal(recording.signals["wrench"].values, values)
    (folder / "bag_1.mcap").unlink()
    recording, _ = read_one(folder)
    assert {(finding.code, finding.severity) for finding in recording.findings} == {("missing-file", "damage")}
    (folder / "metadata.yaml").unlink()
    assert len(FORMAT.sources(folder)) == 1


def test_a_description_beside_a_bag_is_part_of_it(tmp_path):
    """`bag.yaml` beside the folder `bag` is one of its files: another description makes another recording."""
    folder = tmp_path / "bag"
    folder.mkdir()
    touch(folder / "bag_0.mcap", count=4)
    bare = FORMAT.sources(folder)[0]
    digests = [source_digest(bare)]
    for spot in (0, 1):
        (tmp_path / "bag.yaml").write_text(json.dumps(description("unit_7", spot)))
        [source] = FORMAT.sources(folder)
        assert [Path(name).name for name in source.files] == ["bag_0.mcap", "bag.yaml"]
        digests.append(source_digest(source))
    assert len(set(digests)) == 3
    assert find_sources([tmp_path])[1] == []
    assert source_digest(bare) == digests[0]


def test_independent_recordings_in_a_folder(tmp_path):
    """Files that do not belong together are sources of their own, in natural order, hidden files left out."""
    for name in ("run_10", "run_2", "run_1"):
        touch(tmp_path / f"{name}.mcap", count=4)
    (tmp_path / "._run_1.mcap").write_bytes(b"\0\5\x16\7")
    (tmp_path / "notes.txt").write_text("notes")
    assert FORMAT.sniff(tmp_path)
    assert [source.key.partition("/")[2] for source in FORMAT.sources(tmp_path)] == [
        "run_1.mcap",
        "run_2.mcap",
        "run_10.mcap",
    ]
    (tmp_path / "table.csv").write_text("1,2")
    assert not FORMAT.sniff(tmp_path)


def test_description_beside_the_recording(tmp_path):
    """A document beside the file describes it, names its background, and the mapping's description wins over it."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.compressed(START, START, encoded(picture(1), ".jpg"), frame="")
    (tmp_path / "run.yaml").write_text(json.dumps(description("unit_7", 1, "bg.png")))
    (tmp_path / "bg.png").write_bytes(encoded(picture(3)))
    mapping = {**MAPPING, "description": {"wrench": {"sign": "reaction"}}}
    recording, [image] = read_one(tmp_path / "run.mcap", mapping)
    assert image.sensor == "unit_7"
    assert recording.description.wrench == {"sign": "reaction"}
    np.testing.assert_array_equal(recording.references["unit_7"], picture(3))
    assert recording.trajectories[0].name == "t0"
    (tmp_path / "run.yaml").write_text(json.dumps(description("unit_7", 1, "../bg.png")))
    with pytest.raises(ValueError, match="leaves the folder"):
        read_one(tmp_path / "run.mcap")


# images


def test_compressed_bytes_stay_as_they_are(tmp_path):
    """JPEG and PNG bytes go through untouched, with their size from the header; rows and columns are not swapped."""
    payloads = [encoded(picture(index, 32, 24), suffix) for index, suffix in enumerate([".jpg", ".png", ".jpg"])]
    with Tape(tmp_path / "run.mcap") as tape:
        for payload, style in zip(payloads, ["jpeg", "png", "bgr8; jpeg compressed bgr8"], strict=True):
            tape.compressed(START, START, payload, style=style)
    _, images = read_one(tmp_path / "run.mcap")
    assert [image.payload for image in images] == payloads
    assert [(image.encoding, image.height, image.width) for image in images] == [
        ("jpeg", 32, 24),
        ("png", 32, 24),
        ("jpeg", 32, 24),
    ]


@pytest.mark.parametrize(
    ("encoding", "step"), [(order, step) for order in ("rgb8", "bgr8", "rgba8", "bgra8") for step in (None, 112)]
)
def test_raw_images_become_rgb(tmp_path, encoding, step):
    """Raw pixels become RGB without padding, whatever their order and row length."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.image(START, START, picture(5), encoding=encoding, step=step)
    _, [image] = read_one(tmp_path / "run.mcap")
    np.testing.assert_array_equal(rgb(image), picture(5))


@pytest.mark.parametrize(("encoding", "said"), [("rgb8", 0), ("bgr8", 0), ("rgba8", 2), ("bgra8", 2)])
def test_alpha_of_raw_images_is_said(tmp_path, encoding, said):
    """Raw images with an alpha channel are counted and named as such; those without are not."""
    with Tape(tmp_path / "run.mcap") as tape:
        for number in range(2):
            tape.image(START + number * STEP, START, picture(5), encoding=encoding)
    recording, _ = read_one(tmp_path / "run.mcap")
    alpha = [finding for finding in recording.findings if finding.code == "image-alpha"]
    assert sum(finding.count for finding in alpha) == said
    assert all(finding.severity == "warning" and "alpha channel" in finding.message for finding in alpha)


@pytest.mark.parametrize(
    ("shape", "factor", "code", "kept"),
    [((32, 24, 3), 257, "image-depth", "png"), ((32, 24, 3), 1, "image-encoding", "missing"),
     ((32, 24), 257, "image-encoding", "missing")],
)  # fmt: skip
def test_deep_pictures_in_messages_are_said(tmp_path, shape, factor, code, kept):
    """A 16-bit PNG in a message is read by its upper bits, and said; without upper bits or colours it is refused."""
    pixels = np.resize(picture(5), shape).astype(np.uint16) * factor
    payload = cv2.imencode(".png", pixels)[1].tobytes()
    with Tape(tmp_path / "run.mcap") as tape:
        tape.compressed(START, START, payload, style="png")
    recording, [image] = read_one(tmp_path / "run.mcap")
    [finding] = [finding for finding in recording.findings if finding.code.startswith("image-")]
    assert (finding.code, finding.count, image.encoding) == (code, 1, kept)
    assert finding.severity == ("warning" if kept == "png" else "damage")
    assert image.payload == (payload if kept == "png" else b"")


def test_a_wrong_channel_order_can_be_mended(tmp_path):
    """Where the stated encoding is wrong, a mapping says what the bytes are."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.image(START, START, picture(5)[:, :, ::-1], encoding="rgb8")
    mapping = {**MAPPING, "images": {"digit": {"topic": TOPICS["digit"], "channel_order": "bgr"}}}
    _, [image] = read_one(tmp_path / "run.mcap", mapping)
    np.testing.assert_array_equal(rgb(image), picture(5))


def test_images_that_cannot_be_used_keep_their_moment(tmp_path):
    """A picture of a wrong length, encoding or format is a missing one with a finding; the others are read."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.image(START, START, picture(1), payload=b"12345")
        tape.image(START + 1, START, picture(1), encoding="mono8")
        tape.image(START + 2, START, picture(1))
        tape.compressed(START + 3, START, b"GIF89a", topic="/digit/b")
        tape.compressed(START + 4, START, encoded(picture(2), ".jpg")[:-2], topic="/digit/b")
    recording, images = read_one(tmp_path / "run.mcap")
    assert [image.encoding for image in images] == ["missing", "missing", "raw", "missing", "jpeg"]
    assert [image.log_ns - START for image in images] == [0, 1, 2, 3, 4]
    assert codes(recording) == {"image-unreadable", "image-encoding", "image-truncated"}
    assert all(finding.severity == "damage" for finding in recording.findings)


@pytest.mark.parametrize(
    ("topic", "frame", "stated", "mapped", "serial", "severity"),
    [
        ("/digit/image_raw", "digit", (), "", "", None),
        ("/digit/D20542/image_raw", "digit", (), "", "D20542", None),
        ("/digit/image_raw", "digit_d20337", (), "", "D20337", None),
        ("/digit/image_raw", "digit", ("unit_7",), "", "unit_7", None),
        ("/digit/unit_7/image", "digit", ("unit_6", "unit_7"), "", "unit_7", None),
        ("/digit/D20542/image_raw", "digit", ("D20337",), "", "D20337", "damage"),
        ("/digit/D20542/image_raw", "digit", (), "D20001", "D20001", "warning"),
    ],
)
def test_who_took_the_images(tmp_path, topic, frame, stated, mapped, serial, severity):
    """The serial is the mapping's, the description's, frame_id's or the topic's; a contradiction is said."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.image(START, START, picture(1), topic=topic, frame=frame)
        if stated:
            sensors = {name: {"model": "digit"} for name in stated}
            tape.describe({"format": "tactiledata-log/1", "sensors": sensors})
    mapping = {**MAPPING, "images": {"digit": {"topic": topic, "sensor": mapped}}} if mapped else None
    recording, [image] = read_one(tmp_path / "run.mcap", mapping)
    assert image.sensor == serial
    said = [(finding.code, finding.severity) for finding in recording.findings if finding.code.startswith("serial-")]
    code = {"damage": "serial-conflict", "warning": "serial-overruled"}
    assert said == ([(code[severity], severity)] if severity else [])


def test_cameras_are_told_apart(tmp_path):
    """Tactile topics become digit and digit_2; a webcam is left out, and a compressed twin of a raw topic too."""
    with Tape(tmp_path / "run.mcap") as tape:
        for topic in ("/webcam/image_raw", "/digit/D20002/image_raw", "/digit/D20001/image_raw"):
            tape.image(START, START, picture(1), topic=topic)
        tape.compressed(START, START, encoded(picture(1), ".jpg"), topic="/digit/D20001/image_raw/compressed")
    _, images = read_one(tmp_path / "run.mcap")
    assert {(image.camera, image.sensor) for image in images} == {("digit", "D20001"), ("digit_2", "D20002")}
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    notes = {topic.name: topic.note for topic in FORMAT.inspect(source).topics}
    assert "nothing in its name says tactile" in notes["/webcam/image_raw"]
    assert "lossless" in notes["/digit/D20001/image_raw/compressed"]


# inspect


def test_inspect_suggests_a_mapping_that_reads_the_same(tmp_path):
    """The suggested mapping fits its schema and reads what the guess reads."""
    touch(tmp_path / "run.mcap")
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    inspection = FORMAT.inspect(source)
    roles = {topic.name: topic.role for topic in inspection.topics}
    assert roles == {TOPICS[name]: "image:digit" if name == "digit" else name for name in TOPICS}
    assert all(topic.example for topic in inspection.topics)
    guessed, _ = read_one(tmp_path / "run.mcap")
    mapped, _ = read_one(tmp_path / "run.mcap", inspection.suggested_mapping)
    assert set(guessed.signals) == set(mapped.signals)
    assert inspection.facts["trajectories"] == 2

"""Files that are no MCAP, or hold nothing to read: a clear error with a way out, and no error of another kind."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from generators.collect import codes, read
from generators.mcap_files import START, STEP, TOPICS, Tape, description, numbers, touch

from tactiledata.errors import BrokenLog, SchemaError, UnsafeContent
from tactiledata.formats.mcap.layout import MAGIC
from tactiledata.formats.mcap.mcap import McapFormat

FORMAT = McapFormat()


@pytest.mark.parametrize(
    ("name", "content", "match"),
    [
        ("empty.mcap", b"", r"is empty \(0 bytes\)"),
        ("text.mcap", b"hello, this is no recording", "begins with b'hello"),
        ("short.mcap", MAGIC[:5], "begins with"),
        ("magic.mcap", MAGIC, "has no topics"),
        ("zeros.mcap", bytes(100_000), "begins with"),
        ("head.mcap", MAGIC + bytes(100_000), "has no topics"),
        ("noise.mcap", MAGIC + np.random.default_rng(1).bytes(100_000), "has no topics"),
        ("run.mcap.zstd", b"\x28\xb5\x2f\xfd1234", "compressed as a whole"),
        ("run.mcap.zst", b"\x28\xb5\x2f\xfd1234", "zstd -d"),
        ("bag_0.db3", b"SQLite format 3\0", "ros2 bag convert"),
        ("old.bag", b"#ROSBAG V2.0\n", "ROS 1 bag"),
    ],
)
def test_what_is_no_mcap(tmp_path, name, content, match):
    """Each is claimed by its name, so that the reason is said instead of `no format knows it`."""
    path = tmp_path / name
    path.write_bytes(content)
    assert FORMAT.sniff(path)
    with pytest.raises(BrokenLog, match=match):
        read(FORMAT, path)
    [source] = FORMAT.sources(path)
    with contextlib.suppress(BrokenLog):
        assert FORMAT.inspect(source).findings


@pytest.mark.parametrize(
    ("name", "content"), [("a.csv", b"t,x\n"), ("b.bag", b"hello"), ("c.db3", b"hello"), (".x.mcap", MAGIC)]
)
def test_files_of_others_are_not_claimed(tmp_path, name, content):
    """A file of another kind, or a hidden one, is left to others."""
    (tmp_path / name).write_bytes(content)
    assert not FORMAT.sniff(tmp_path / name)
    assert not FORMAT.sniff(tmp_path)


def test_an_mcap_under_another_name_is_known_by_content(tmp_path):
    """The first bytes decide."""
    touch(tmp_path / "recording.bin", count=4)
    assert FORMAT.sniff(tmp_path / "recording.bin")
    assert read(FORMAT, tmp_path / "recording.bin")[0][0].signals


@pytest.mark.parametrize("options", [{}, {"use_chunking": False}, {"use_statistics": False}])
def test_a_recording_without_messages(tmp_path, options):
    """An empty bag has no topics, and says so."""
    with Tape(tmp_path / "run.mcap", **options):
        pass
    with pytest.raises(BrokenLog, match="has no topics"):
        read(FORMAT, tmp_path / "run.mcap")


def test_topics_without_messages(tmp_path):
    """Topics that were announced and never used: the error says that nothing came."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, numbers(1, 6)[0])
        tape.channel("/tcp_pose_broadcaster/pose", "x", "jsonschema", "json", b"{}")
    content = (tmp_path / "run.mcap").read_bytes()
    with Tape(tmp_path / "none.mcap") as tape:
        from generators.mcap_files import KINDS, schema_text

        tape.channel(TOPICS["wrench"], KINDS["wrench"], "ros2msg", "cdr", schema_text(KINDS["wrench"]).encode())
    assert content
    with pytest.raises(BrokenLog, match="not one message could be read"):
        read(FORMAT, tmp_path / "none.mcap")


def test_a_recording_without_known_topics_lists_them(tmp_path):
    """The error names the topics, why each is not read, and the mapping that would help."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.raw("/mouse", START, b"{}", "MouseEvent", "jsonschema", "json", b"{}")
        tape.raw("/odd", START, b"123", "a/B", "flatbuffer", "flatbuffer", b"")
        tape.signal("wrench", START, START, [0] * 6, topic="/lab/ft/wrench")
    with pytest.raises(BrokenLog, match="--suggest-mapping") as caught:
        read(FORMAT, tmp_path / "run.mcap")
    text = str(caught.value)
    assert "/mouse (MouseEvent)" in text
    assert "encoded as 'flatbuffer/flatbuffer'" in text
    assert "/lab/ft/wrench (geometry_msgs/WrenchStamped): not read: its name is none that is known" in text
    [source] = FORMAT.sources(tmp_path / "run.mcap")
    assert FORMAT.inspect(source).suggested_mapping["signals"] == {"wrench": {"topic": "/lab/ft/wrench"}}


def test_a_known_topic_in_an_unknown_encoding(tmp_path):
    """A wrench that cannot be decoded is counted where a mapping names it, and otherwise explained."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("tcp", START, START, numbers(1, 7)[0])
        tape.raw(TOPICS["wrench"], START, b"123", "geometry_msgs/msg/WrenchStamped", "ros2msg", "wrong_format", b"")
    mapping = {"format": "tactiledata-mapping/1", "signals": {"wrench": {"topic": TOPICS["wrench"]}}}
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert codes(recording) == {"undecodable-message", "empty-stream"}


def test_two_topics_that_could_be_the_wrench(tmp_path):
    """Two Robotiq sensors are not guessed apart."""
    with Tape(tmp_path / "run.mcap") as tape:
        for arm in ("left", "right"):
            tape.signal("wrench", START, START, [0] * 6, topic=f"/{arm}/robotiq_ft_wrench")
    with pytest.raises(BrokenLog, match="a mapping must say which one is meant"):
        read(FORMAT, tmp_path / "run.mcap")


def test_nan_and_odd_times_are_kept_and_said(tmp_path):
    """NaN stays NaN with a finding; times out of order and equal header stamps stay, for ingest to judge."""
    values = numbers(6, 6)
    values[2, 1] = np.nan
    log = [START + count * STEP for count in (0, 3, 1, 2, 2, 5)]
    with Tape(tmp_path / "run.mcap") as tape:
        for stamp_ns, row in zip(log, values, strict=True):
            tape.signal("wrench", stamp_ns, START, row)
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap")
    np.testing.assert_array_equal(recording.signals["wrench"].values, values)
    assert recording.signals["wrench"].stamps.log.tolist() == log
    assert set(recording.signals["wrench"].stamps.header.tolist()) == {START}
    [finding] = recording.findings
    assert (finding.code, finding.stream, finding.count, finding.start_ns) == ("non-finite", "wrench", 1, log[2])


def test_impossible_log_times_are_left_out(tmp_path):
    """A log time beyond 64-bit nanoseconds is counted, not wrapped around."""
    with Tape(tmp_path / "run.mcap") as tape:
        for stamp_ns in (START, 2**63 + 5, START + STEP):
            tape.signal("wrench", stamp_ns, START, [0] * 6, publish_ns=START)
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap")
    assert recording.signals["wrench"].stamps.log.tolist() == [START, START + STEP]
    assert ("bad-stamp", 1) in {(finding.code, finding.count) for finding in recording.findings}


@pytest.mark.parametrize(
    ("metadata", "error", "match"),
    [
        ({"storage_identifier": "sqlite3", "relative_file_paths": ["bag_0.db3"]}, BrokenLog, "ros2 bag convert"),
        (
            {"storage_identifier": "mcap", "relative_file_paths": ["../other/bag_0.mcap"]},
            UnsafeContent,
            "leaves the folder",
        ),
        ({"storage_identifier": "mcap", "relative_file_paths": ["/etc/passwd"]}, UnsafeContent, "leaves the folder"),
        ({"storage_identifier": "mcap", "relative_file_paths": ["bag_0.mcap"]}, BrokenLog, "none of the files"),
        (
            {"storage_identifier": "mcap", "relative_file_paths": ["bag_0.mcap.zstd"]},
            BrokenLog,
            "compressed as a whole",
        ),
        ({"storage_identifier": "mcap", "relative_file_paths": 5}, BrokenLog, "none of the files"),
        ({"storage_identifier": "mcap"}, BrokenLog, "none of the files"),
        ({"storage_identifier": "mcap", "compression_mode": "MESSAGE"}, BrokenLog, "compressed one by one"),
    ],
)
def test_folders_that_cannot_be_read(tmp_path, metadata, error, match):
    """A bag in another storage, files outside the folder, files that are not there."""
    folder = tmp_path / "bag"
    folder.mkdir()
    (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": metadata}))
    assert FORMAT.sniff(folder)
    with pytest.raises(error, match=match):
        read(FORMAT, folder)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"rosbag2_bagfile_information:\n", "holds nothing below"),
        (b"rosbag2_bagfile_information: 5\n", "holds nothing below"),
        (b"rosbag2_bagfile_information:\n  relative_file_paths: [a.mcap\n  version: 5", "not valid YAML"),
        (b"", "is empty"),
        (b"\0" * 40, "metadata.yaml"),
        (b"\xff\xfe rosbag2", "not UTF-8"),
        (b"- a\n- b\n", "holds no names"),
    ],
    ids=["no content", "a number", "cut", "empty", "zeros", "other bytes", "a list"],
)
@pytest.mark.parametrize("names", [("bag_0.mcap", "bag_1.mcap"), ("b.mcap", "a.mcap")])
def test_damaged_metadata_of_a_bag_is_said(tmp_path, content, words, names):
    """All files are read as one recording, by their names, with damage; a stranger's metadata.yaml is left alone."""
    folder = tmp_path / "bag"
    folder.mkdir()
    for name in names:
        touch(folder / name, count=4)
    (folder / "metadata.yaml").write_bytes(content)
    [source] = FORMAT.sources(folder)
    assert [Path(name).name for name in source.files] == [*sorted(names), "metadata.yaml"]
    [(recording, _)] = read(FORMAT, folder)
    said = [(one.code, one.severity) for one in recording.findings if one.code == "bag-metadata"]
    assert said == [("bag-metadata", "damage")]
    text = next(one.message for one in recording.findings if one.code == "bag-metadata")
    assert words in text
    assert "all 2 MCAP files" in text
    (folder / "metadata.yaml").write_text("operator: me\n")
    assert len(FORMAT.sources(folder)) == (1 if names[0] == "bag_0.mcap" else 2)
    for one in FORMAT.sources(folder):
        assert all("bag-metadata" not in codes(recording) for recording, _ in read(FORMAT, Path(one.path)))


def test_a_linked_file_outside_the_folder_is_refused(tmp_path):
    """A link is followed no farther than the folder."""
    touch(tmp_path / "outside.mcap", count=4)
    folder = tmp_path / "bag"
    folder.mkdir()
    (folder / "bag_0.mcap").symlink_to(tmp_path / "outside.mcap")
    metadata = {"storage_identifier": "mcap", "relative_file_paths": ["bag_0.mcap"]}
    (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": metadata}))
    with pytest.raises(UnsafeContent):
        read(FORMAT, folder)


def test_one_file_of_a_bag_is_no_mcap(tmp_path):
    """The others are read, and the loss is damage."""
    folder = tmp_path / "bag"
    folder.mkdir()
    touch(folder / "bag_0.mcap", count=4)
    (folder / "bag_1.mcap").write_bytes(b"")
    [(recording, _)] = read(FORMAT, folder)
    assert codes(recording) == {"unreadable-file"}


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_no_permission(tmp_path):
    """A file or folder that may not be read is a clear error."""
    touch(tmp_path / "run.mcap", count=4)
    (tmp_path / "run.mcap").chmod(0)
    with pytest.raises(BrokenLog, match="permission"):
        read(FORMAT, tmp_path / "run.mcap")


def test_a_file_that_cannot_be_opened(tmp_path, monkeypatch):
    """What the system refuses to open is a clear error, not a traceback."""
    touch(tmp_path / "run.mcap", count=4)
    before = Path.open

    def refuse(self, *arguments, **options):
        if self.name == "run.mcap":
            raise PermissionError(13, "Permission denied")
        return before(self, *arguments, **options)

    monkeypatch.setattr(Path, "open", refuse)
    assert FORMAT.sniff(tmp_path / "run.mcap")
    with pytest.raises(BrokenLog, match="Permission denied"):
        read(FORMAT, tmp_path / "run.mcap")


def test_documents_that_do_not_fit(tmp_path):
    """A faulty document beside the recording, or a faulty mapping, is refused with its place."""
    touch(tmp_path / "run.mcap", count=4)
    (tmp_path / "run.yaml").write_text("sensors: 5\n")
    with pytest.raises(SchemaError, match=r"sensors"):
        read(FORMAT, tmp_path / "run.mcap")
    (tmp_path / "run.yaml").write_text("- a\n")
    with pytest.raises(SchemaError, match="no mapping"):
        read(FORMAT, tmp_path / "run.mcap")
    (tmp_path / "run.yaml").unlink()
    with pytest.raises(SchemaError, match="colour"):
        read(FORMAT, tmp_path / "run.mcap", {"format": "tactiledata-mapping/1", "colour": 1})


def test_long_and_unicode_names(tmp_path):
    """Names of files, topics and frames are taken as they come."""
    name = "Versuch µ 測試 " + "x" * 150
    with Tape(tmp_path / f"{name}.mcap") as tape:
        tape.signal("wrench", START, START, [0] * 6, frame="räd " * 50, topic=f"/{'n' * 200}/robotiq_ft_wrench")
        tape.describe(description("ß" * 100))
    [(recording, _)] = read(FORMAT, tmp_path / f"{name}.mcap")
    assert recording.signals["wrench"].frame == "räd " * 50
    assert list(recording.description.sensors) == ["ß" * 100]

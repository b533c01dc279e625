"""What a recording holds and no topic is read as is said; what a mapping states is followed or refused."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from command import run_command
from generators.collect import codes, read
from generators.mcap_files import START, STEP, Tape, description, numbers, picture

from tactiledata.errors import SchemaError
from tactiledata.formats.mcap.mcap import McapFormat

FORMAT = McapFormat()
COUNT = 12


def recorded(path, topics):
    """A recording with the streams that are named, each on a topic."""
    with Tape(path) as tape:
        tape.describe(description(count=COUNT))
        for row in range(COUNT):
            log_ns = START + row * STEP
            for stream, topic in topics:
                if stream == "image":
                    tape.image(log_ns, log_ns, picture(row), topic=topic)
                else:
                    values = numbers(COUNT, 7 if stream == "tcp" else 6)[row]
                    if stream == "tcp":
                        values = np.concatenate([values[:3], [0, 0, 0, 1]])
                    tape.signal(stream, log_ns, log_ns, values, topic=topic)
    return path


def left(path, mapping=None):
    """Messages of the findings about topics that are left."""
    [(recording, _)] = read(FORMAT, path, mapping)
    return [one.message for one in recording.findings if one.code == "topic-left"]


@pytest.mark.parametrize(
    ("topics", "words"),
    [
        ([("image", "/digit/a"), ("wrench", "/ati/raw")], ["wrench", "/ati/raw"]),
        ([("image", "/digit/a"), ("wrench", "/a/ft"), ("wrench", "/b/ft")], ["wrench", "/a/ft, /b/ft"]),
        ([("image", "/digit/a"), ("tcp", "/tool/place")], ["tcp", "/tool/place"]),
        ([("wrench", "/robotiq_ft_wrench"), ("image", "/a/pic"), ("image", "/b/pic")], ["images", "/a/pic, /b/pic"]),
    ],
)
def test_a_stream_that_no_topic_is_read_as_is_said(tmp_path, topics, words):
    """A wrench, a pose or images under names that say too little: one warning with the topics, and what to do."""
    (message,) = left(recorded(tmp_path / "run.mcap", topics))
    assert all(word in message for word in [*words, "--suggest-mapping"])


def test_topics_that_nobody_reads_are_named(tmp_path):
    """Topics of whatever type that stay behind are counted and named, with or without a mapping."""
    topics = [("image", "/digit/a"), ("wrench", "/robotiq_ft_wrench"), ("wrench", "/other/ft"), ("tcp", "/tool/place")]
    path = recorded(tmp_path / "run.mcap", topics)

    def said(path, mapping=None):
        [(recording, _)] = read(FORMAT, path, mapping)
        return [(one.message, one.count) for one in recording.findings if one.code == "topics-not-read"]

    [(message, count)] = said(path)
    assert count == 2
    assert message.startswith("2 of 4 topics are not read: /other/ft, /tool/place. ")
    assert "--suggest-mapping" in message
    mapping = {"format": "tactiledata-mapping/1", "signals": {"tcp": {"topic": "/tool/place"}}}
    assert [count for _, count in said(path, mapping)] == [1]
    assert said(recorded(tmp_path / "all.mcap", topics[:2])) == []


def test_what_is_read_or_not_there_is_not_said(tmp_path):
    """With known names, or once a mapping names the topic, nothing is left; other wrenches do not count then."""
    topics = [("image", "/digit/a"), ("wrench", "/robotiq_ft_wrench"), ("wrench", "/other/ft"), ("image", "/webcam")]
    assert left(recorded(tmp_path / "known.mcap", topics)) == []
    own = recorded(tmp_path / "own.mcap", [("image", "/digit/a"), ("wrench", "/ati/raw")])
    mapping = {"format": "tactiledata-mapping/1", "signals": {"wrench": {"topic": "/ati/raw"}}}
    assert left(own, mapping) == []
    mapping["signals"]["wrench"]["topic"] = "/ati/rew"
    [(recording, _)] = read(FORMAT, own, mapping)
    assert codes(recording) >= {"missing-topic"}
    assert left(own, mapping) == []


def test_pictures_of_another_topic_than_mapped_are_damage(tmp_path):
    """They are not kept, so that the recording is damaged; where one mapped camera is found, nothing is said."""
    path = recorded(tmp_path / "run.mcap", [("image", "/digit/a"), ("wrench", "/robotiq_ft_wrench")])
    mapping = {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": "/no/such/camera"}}}
    [(recording, _)] = read(FORMAT, path, mapping)
    (found,) = [finding for finding in recording.findings if finding.code == "pictures-not-mapped"]
    assert found.severity == "damage"
    (topic,) = [word for word in found.message.replace(",", " ").split() if word.startswith("/")]
    mapping["images"]["other"] = {"topic": topic}
    [(recording, _)] = read(FORMAT, path, mapping)
    assert "pictures-not-mapped" not in codes(recording)


def test_stated_units_of_a_known_type_are_applied(tmp_path):
    """Units without fields hold for the numbers of the type: mN become N, and what is no force is refused."""
    path = recorded(tmp_path / "run.mcap", [("wrench", "/ati/raw")])
    mapping = {"format": "tactiledata-mapping/1", "signals": {"wrench": {"topic": "/ati/raw"}}}
    [(plain, _)] = read(FORMAT, path, mapping)
    mapping["signals"]["wrench"]["units"] = ["mN"] * 3 + ["N m"] * 3
    [(scaled, _)] = read(FORMAT, path, mapping)
    factors = [1e-3] * 3 + [1.0] * 3
    np.testing.assert_allclose(scaled.signals["wrench"].values, plain.signals["wrench"].values * factors, rtol=1e-12)
    mapping["signals"]["wrench"]["units"] = ["gf", "kgf", "lbf"] + ["N m"] * 3
    [(scaled, _)] = read(FORMAT, path, mapping)
    factors = [9.80665e-3, 9.80665, 4.4482216152605] + [1.0] * 3
    np.testing.assert_allclose(scaled.signals["wrench"].values, plain.signals["wrench"].values * factors, rtol=1e-12)
    for wrong in ("m", "g"):
        mapping["signals"]["wrench"]["units"][0] = wrong
        with pytest.raises(SchemaError, match=f"states '{wrong}' .*'N', or one of mN, kN, gf, kgf, lbf"):
            read(FORMAT, path, mapping)


def test_units_that_cannot_be_applied_are_refused(tmp_path):
    """Joints are found by name, so that a unit of their own cannot be applied; the usual one may be stated."""
    path = recorded(tmp_path / "run.mcap", [("joints", "/arm/states")])
    entry = {"topic": "/arm/states", "units": ["deg"] * 6}
    with pytest.raises(SchemaError, match="not applied"):
        read(FORMAT, path, {"format": "tactiledata-mapping/1", "signals": {"joints": entry}})
    entry["units"] = ["rad"] * 6
    [(recording, _)] = read(FORMAT, path, {"format": "tactiledata-mapping/1", "signals": {"joints": entry}})
    assert len(recording.signals["joints"].values) == COUNT


@pytest.mark.parametrize("serial", ["", " ", "\t", "../x", "a\nb"])
def test_a_serial_that_is_no_name_is_refused(tmp_path, serial):
    """A mapping's serial is a name as in a log.yaml: not blank, no path, no control characters."""
    path = recorded(tmp_path / "run.mcap", [("image", "/digit/a")])
    mapping = {"format": "tactiledata-mapping/1", "images": {"digit": {"topic": "/digit/a", "sensor": serial}}}
    with pytest.raises(SchemaError, match="sensor"):
        read(FORMAT, path, mapping)


def test_a_file_that_is_listed_twice_is_read_once(tmp_path):
    """A bag whose metadata name one file twice has each sample once, and that is said."""
    folder = tmp_path / "bag"
    folder.mkdir()
    recorded(folder / "bag_0.mcap", [("wrench", "/robotiq_ft_wrench")])
    facts = {"storage_identifier": "mcap", "relative_file_paths": ["bag_0.mcap", "bag_0.mcap"]}
    (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": facts}))
    [(recording, _)] = read(FORMAT, folder)
    assert len(recording.signals["wrench"].values) == COUNT
    assert "unlisted-file" in codes(recording)


def test_the_status_says_what_is_not_read(tmp_path, capsys):
    """Ingest, inspect and info say beside the status which stream is not read, and nothing where all are."""
    path = recorded(tmp_path / "run.mcap", [("image", "/digit/a"), ("tcp", "/tool/place"), ("wrench", "/ati/raw")])
    assert "status ok, but wrench, tcp not read" in run_command(capsys, "inspect", path)[1]
    assert "ok, but wrench, tcp not read" in run_command(capsys, "ingest", path, "--store", tmp_path / "ds.zarr")[1]
    said = run_command(capsys, "info", tmp_path / "ds.zarr")[1]
    assert "status: 1 ok; of 1 of them a wrench, tcp or images are not read" in said
    whole = recorded(tmp_path / "whole.mcap", [("image", "/digit/a"), ("wrench", "/robotiq_ft_wrench")])
    assert "not read" not in run_command(capsys, "inspect", whole)[1]
    run_command(capsys, "ingest", whole, "--store", tmp_path / "whole.zarr")
    assert "are not read" not in run_command(capsys, "info", tmp_path / "whole.zarr")[1]

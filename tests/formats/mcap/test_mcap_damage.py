"""Damaged MCAP files: everything that can be vouched for is recovered, and every loss is said with its span."""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from generators.collect import codes, read
from generators.mcap_files import START, STEP, TOPICS, Tape, description, encoded, long_touch, numbers, picture
from mcap.reader import make_reader
from mcap.writer import IndexType

from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap import chunks as chunk_module
from tactiledata.formats.mcap.layout import CHUNK_RECORD, HEAD, MAGIC, MESSAGE_RECORD
from tactiledata.formats.mcap.mcap import McapFormat

COUNT = 6600
FORMAT = McapFormat()


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Recordings of the same 6,600 wrenches, chunked and compressed in different ways: bytes and values by name."""
    folder = tmp_path_factory.mktemp("long")
    made = {}
    for name, options in {
        "zstd": {},
        "lz4": {"compression": "lz4"},
        "none": {"compression": "none"},
        "unchunked": {"chunked": False, "enable_data_crcs": True},
    }.items():
        values = long_touch(folder / f"{name}.mcap", count=COUNT, **options)
        made[name] = ((folder / f"{name}.mcap").read_bytes(), values)
    return made


def outcome(tmp_path, content):
    """Recording of a file with this content."""
    path = tmp_path / "harmed.mcap"
    path.write_bytes(content)
    [(recording, _)] = read(FORMAT, path)
    return recording


def damage(recording):
    return [finding for finding in recording.findings if finding.severity == "damage"]


def rows(recording):
    """Return the numbers of the rows that came back, by their log times."""
    return (recording.signals["wrench"].stamps.log - START) // STEP


def assert_true(recording, values):
    """Every sample is one that was written, none twice."""
    found = rows(recording)
    assert (np.diff(found) > 0).all()
    np.testing.assert_array_equal(recording.signals["wrench"].values, values[found])


def chunk_places(path_or_bytes):
    """Offset and length of the chunks' records, from the file's own index."""
    import io

    summary = make_reader(io.BytesIO(path_or_bytes)).get_summary()
    return [(index.chunk_start_offset, index.chunk_length) for index in summary.chunk_indexes]


def flipped(content, place, mask=0xFF):
    return content[:place] + bytes([content[place] ^ mask]) + content[place + 1 :]


def test_the_recording_is_the_one_of_the_table(recordings):
    """The recording has 6,600 messages in 151 chunks, as in the published measurement."""
    assert len(chunk_places(recordings["zstd"][0])) == 151


@pytest.mark.parametrize("name", ["zstd", "lz4", "none", "unchunked"])
def test_table_of_damage(recordings, tmp_path, name):
    """Cut, shortened, zeroed, flipped: all that is whole comes back, each with damage; undamaged files have none."""
    content, values = recordings[name]
    assert damage(outcome(tmp_path, content)) == []
    cut = content[: int(len(content) * 0.6)]

    recording = outcome(tmp_path, cut)
    assert_true(recording, values)
    assert 3900 <= len(rows(recording)) <= 4100
    assert "no-footer" in codes(recording)
    assert damage(recording)[-1].end_ns is None or damage(recording)[-1].end_ns >= START

    recording = outcome(tmp_path, content[:-100])
    assert len(rows(recording)) == COUNT
    assert {finding.code for finding in damage(recording)} == {"no-footer"}

    recording = outcome(tmp_path, cut + bytes(len(content) - len(cut)))
    assert_true(recording, values)
    assert 3900 <= len(rows(recording)) <= 4100
    assert damage(recording)

    place = int(len(content) * 0.45)
    recording = outcome(tmp_path, flipped(content, place))
    assert damage(recording)
    if name == "unchunked":
        # no CRC stands for a single message: nothing is dropped, and the whole recording is said not to be trusted
        assert "data-crc" in codes(recording) or len(rows(recording)) >= COUNT - 2
    else:
        assert_true(recording, values)
        lost = COUNT - len(rows(recording))
        [finding] = damage(recording)
        assert finding.code == "chunk-crc"
        assert 0 < lost == finding.count <= 44
        missing = np.setdiff1d(np.arange(COUNT), rows(recording))
        assert (finding.start_ns, finding.end_ns) == (START + STEP * missing[0], START + STEP * missing[-1])


def test_the_default_reader_of_the_package_would_not_have_said_so(recordings):
    """The reason for reading chunk by chunk: the usual reader passes a flipped byte on as data."""
    import io

    content, _ = recordings["none"]
    offset, length = chunk_places(content)[70]
    harmed = flipped(content, offset + length - 50)
    assert sum(1 for _ in make_reader(io.BytesIO(harmed)).iter_messages()) == COUNT


@pytest.mark.parametrize("name", ["zstd", "none"])
@pytest.mark.parametrize("field", ["record length", "inner length", "opcode", "compression"])
@pytest.mark.parametrize("has_summary", [True, False])
def test_a_damaged_chunk_head_costs_one_chunk_at_most(recordings, tmp_path, name, field, has_summary):
    """Damage before a chunk's data, with the index of the summary and without: at most that chunk is lost."""
    content, values = recordings[name]
    offset, _ = chunk_places(content)[70]
    place = (
        offset
        + {"record length": 3, "inner length": 9 + 32 + (4 if name == "zstd" else 0), "opcode": 0, "compression": 37}[
            field
        ]
    )
    harmed = flipped(content, place, 0x5A)
    recording = outcome(tmp_path, harmed if has_summary else harmed[:-40])
    assert_true(recording, values)
    assert COUNT - len(rows(recording)) in (0, 44)
    assert damage(recording)


def test_absurd_lengths_allocate_nothing(recordings, tmp_path):
    """A length of 2^60, or a chunk that claims to hold as much, is damage, not an allocation."""
    content, values = recordings["zstd"]
    offset, _ = chunk_places(content)[10]
    for place, size in ((1, 2**60), (9 + 16, 2**60), (9 + 16, 2**30), (9 + 16, 2**20)):
        harmed = content[: offset + place] + struct.pack("<Q", size) + content[offset + place + 8 :]
        for cut in (len(harmed), len(harmed) - 40):
            recording = outcome(tmp_path, harmed[:cut])
            assert_true(recording, values)
            assert len(rows(recording)) >= COUNT - 44
            assert damage(recording)


@pytest.mark.parametrize("claim", [2**10, 2**26])
def test_bombs_are_not_inflated(claim):
    """A zstd frame that inflates to more than its chunk says is refused before it is inflated."""
    import zstandard

    bomb = zstandard.compress(bytes(2**26))
    body = struct.pack("<QQQII", 1, 2, claim, 1, 4) + b"zstd" + struct.pack("<Q", len(bomb)) + bomb
    with pytest.raises(BrokenLog, match="zstd frame of" if claim != 2**26 else "CRC is"):
        chunk_module.chunk_content(body)


def test_a_torn_chunk_gives_nothing(recordings, tmp_path):
    """Of a chunk that the file's end tears nothing is taken, not even from an uncompressed one; its span is said."""
    content, values = recordings["none"]
    offset, length = chunk_places(content)[100]
    recording = outcome(tmp_path, content[: offset + length // 2])
    assert_true(recording, values)
    count = len(rows(recording))
    assert 0.65 * COUNT < count < 0.67 * COUNT
    [finding] = [finding for finding in damage(recording) if finding.code == "torn-chunk"]
    assert (finding.start_ns, finding.end_ns) == (START + STEP * count, START + STEP * (count + 43))


@pytest.mark.slow
def test_every_byte_of_a_small_file_may_be_flipped(tmp_path):
    """Whatever single byte is harmed: no error of another kind, no wrong sample without a word, nothing invented."""
    values = numbers(12, 6, 3)
    with Tape(tmp_path / "small.mcap", compression="none", chunk_size=700, enable_data_crcs=True) as tape:
        for index in range(12):
            tape.signal("wrench", START + STEP * index, START, values[index])
    content = (tmp_path / "small.mcap").read_bytes()
    for place in range(0, len(content), 7):
        try:
            recording = outcome(tmp_path, flipped(content, place))
        except BrokenLog:
            continue
        if not damage(recording):
            pytest.fail(f"byte {place} of {len(content)} was flipped and nothing was said")


def test_a_small_file_may_be_cut_anywhere(tmp_path):
    """Whatever length a file is cut to: a clear error or what is whole, and damage is said."""
    values = numbers(12, 6, 3)
    with Tape(tmp_path / "small.mcap", compression="lz4", chunk_size=700) as tape:
        for index in range(12):
            tape.signal("wrench", START + STEP * index, START, values[index])
    content = (tmp_path / "small.mcap").read_bytes()
    for length in range(0, len(content), 23):
        try:
            recording = outcome(tmp_path, content[:length])
        except BrokenLog:
            continue
        assert_true(recording, values)
        assert damage(recording)


def test_a_damaged_length_in_an_unchunked_file(recordings, tmp_path):
    """A message whose length swallows its neighbours is found out, and the neighbours are recovered."""
    content, values = recordings["unchunked"]
    place = content.index(HEAD.pack(MESSAGE_RECORD, 22 + 84), len(content) // 2)
    harmed = content[: place + 1] + struct.pack("<Q", 300) + content[place + 9 :]
    recording = outcome(tmp_path, harmed)
    assert_true(recording, values)
    assert len(rows(recording)) >= COUNT - 2
    assert "record-damaged" in codes(recording)


def test_the_number_of_lost_messages_comes_from_the_statistics(recordings, tmp_path):
    """Where no index counts what is lost, the file's own statistics do."""
    content, _ = recordings["unchunked"]
    place = content.index(HEAD.pack(MESSAGE_RECORD, 22 + 84), len(content) // 2)
    recording = outcome(tmp_path, content[:place] + bytes(1060) + content[place + 1060 :])
    assert {finding.code for finding in damage(recording)} == {"record-damaged", "lost-bytes"}
    assert sum(finding.count for finding in damage(recording)) == COUNT - len(rows(recording))


def test_messages_of_a_lost_channel_are_counted(recordings, tmp_path):
    """Where the only record of a channel is lost, its messages are counted as damage, not forgotten."""
    content, _ = recordings["zstd"]
    offset, length = chunk_places(content)[0]
    path = tmp_path / "harmed.mcap"
    path.write_bytes(flipped(content, offset + length - 20)[:-60])
    with pytest.raises(BrokenLog, match="has no topics"):
        read(FORMAT, path)


def test_the_summary_is_checked(recordings, tmp_path):
    """A summary whose CRC does not fit is not used, and said; the messages are all there."""
    content, _ = recordings["zstd"]
    recording = outcome(tmp_path, flipped(content, len(content) - 60))
    assert len(rows(recording)) == COUNT
    assert {finding.code for finding in damage(recording)} == {"summary-crc"}


def test_a_damaged_head_is_survived(recordings, tmp_path):
    """A file whose first bytes are gone is known by its end."""
    content, values = recordings["zstd"]
    recording = outcome(tmp_path, bytes(8) + content[8:])
    assert_true(recording, values)
    assert "bad-magic" in codes(recording)


@pytest.mark.parametrize("name", ["zstd", "unchunked"])
@pytest.mark.parametrize("behind", [b"m", b"more", bytes(5000)])
def test_something_behind_the_end(recordings, tmp_path, name, behind):
    """Bytes behind the closing magic are counted, with their place; what stands before them is read in full."""
    content, values = recordings[name]
    recording = outcome(tmp_path, content + behind)
    assert len(rows(recording)) == COUNT
    assert_true(recording, values)
    [finding] = damage(recording)
    assert finding.code == "bytes-behind-end"
    count = "1 byte follows" if len(behind) == 1 else f"{len(behind)} bytes follow"
    assert f"{count} the end of the recording at byte {len(content)} " in finding.message
    assert "not begin as an MCAP file does" in finding.message


def test_conflicting_definitions(tmp_path):
    """A channel that is defined twice with different content is reported; twice with the same, it is not."""
    with Tape(tmp_path / "run.mcap", use_chunking=False) as tape:
        tape.signal("wrench", START, START, [1, 2, 3, 4, 5, 6])
    content = (tmp_path / "run.mcap").read_bytes()
    place = content.index(b"\x04", content.index(TOPICS["wrench"].encode()) - 20)
    length = struct.unpack_from("<Q", content, place + 1)[0]
    record = content[place : place + 9 + length]
    other = record.replace(b"robotiq", b"robotik")
    for twin, expected in ((record, set()), (other, {"conflicting-record"})):
        recording = outcome(tmp_path, content[: place + 9 + length] + twin + content[place + 9 + length : -40])
        assert codes(recording) - {"no-footer", "crc-not-recorded", "no-data-end"} == expected


def test_a_damaged_description_or_background_is_said(tmp_path):
    """A metadata record that is no description, an attachment with a wrong CRC: findings; the numbers are read."""
    background = encoded(picture(1))
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, [1, 2, 3, 4, 5, 6])
        tape.describe(description(background="bg.png"), {"bg.png": background})
    content = (tmp_path / "run.mcap").read_bytes()
    recording = outcome(tmp_path, flipped(content, content.index(background) + 60))
    assert recording.references == {}
    assert codes(recording) == {"background-broken"}
    recording = outcome(tmp_path, content.replace(b"tactiledata-log/1", b"tactiledata-log/9"))
    assert codes(recording) == {"bad-description"}
    assert recording.description.is_empty


@pytest.mark.parametrize("has_summary", [True, False])
@pytest.mark.parametrize("is_harmed", [True, False])
def test_two_recordings_in_a_row_are_not_taken_for_one(recordings, tmp_path, has_summary, is_harmed):
    """Of two MCAP files that were joined, the first is read, and a finding gives the commands that part them."""
    content, _ = recordings["zstd"]
    other = recordings["lz4"][0] if has_summary else without_summary(tmp_path)
    offset, length = chunk_places(content)[70]
    first = flipped(content, offset + length // 2) if is_harmed else content
    path = tmp_path / "joined.mcap"
    path.write_bytes(first + other)
    [(recording, _)] = read(FORMAT, path)
    told = {finding.code: finding for finding in damage(recording)}
    assert set(told) == {"bytes-behind-end", *(["chunk-crc"] if is_harmed else [])}
    assert len(rows(recording)) == COUNT - (told["chunk-crc"].count if is_harmed else 0)
    message = told["bytes-behind-end"].message
    assert f"{len(other)} bytes follow the end of the recording at byte {len(first)} " in message
    [source] = FORMAT.sources(path)
    assert message in [finding.message for finding in FORMAT.inspect(source).findings]
    subprocess.run(message.partition("split them there: ")[2], shell=True, cwd="/", check=True)
    assert not path.exists()
    assert (tmp_path / "joined-1.mcap").read_bytes() == first
    assert (tmp_path / "joined-2.mcap").read_bytes() == other


def without_summary(tmp_path):
    """Content of a short recording that has no index at its end."""
    options = {
        "index_types": IndexType.NONE,
        "repeat_channels": False,
        "repeat_schemas": False,
        "use_statistics": False,
        "use_summary_offsets": False,
    }
    with Tape(tmp_path / "plain.mcap", **options) as tape:
        tape.signal("wrench", START, START, [1, 2, 3, 4, 5, 6])
    content = (tmp_path / "plain.mcap").read_bytes()
    assert int.from_bytes(content[-28:-20], "little") == 0, "it has a summary"
    return content


def test_a_cut_file_is_to_be_copied_again(recordings, tmp_path):
    """Wherever it was cut, the message says so once; a whole file without topics is to be recorded again."""
    content, _ = recordings["zstd"]
    [finding] = [one for one in outcome(tmp_path, content[:-100]).findings if one.code == "no-footer"]
    assert finding.message.endswith("Copy it again from where it was recorded")
    with pytest.raises(BrokenLog) as caught:
        outcome(tmp_path, content[:60])
    assert str(caught.value).count("Copy it again") == 1
    assert caught.value.remedy == "Copy it again from where it was recorded."
    with Tape(tmp_path / "none.mcap"):
        pass
    with pytest.raises(BrokenLog) as caught:
        read(FORMAT, tmp_path / "none.mcap")
    assert caught.value.remedy == "Record it again."


def test_damage_is_found_by_inspect_too(recordings, tmp_path):
    """Inspect plays the whole file and says the same."""
    content, _ = recordings["lz4"]
    path = Path(tmp_path / "harmed.mcap")
    offset, length = chunk_places(content)[70]
    path.write_bytes(flipped(content, offset + length // 2))
    [source] = FORMAT.sources(path)
    assert [finding.code for finding in FORMAT.inspect(source).findings] == ["chunk-crc"]


def test_layout_constants():
    """What is searched for is what the package writes."""
    assert len(MAGIC) == 8
    assert HEAD.size == 9
    assert CHUNK_RECORD == 6


def test_a_background_that_is_not_there_is_damage(tmp_path):
    """A background that the description names and that is neither attached nor beside the recording is said."""
    with Tape(tmp_path / "run.mcap") as tape:
        tape.signal("wrench", START, START, [1, 2, 3, 4, 5, 6])
        tape.describe(description(background="bg.png"))
    recording = outcome(tmp_path, (tmp_path / "run.mcap").read_bytes())
    assert {(finding.code, finding.severity) for finding in recording.findings} == {("background-missing", "damage")}

"""Records that a thread reads ahead: the same as read one by one, and never two large chunks at once."""

from __future__ import annotations

import time

import pytest
from generators.mcap_files import long_touch

from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap import chunks
from tactiledata.formats.mcap.chunks import AHEAD_BYTES, MOST_RECORDS, chunk_content, read_ahead
from tactiledata.formats.mcap.layout import CHUNK_RECORD, MAGIC, MESSAGE_RECORD
from tactiledata.formats.mcap.records import Landmarks, Record, RecordWalker


def walked(path):
    """Every record of a file, read one by one."""
    with path.open("rb") as stream:
        return list(RecordWalker(stream, path.stat().st_size, Landmarks()))


def content_of(record):
    """What a record holds, decompressed on the spot; the words of its fault where it has one."""
    if not isinstance(record, Record) or record.opcode != CHUNK_RECORD:
        return None
    try:
        return chunk_content(record.body)
    except BrokenLog as fault:
        return fault.found


@pytest.mark.parametrize("options", [{}, {"compression": "lz4"}, {"chunked": False}], ids=str)
@pytest.mark.parametrize("is_harmed", [False, True], ids=["whole", "harmed"])
def test_records_come_as_if_read_one_by_one(tmp_path, options, is_harmed):
    """Order, contents and faults are those of a plain walk, for chunks and for bare messages."""
    path = tmp_path / "long.mcap"
    long_touch(path, count=1500, **options)
    if is_harmed:
        content = bytearray(path.read_bytes())
        content[len(MAGIC) + len(content) // 3] ^= 0xFF
        path.write_bytes(content)
    plain = walked(path)
    found = list(read_ahead(iter(plain)))
    assert [record for record, _ in found] == plain
    assert len(plain) > 2 * MOST_RECORDS or "chunked" not in options
    words = [content.found if isinstance(content, BrokenLog) else content for _, content in found]
    assert words == [content_of(record) for record in plain]


@pytest.mark.parametrize("is_large", [False, True], ids=["usual", "large"])
def test_nothing_is_read_beside_a_large_chunk(tmp_path, monkeypatch, is_large):
    """While a reader has the content of a chunk, what is behind it is drawn, but not where the chunk is large."""
    path = tmp_path / "long.mcap"
    long_touch(path, count=600)
    plain = walked(path)
    monkeypatch.setattr(chunks, "ENOUGH_BYTES", 1)
    if is_large:
        monkeypatch.setattr(chunks, "AHEAD_BYTES", 0)
    drawn: list[int] = []
    source = (drawn.append(place) or record for place, record in enumerate(plain))
    chunks_met = 0
    for place, (_, content) in enumerate(read_ahead(source)):
        if content is None:
            continue
        chunks_met += 1
        limit = time.monotonic() + (0.02 if is_large else 5.0)
        while drawn[-1] == place and time.monotonic() < limit:
            time.sleep(0.001)
        assert (drawn[-1] == place) == is_large
    assert chunks_met > 3


def test_large_records_are_not_read_together():
    """Messages of some MB that lie in no chunk are drawn one by one, and the next only where memory has room for it."""
    drawn = []
    source = (drawn.append(place) or Record(MESSAGE_RECORD, place, 0, bytes(AHEAD_BYTES + 1)) for place in range(4))
    for place, _ in enumerate(read_ahead(source)):
        time.sleep(0.02)
        assert drawn == list(range(place + 1))


def test_an_error_of_the_source_reaches_the_reader():
    """What is raised while records are drawn ahead is raised to the reader, who has had all records before."""

    def source():
        yield from (Record(MESSAGE_RECORD, place, 0, b"") for place in range(MOST_RECORDS))
        raise OSError("the disk is gone")

    met = []
    reader = (met.append(record.offset) for record, _ in read_ahead(source()))
    with pytest.raises(OSError, match="the disk is gone"):
        list(reader)
    assert met == list(range(MOST_RECORDS))

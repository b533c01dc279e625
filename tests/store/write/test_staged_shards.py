"""Files of raw frames of a staged take become shards as they are; every other case copies, to the same bytes."""

from __future__ import annotations

import numpy as np
import pytest

from tactiledata.store.layout.batch import Batch
from tactiledata.store.layout.images import ShardAppender
from tactiledata.store.layout.shards import pack_frame, shard_bytes

CAPACITY = 4


@pytest.mark.parametrize("before", [0, 1], ids=["at-a-border", "inside-a-shard"])
@pytest.mark.parametrize("order", [[0, 1, 2, 3], [1, 0, 2, 3], [0, 1, 2]], ids=str)
@pytest.mark.parametrize("has_links", [True, False], ids=["links", "no-links"])
@pytest.mark.parametrize("is_tried_before", [False, True], ids=["first", "again"])
def test_shards_have_the_same_bytes_linked_or_copied(tmp_path, monkeypatch, before, order, has_links, is_tried_before):
    """A shard has the bytes that copying gives; a spool file of a whole shard, in its order, is linked."""
    rng = np.random.default_rng(7)
    chunks = [pack_frame(rng.integers(0, 255, 200, np.uint8).tobytes()) for _ in range(CAPACITY + before)]
    spool, first = tmp_path / "spool", tmp_path / "first"
    first.write_bytes(b"".join(chunks[CAPACITY:]))
    spool.write_bytes(b"".join(chunks[:CAPACITY]))
    lengths = np.array([len(chunk) for chunk in chunks])
    starts = np.cumsum(lengths[:CAPACITY]) - lengths[:CAPACITY]
    if not has_links:
        monkeypatch.setattr("pathlib.Path.hardlink_to", lambda *_: (_ for _ in ()).throw(OSError("none here")))
    for attempt in range(1 + is_tried_before):
        with Batch(tmp_path / "store") as batch:
            appender = ShardAppender(batch, "rgb", CAPACITY, 0)
            if before:
                appender.append(first, np.zeros(1, np.int64), lengths[CAPACITY:])
            rows = appender.append(spool, starts[order], lengths[order])
            appender.close()
            if attempt == is_tried_before:
                batch.publish()
            else:
                batch.__exit__(OSError, None, None)
    assert rows.tolist() == list(range(before, before + len(order)))
    wanted = [*chunks[CAPACITY:], *(chunks[place] for place in order)]
    files = sorted((tmp_path / "store/rgb").iterdir())
    parts = [wanted[start : start + CAPACITY] for start in range(0, len(wanted), CAPACITY)]
    assert [file.read_bytes() for file in files] == [shard_bytes(part, CAPACITY) for part in parts]
    is_linked = spool.stat().st_nlink == 2
    assert is_linked == (has_links and not before and order == [0, 1, 2, 3])

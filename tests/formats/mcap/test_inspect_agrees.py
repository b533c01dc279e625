"""`inspect` and `read` say the same: what is read of a topic, in which frame, and what was wrong with it."""

from __future__ import annotations

import numpy as np
import pytest
from generators.collect import read
from generators.mcap_files import START, STEP, TOPICS, Tape, numbers, picture, touch

from tactiledata.errors import BrokenLog
from tactiledata.formats.mcap.mcap import McapFormat

FORMAT = McapFormat()
MAPPING = {"format": "tactiledata-mapping/1"}


def wrench_tape(path, frames):
    """A wrench topic whose messages state these frames; returns its values."""
    values = numbers(len(frames), 6)
    with Tape(path) as tape:
        for index, frame in enumerate(frames):
            tape.signal("wrench", START + index * STEP, START, values[index], frame=frame)
        tape.signal("tcp", START, START, numbers(1, 7)[0])
    return values


def mapped(frame):
    return {**MAPPING, "signals": {"wrench": {"topic": TOPICS["wrench"], "frame": frame}}}


def inspected(path, mapping=None):
    [source] = FORMAT.sources(path)
    inspection = FORMAT.inspect(source, mapping)
    return {topic.name: topic for topic in inspection.topics}, list(inspection.findings)


def test_a_mapping_names_the_frame_of_messages_without_one(tmp_path):
    """Messages that state no frame_id are in the frame that the mapping names, and that is said."""
    values = wrench_tape(tmp_path / "run.mcap", [""] * 5)
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapped("ft"))
    np.testing.assert_array_equal(recording.signals["wrench"].values, values)
    assert recording.signals["wrench"].frame == "ft"
    [finding] = recording.findings
    assert (finding.code, finding.severity, finding.count) == ("frame-stated", "info", 5)


def test_of_messages_with_and_without_a_frame_the_foreign_ones_alone_are_refused(tmp_path):
    """Another frame_id is refused as before; that some messages state none is then a warning."""
    values = wrench_tape(tmp_path / "run.mcap", ["", "ft", "b", ""])
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapped("ft"))
    np.testing.assert_array_equal(recording.signals["wrench"].values, values[[0, 1, 3]])
    found = {finding.code: (finding.severity, finding.count) for finding in recording.findings}
    assert found == {"foreign-frame": ("damage", 1), "frame-in-part": ("warning", 2)}


@pytest.mark.parametrize(
    ("frames", "frame"),
    [(["a"] * 4, "a"), (["a"] * 4, "b"), (["a", "b", "a", ""], "a"), ([""] * 4, "ft"), (["a"] * 4, None)],
)
def test_inspect_and_read_agree(tmp_path, frames, frame):
    """Inspecting and reading give the same signals and findings; a topic that is not read is not shown as read."""
    wrench_tape(tmp_path / "run.mcap", frames)
    mapping = mapped(frame) if frame else None
    rows, findings = inspected(tmp_path / "run.mcap", mapping)
    [(recording, _)] = read(FORMAT, tmp_path / "run.mcap", mapping)
    assert {topic.role for topic in rows.values()} - {""} == set(recording.signals)
    assert findings == list(recording.findings)
    kept = recording.signals.get("wrench")
    note = rows[TOPICS["wrench"]].note
    if kept is None:
        assert "not one of its messages can be read" in note
    else:
        assert (f"of {len(frames)} can be read" in note) == (len(kept.values) < len(frames))


def test_a_whole_recording_has_the_same_findings_in_both(tmp_path):
    """Pictures, signals and the background of a recording with lost pictures are judged alike."""
    touch(tmp_path / "run.mcap", count=8)
    with Tape(tmp_path / "odd.mcap") as tape:
        tape.image(START, START, picture(1), encoding="bgr8", payload=b"123")
        tape.image(START + STEP, START, picture(1))
        tape.signal("joints", START, START, [np.nan] * 6)
    for name in ("run.mcap", "odd.mcap"):
        _, findings = inspected(tmp_path / name)
        [(recording, _)] = read(FORMAT, tmp_path / name)
        assert findings == list(recording.findings)
    assert {finding.code for finding in findings} == {"image-unreadable", "non-finite"}


def test_inspect_says_that_read_would_refuse_mixed_frames(tmp_path):
    """A signal whose messages state two frames stops `read`; `inspect` shows it as damage in the same words."""
    wrench_tape(tmp_path / "run.mcap", ["a", "b"])
    _, findings = inspected(tmp_path / "run.mcap")
    with pytest.raises(BrokenLog) as caught:
        read(FORMAT, tmp_path / "run.mcap")
    assert [(finding.code, finding.message) for finding in findings] == [("mixed-frames", str(caught.value))]

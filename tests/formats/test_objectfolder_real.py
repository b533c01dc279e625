"""ObjectFolder-Real: natural order, trials that are no numbers, folders that are missing."""

import numpy as np
import pytest
from generators import objectfolder_real
from generators.collect import codes, read

from tactiledata.errors import BrokenLog
from tactiledata.formats.objectfolder_real import ObjectFolderRealFormat

FORMAT = ObjectFolderRealFormat()


def write(folder, **faults):
    """A fake of three objects."""
    return objectfolder_real.write(folder, np.random.default_rng(8), **faults)


def test_objects_trials_and_frames_in_natural_order(tmp_path):
    """Objects are read as 1, 2, 10, trials as trajectories, frames 0 … 11 by number, PNG bytes as they came."""
    root = write(tmp_path)
    taken = read(FORMAT, root)
    assert [recording.source.key.split("/")[-1] for recording, _ in taken] == ["1", "2", "10"]
    recording, sink = taken[2]
    assert [touch.name for touch in recording.trajectories] == ["object_10-trial_1", "object_10-trial_2"]
    wanted = [f"{trial}/0/gelsight/{frame}.png" for trial in (1, 2) for frame in range(12)]
    assert [image.name for image in sink.images] == wanted
    for image in sink.images:
        assert image.payload == (root / "10/tactile_data" / image.name).read_bytes()
        assert image.encoding == "png"
    assert recording.trajectories[0].extra["sensor_in_corpus"] == "gelsight"
    assert {"nominal-rate", "sensor-model-unsure", "not-read"} == codes(recording)


def test_one_object_can_be_named(tmp_path):
    """An object's own folder is a source."""
    ((recording, _),) = read(FORMAT, write(tmp_path) / "2")
    assert recording.trajectories[0].indenter == "object_2"


def test_trials_that_are_no_numbers_are_left_out_and_said(tmp_path):
    """A trial named otherwise is not read, and the finding names it with the number of its images."""
    recording, sink = read(FORMAT, write(tmp_path, odd_trial="3_bad"))[0]
    (found,) = [finding for finding in recording.findings if finding.code == "trial-name"]
    assert "3_bad" in found.message
    assert len(sink.images) == 24


def test_missing_folders_are_said(tmp_path):
    """A trial without gelsight/ is a finding; an object without tactile data is a broken log of its own."""
    root = write(tmp_path, missing_trial=True, empty_object=True)
    sources = {source.key.split("/")[-1]: source for source in FORMAT.sources(root)}
    assert set(sources) == {"1", "2", "10", "55"}
    recording, _ = read(FORMAT, root / "1")[0]
    assert "folder-missing" in codes(recording)
    with pytest.raises(BrokenLog, match="nothing to read"):
        FORMAT.inspect(sources["55"])


def test_gaps_keep_their_time(tmp_path):
    """A missing frame number leaves its gap in time, and is said; without gap nothing is said."""
    recording, sink = read(FORMAT, write(tmp_path, gap=5))[0]
    times = [image.log_ns for image in sink.images[:11]]
    assert times == [row * 10**9 // 30 for row in range(12) if row != 5]
    assert "frame-gap" in codes(recording)


def test_jpeg_copies_are_left_out_and_said(tmp_path):
    """The JPEGs that T3's script leaves beside the PNGs are not read twice."""
    recording, sink = read(FORMAT, write(tmp_path, copies=True))[0]
    assert "converted-copies" in codes(recording)
    assert len(sink.images) == 24


def test_broken_images_are_said(tmp_path):
    """A cut PNG is kept and reported; a file that is no picture is a moment without image, and reported."""
    recording, sink = read(FORMAT, write(tmp_path, cut=True, odd_image=True))[0]
    assert {"image-truncated", "image-unreadable"} <= codes(recording)
    assert [image.encoding for image in sink.images].count("missing") == 2
    assert len(sink.images) == 24

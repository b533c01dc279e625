"""A store that was written before stray sizes were marked says so, and how to get the marks."""

import cv2
import numpy as np
import pytest
from copied_trees import copy_tree

from tactiledata.contract.take import FrameFlag
from tactiledata.ingest.pipeline import ingest
from tactiledata.ingest.trajectories import assemble
from tactiledata.store.check.check import check
from tactiledata.store.read.reader import Store


@pytest.fixture
def log(tiny_folders, tmp_path):
    """A recording of which one picture is larger than the others."""
    folder = tmp_path / "log"
    copy_tree(tiny_folders[0], folder)
    place = sorted(one for one in (folder / "frames").rglob("*") if one.suffix in (".jpg", ".png"))[3]
    picture = cv2.imread(str(place))
    cv2.imwrite(str(place), np.repeat(np.repeat(picture, 2, axis=0), 2, axis=1))
    return folder


def unmarked(store):
    return [finding for finding in check(store) if finding.code == "store-unmarked-size"]


@pytest.mark.slow
def test_marks_that_are_missing_are_said_and_come_with_replace(log, tmp_path, monkeypatch):
    """The store of before is whole with a warning; the command that the warning names takes it away."""
    place = tmp_path / "ds.zarr"
    with monkeypatch.context() as before:
        before.setattr(assemble, "mark_strays", lambda frames, names: (frames, []))
        ingest([log], place)
    (finding,) = unmarked(place)
    assert (finding.severity, finding.count) == ("warning", 1)
    assert "is 640 x 480 (rows x columns), most are 320 x 240" in finding.message
    assert "--replace" in finding.message
    ingest([log], place, replace=True)
    flags = Store.open(place).frames(["flags"])["flags"].to_numpy()
    assert np.count_nonzero(flags & FrameFlag.STRAY_SIZE) == 1
    assert unmarked(place) == []


@pytest.mark.slow
def test_marked_and_even_sizes_are_not_named(log, tiny_store, tmp_path):
    """Negative control: a store of today, with a stray or without one, has nothing to say."""
    ingest([log], tmp_path / "ds.zarr")
    assert unmarked(tmp_path / "ds.zarr") == []
    assert unmarked(tiny_store) == []
